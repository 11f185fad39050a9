// What the series are filtered by, kept equal to the state.
import { button, h } from "../dom";
import { Catalogue } from "./catalogue";
import { Update } from "./detail";
import { Field, State, defaults, fields, verdicts } from "./state";

const verdictTexts: Record<(typeof verdicts)[number], string> = {
  "": "any", open: "worse, not intended", WORSE: "worse", BETTER: "better", CHANGED: "changed", none: "no step",
};

export interface Filters { element: HTMLElement; sync: (state: State) => void }

function list(label: string, options: [string, string][], get: (state: State) => string, set: (value: string) => void): Filters {
  const select = h("select", { "data-filter": label, change: () => set(select.value) }, ...options.map(([value, text]) => h("option", { value }, text)));
  return { element: h("label", { class: "control" }, h("span", {}, label), select), sync: (state) => {
    select.value = get(state);
    if (select.selectedIndex < 0) { // of an address: what is not there leaves nothing, and says so
      select.append(h("option", { value: get(state) }, `${get(state)} (not there)`));
      select.value = get(state);
    }
  } };
}

export function filters(catalogue: Catalogue, current: () => State, update: Update): Filters {
  const byField = (field: Field): Filters[] => {
    const values = catalogue.valuesOf(field);
    if (values.length < 2) return [];
    return [list(field, [["", "all"], ...values.sort().map((value): [string, string] => [value, value])], (state) => state.only[field],
      (value) => update({ only: { ...current().only, [field]: value } }))];
  };
  const text = h("input", { type: "search", placeholder: "words in names", "aria-label": "Only series with these words", "data-filter": "text", input: () => update({ text: text.value }) });
  const floors = h("input", { type: "checkbox", "data-filter": "floors", change: () => update({ floors: floors.checked }) });
  const hasFloors = catalogue.history.series.some(({ noise_floor }) => noise_floor !== null && noise_floor > 0);
  const all: Filters[] = [
    ...fields.flatMap(byField),
    list("verdict", verdicts.map((verdict): [string, string] => [verdict, verdictTexts[verdict]]), (state) => state.verdict,
      (value) => update({ verdict: verdicts.find((known) => known === value) ?? "" })),
    { element: h("label", { class: "control" }, text), sync: (state) => { if (text.value !== state.text) text.value = state.text; } },
    { element: h("label", { class: "control", hidden: !hasFloors, title: "each error divided by what the noise of its own scene's reference leaves of it" }, floors, h("span", {}, "errors in noise floors")),
      sync: (state) => { floors.checked = state.floors; } },
  ];
  const { only, verdict, text: words } = defaults;
  const clear = button("no filter", () => update({ only: { ...only }, verdict, text: words }));
  return {
    element: h("div", { class: "controls filters", role: "search" }, ...all.map(({ element }) => element), clear),
    sync: (state) => all.forEach((one) => one.sync(state)),
  };
}
