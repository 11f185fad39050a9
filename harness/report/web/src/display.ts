// How a panel's layer is shown, what its colours mean and what its numbers are.
import { Data } from "./data";
import { h } from "./dom";
import { short, signed } from "./numbers";
import { Panel } from "./panels";
import { Pixels, valuesAt } from "./planes";
import { Display, falseColourStops, relativeFloor } from "./shader";
import { State } from "./state";

export const angleScale = 30; // degrees

const own: Record<string, Display> = { share: "share", direction: "direction", signed: "signed_map", positive: "positive_map" };

/** Nothing where the chosen view does not exist for the layer, such as a difference without a reference. */
export function displayOf(panel: Panel, state: State): Display | null {
  const { kind } = panel.layer;
  if (kind === "signed" || kind === "positive" || kind === "direction") return own[kind]!;
  if (state.as === "image") return own[kind] ?? "tone";
  if (state.as === "false") return kind === "radiance" ? "false" : "positive_map";
  if (!panel.reference || (state.as === "angle" && kind !== "radiance")) return null;
  return state.as;
}

/** The end of the colour scale: the same for all images. */
export function scaleOf(panel: Panel, display: Display, state: State): number {
  if (display === "angle") return angleScale;
  return display === "positive_map" && panel.layer.kind === "share" ? 1 : state.scale;
}

export function luminance(values: number[]): number {
  return values.length === 1 ? values[0]! : 0.2126 * values[0]! + 0.7152 * values[1]! + 0.0722 * values[2]!;
}

/** In degrees; NaN where one of the two is black. */
export function angle(a: number[], b: number[]): number {
  const [ax, ay, az] = a as [number, number, number], [bx, by, bz] = b as [number, number, number];
  const cross = Math.hypot(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx);
  const dot = ax * bx + ay * by + az * bz;
  return cross === 0 && dot === 0 ? NaN : (Math.atan2(cross, dot) * 180) / Math.PI;
}

/** What differences of a layer are divided by: shares are differences of shares. */
export function unitOf(panel: Panel, data: Data): number {
  return panel.layer.kind === "radiance" ? data.frame.meanLuminance : 1;
}

export interface Reading { values: number[]; luminance?: number; difference?: number; relative?: number; angle?: number }

/** The numbers behind a panel's pixel. */
export function readingAt(panel: Panel, data: Data, pixels: Pixels, reference: Pixels | null, x: number, y: number): Reading {
  const values = valuesAt(pixels, x, y);
  const reading: Reading = { values };
  if (panel.layer.kind === "radiance") reading.luminance = luminance(values) / data.frame.meanLuminance;
  if (!reference || !panel.reference) return reading;
  const other = valuesAt(reference, x, y), unit = unitOf(panel, data);
  const difference = luminance(values) - luminance(other);
  reading.difference = difference / unit;
  reading.relative = difference / Math.max(luminance(other), relativeFloor * unit);
  if (values.length === 3) reading.angle = angle(values, other);
  return reading;
}

function bar(colours: string[], ticks: string[], caption: string): HTMLElement {
  const stops = colours.filter((_, i) => i % 16 === 0 || i === colours.length - 1).join(", ");
  return h("div", { class: "legend" },
    h("span", { class: "bar", style: `background-image: linear-gradient(to right, ${stops})` }),
    h("span", { class: "ticks" }, ...ticks.map((tick) => h("span", {}, tick))),
    h("span", { class: "legend-caption" }, caption));
}

/** The colour scale of a display: the same for all images on it. */
export function legend(display: Display, panel: Panel, state: State, data: Data): HTMLElement {
  const { signed: signedMap, positive } = data.colourMaps;
  const share = panel.layer.kind === "share" || panel.layer.owner === "march";
  const unit = share ? "" : " in mean luminances of the reference";
  const ends = (scale: number, suffix = "") =>
    [-scale, -scale / 2, 0, scale / 2, scale].map((tick) => signed(tick) + suffix);
  const rising = (scale: number, suffix = "") => [0, 0.25, 0.5, 0.75, 1].map((tick) => short(tick * scale) + suffix);
  switch (display) {
    case "false": {
      const [from, to] = falseColourStops;
      const ticks = [from, from + 3, 0, to].map((stop) => (stop < 0 ? `1/${2 ** -stop}` : String(2 ** stop)));
      return bar(positive, ticks, "luminance in mean luminances of the reference, logarithmic");
    }
    case "signed": return bar(signedMap, ends(state.scale), `luminance minus the reference's${unit}`.replace("luminance", share ? "value" : "luminance"));
    case "relative": return bar(signedMap, ends(state.scale * 100, "%"), "relative to the reference");
    case "angle": return bar(positive, rising(scaleOf(panel, display, state), "\u00b0"), "angle between the RGB of image and reference");
    case "signed_map": return bar(signedMap, ends(state.scale), panel.layer.owner === "march"
      ? "ambient occlusion by the depth buffer minus traced; blue: light is lost, red: light leaks in"
      : `blue: too dark, red: too bright${unit}`);
    case "positive_map": return bar(positive, rising(scaleOf(panel, display, state)), share ? "share" : `standard deviation${unit}`);
    case "share": return h("div", { class: "legend" }, "black 0, white 1");
    case "direction": return h("div", { class: "legend" }, "red, green, blue: x, y, z of view space, \u22121 to +1");
    case "tone": return h("div", { class: "legend" }, `exposure ${short(data.frame.exposure * 2 ** state.stops)}; ` +
      `at ${short(data.frame.exposure)} the reference's 99th-percentile luminance is white`);
  }
}
