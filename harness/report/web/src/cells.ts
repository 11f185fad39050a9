import { Data, Group, title, variantLabel, varying } from "./data";
import { h, section } from "./dom";

type Listed = { id: string; seed: string; problem: string };

function link(cell: Listed): HTMLElement {
  const text = cell.seed ? `seed ${cell.seed}` : cell.id;
  if (!cell.problem) {
    return h("a", { class: "cell", id: `cell-${cell.id}`, href: `../cells/${cell.id}/`, title: cell.id }, text);
  }
  return h("span", { class: "cell broken", id: `cell-${cell.id}`, title: cell.id, tabindex: 0 },
    `\u26a0 ${text}: ${cell.problem}`);
}

function row(data: Data, group: Group, names: string[], shows: (group: number) => string | null): HTMLElement {
  const index = data.groups.indexOf(group);
  const view = shows(index);
  const parameters = Object.entries(group.parameters).map(([name, value]) => `${name} = ${value}`).join(", ");
  return h("tr", { id: `group-${index}`, tabindex: -1 },
    h("th", { scope: "row" }, title(data, group.method), group.reference ? " (reference)" : ""),
    h("td", {}, variantLabel(group.parameters, names)),
    h("td", {}, view ? h("a", { href: view }, "look at it") : "not on this page"),
    h("td", { class: "seeds" }, ...group.cells.map(link)),
    h("td", {}, h("details", {}, h("summary", {}, "all parameters"), parameters)));
}

/** Every cell of the run, with what is wrong with it. `shows` links a group to its images. */
export function cells(data: Data, shows: (group: number) => string | null): HTMLElement {
  const names = varying(data.groups);
  const others = data.otherCells.map((cell) => h("tr", {},
    h("th", { scope: "row" }, cell.method ? `${title(data, cell.method)}, part of the reference` : "error budget"),
    h("td", {}, cell.parameters.rays_per_pixel ? `rays_per_pixel ${cell.parameters.rays_per_pixel}` : ""),
    h("td", {}), h("td", { class: "seeds" }, link({ ...cell, seed: "" })), h("td", {})));
  const head = ["method", "parameters", "images", "cells", ""].map((text) => h("th", { scope: "col" }, text));
  return section("cells", "Cells",
    h("p", {}, "What was rendered: one cell for each method, its parameters and seed. Links open a cell's " +
      "folder: layers.exr with all layers and cell.json with everything that determines them."),
    h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Cells" },
      h("table", {}, h("thead", {}, h("tr", {}, ...head)),
        h("tbody", {}, ...data.groups.map((group) => row(data, group, names, shows)), ...others))));
}
