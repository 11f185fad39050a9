// The viewer's buttons and lists, kept equal to its state.
import { Data } from "./data";
import { button, h } from "./dom";
import { Catalogue, layerTitle } from "./panels";
import { State, scales } from "./state";

export interface Controls { element: HTMLElement; sync: (state: State) => void }
type Update = (change: Partial<State>) => void;

function list(label: string, options: (state: State) => [string, string][], get: (state: State) => string,
  set: (value: string) => void): Controls {
  const select = h("select", { change: () => set(select.value) });
  const element = h("label", { class: "control" }, h("span", {}, label), select);
  let shown = "";
  return {
    element,
    sync: (state) => {
      const now = options(state);
      const key = JSON.stringify(now);
      if (key !== shown) {
        select.replaceChildren(...now.map(([value, text]) => h("option", { value }, text)));
        shown = key;
      }
      select.value = get(state);
      element.hidden = now.length < 2;
    },
  };
}

function pair(value: string, text: string): [string, string] { return [value, text]; }

function exposure(update: Update): Controls {
  const slider = h("input", {
    type: "range", min: -8, max: 8, step: 0.25, "aria-label": "exposure in stops",
    input: () => update({ stops: Number(slider.value) }),
  });
  const text = h("output", {});
  const element = h("label", { class: "control" }, h("span", {}, "exposure"), slider, text);
  return {
    element,
    sync: (state) => {
      slider.value = String(state.stops);
      text.textContent = `${state.stops > 0 ? "+" : ""}${state.stops} EV`.replace("-", "\u2212");
    },
  };
}

function modes(update: Update): Controls {
  const names: [State["mode"], string, string][] = [
    ["grid", "side by side", "g"], ["flip", "flip", "f"], ["slider", "slider", "s"]];
  const buttons = names.map(([mode, text, key]) =>
    button(text, () => update({ mode }), { title: `key ${key}`, "data-mode": mode }));
  return {
    element: h("div", { class: "buttons", role: "group", "aria-label": "Arrangement" }, ...buttons),
    sync: (state) => buttons.forEach((element) =>
      element.setAttribute("aria-pressed", String(element.dataset.mode === state.mode))),
  };
}

function closeups(data: Data, catalogue: Catalogue, update: Update): Controls {
  const jump = (index: number) => {
    const { rectangle: [x, y, width, height], select, stage } = data.closeups[index]!;
    const zoom = Math.max(1, Math.min(data.frame.width / width, data.frame.height / height));
    const fits = (group: number) => Object.entries(select).every(([name, value]) =>
      (data.groups[group]!.parameters[name] ?? value) === value);
    const set = catalogue.sets.find((candidate) => candidate.layers.length > 0 && candidate.panels("radiance")
      .filter((panel) => !data.groups[panel.group]!.reference).every((panel) => fits(panel.group)));
    const layer = stage === "unfiltered" && set?.layers.includes("radiance_unfiltered") ? "radiance_unfiltered" : "radiance";
    update({ zoom, x: x + width / 2, y: y + height / 2, layer, ...(set ? { show: set.key } : {}) });
  };
  const boxes = h("input", { type: "checkbox", change: () => update({ boxes: boxes.checked }) });
  const element = h("div", { class: "closeups" },
    h("span", {}, "closeups: "),
    ...data.closeups.map((row, i) => button(row.label, () => jump(i), { title: `${row.figure}, row ${i + 1}` })),
    button("whole image", () => update({ zoom: 1 }), { title: "key 0" }),
    data.closeups.length > 0 && h("label", { class: "control" }, boxes, h("span", {}, "show them")));
  return { element, sync: (state) => { boxes.checked = state.boxes; } };
}

export function controls(data: Data, catalogue: Catalogue, update: Update): Controls {
  const set = (state: State) => catalogue.find(state.show);
  const panels = (state: State) => set(state)?.panels(state.layer).map((panel, i) => pair(String(i), `${i + 1} ${panel.label}`)) ?? [];
  const all: Controls[] = [
    list("show", () => catalogue.sets.map(({ key, label }) => pair(key, label)), (state) => set(state)?.key ?? "", (show) => update({ show })),
    list("layer", (state) => (set(state)?.layers ?? []).map((name) => pair(name, layerTitle(name))), (state) => state.layer, (layer) => update({ layer })),
    list("as", () => [pair("image", "image"), pair("false", "false colour"), pair("signed", "difference, signed"),
      pair("relative", "difference, relative"), pair("angle", "RGB angle to the reference")],
      (state) => state.as, (as) => update({ as: as as State["as"] })),
    modes(update),
    list("image", (state) => (state.mode === "grid" ? [] : panels(state)), (state) => String(state.active), (active) => update({ active: Number(active) })),
    list("against", (state) => (state.mode === "slider" ? panels(state) : []), (state) => String(state.left), (left) => update({ left: Number(left) })),
    exposure(update),
    list("tone curve", () => [pair("clamp", "none (clamped)"), pair("reinhard", "Reinhard"), pair("filmic", "filmic")],
      (state) => state.curve, (curve) => update({ curve: curve as State["curve"] })),
    list("scale of errors", () => scales.map((scale) => pair(String(scale), `\u00b1${scale}`)), (state) => String(state.scale), (scale) => update({ scale: Number(scale) })),
    closeups(data, catalogue, update),
  ];
  return {
    element: h("div", { class: "controls" }, ...all.map(({ element }) => element)),
    sync: (state) => all.forEach((one) => one.sync(state)),
  };
}
