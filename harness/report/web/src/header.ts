import { Data, fact } from "./data";
import { h } from "./dom";

const sections: [string, string][] = [
  ["viewer", "Images"], ["lobes", "SH lobes"], ["plots", "Plots"], ["tables", "Tables"],
  ["figures", "Figures"], ["cells", "Cells"],
];

function facts(data: Data): [string, string][] {
  const software = fact(data, "device", "rasteriser") === "software";
  const size = Array.isArray(data.run?.resolution) ? (data.run.resolution as number[]).join("\u00d7") : "";
  const list: [string, string][] = [
    ["Experiment", fact(data, "experiment")],
    ["Scene", [fact(data, "scene", "name"), fact(data, "view") && `view ${fact(data, "view")}`, size]
      .filter(Boolean).join(", ")],
    ["Probe", fact(data, "probe", "description")],
    ["Device", fact(data, "device", "renderer") + (software ? " (software rasteriser)" : "")],
    ["Driver", fact(data, "device", "driver")],
    ["Clock", fact(data, "timing", "clock")],
    ["Commit", fact(data, "commit")],
    ["Reference", fact(data, "reference", "verdict")],
  ];
  return list.filter(([, value]) => value);
}

function notices(data: Data): Node[] {
  const warnings = Array.isArray(data.run?.warnings) ? (data.run.warnings as unknown[]).map(String) : [];
  const calibration = fact(data, "timing", "calibration");
  if (calibration.includes("not believed")) warnings.push(calibration);
  const box = (role: string, heading: string, texts: string[]) => texts.length > 0 &&
    h("div", { class: `notice ${role}`, role: role === "problem" ? "alert" : "note" },
      h("strong", {}, heading), h("ul", {}, ...texts.map((text) => h("li", {}, text))));
  return [
    box("problem", data.complete ? "Problems" : "Incomplete", data.problems),
    box("warning", "Warnings", warnings),
    data.leftOut.length > 0 && h("details", { class: "notice left-out" },
      h("summary", {}, "Not all images are on this page, for its size; occlab report --megabytes takes more"),
      h("ul", {}, ...data.leftOut.map((text) => h("li", {}, text)))),
  ].filter((node): node is HTMLDivElement | HTMLDetailsElement => Boolean(node));
}

function goTo(id: string): (event: Event) => void {
  return (event) => {
    event.preventDefault(); // the address keeps the view
    const target = document.getElementById(id);
    target?.scrollIntoView({ behavior: "smooth" });
    target?.querySelector<HTMLElement>("h2")?.focus();
  };
}

export function header(data: Data, present: Set<string>): HTMLElement {
  const incomplete = !data.complete && h("span", { class: "badge" }, "incomplete");
  return h("header", {},
    h("h1", {}, fact(data, "title") || fact(data, "experiment") || "Run without run.json", " ", incomplete),
    h("dl", { class: "facts" }, ...facts(data).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
    ...notices(data),
    h("nav", { "aria-label": "Sections" }, ...sections.filter(([id]) => present.has(id))
      .map(([id, text]) => h("a", { href: `#${id}`, click: goTo(id) }, text))));
}
