// The numbers under the cursor, of all images at once.
import { Data } from "./data";
import { Reading } from "./display";
import { h } from "./dom";
import { short, signed } from "./numbers";
import { Panel } from "./panels";

export type Line = { panel: Panel; reading: Reading | string };

function value(number: number): HTMLElement {
  // As exact as a half is: its integers and fractions have at most 11 bits.
  return h("td", { class: "number", "data-value": String(number) }, short(number, 5));
}

function row({ panel, reading }: Line): HTMLElement {
  const head = h("th", { scope: "row" }, h("span", { class: "swatch", style: `background: ${panel.colour}` }), panel.label);
  if (typeof reading === "string") return h("tr", {}, head, h("td", { colspan: 7, class: "missing" }, reading));
  const values = reading.values.map(value);
  while (values.length < 3) values.push(h("td", {}));
  const optional = (number: number | undefined, spell: (value: number) => string) =>
    h("td", { class: "number" }, number === undefined ? "" : Number.isNaN(number) ? "\u2013" : spell(number));
  return h("tr", { "data-layer": panel.layer.id }, head, ...values,
    optional(reading.luminance, (v) => short(v, 4)), optional(reading.difference, (v) => signed(v)),
    optional(reading.relative, (v) => `${signed(v * 100)} %`), optional(reading.angle, (v) => `${short(v, 3)}\u00b0`));
}

/** The table of a pixel; `step` > 1 where not every pixel is stored. */
export function readout(data: Data, lines: Line[], pixel: [number, number] | null, pinned: boolean): HTMLElement {
  const channels = lines.some(({ reading }) => typeof reading !== "string" && reading.values.length === 3);
  const heads = [pixel ? `pixel ${pixel[0]}, ${pixel[1]}${pinned ? " (pinned)" : ""}` : "pixel",
    channels ? "R" : "value", channels ? "G" : "", channels ? "B" : "", "Y / mean", "\u0394", "\u0394 relative", "RGB angle"];
  const steps = [...new Set(lines.map(({ panel }) => panel.layer.step).filter((step) => step > 1))];
  const notes = [
    !pixel && "Point at an image to read the values of all of them; click to keep a pixel, arrow keys with Shift move it.",
    steps.length > 0 && `Of ${steps.map((step) => `${step}\u00d7${step}`).join(", ")} pixels one is stored: values are of the nearest stored one above left.`,
    ...new Set(lines.map(({ panel }) => panel.layer.note && `${panel.label}: ${panel.layer.note}.`)),
  ].filter((note): note is string => Boolean(note));
  return h("div", { class: "readout", "data-mean": String(data.frame.meanLuminance) },
    h("div", { class: "scroll" },
      h("table", {}, h("thead", {}, h("tr", {}, ...heads.map((text, i) => h("th", { scope: "col", class: i > 0 ? "number" : undefined }, text)))),
        h("tbody", {}, ...lines.map(row)))),
    ...notes.map((note) => h("p", { class: "note" }, note)));
}
