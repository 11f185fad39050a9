// The frame around a plot: title, choices, what it says, and its files.
import { button, choice, csv, download, h, svg } from "./dom";
import { Point } from "./points";

export interface Drawn {
  chart: Element; // of Observable Plot
  points: Point[]; // what it shows, for the CSV
  caption: string;
  scale: { domain: string[]; range: string[] };
}
/** Choices by name: their values and texts; the first is chosen. */
export type Choices = Record<string, [string, string][]>;

const svgNamespace = "http://www.w3.org/2000/svg";

function toCsv(points: Point[]): string {
  const names = [...new Set(points.flatMap(({ facts }) => Object.keys(facts)))];
  return csv(["method", ...names, "stage", "metric", "value", "lower", "upper", "n"],
    points.map((point) => [point.name, ...names.map((name) => point.facts[name]), point.stage, point.metric, point.value,
      point.measured ? point.lower : undefined, point.measured ? point.upper : undefined, point.n]));
}

/** A file that stands alone: black on white, with the title and the methods' colours above. */
function toSvg(heading: string, drawn: Drawn): string {
  const source = drawn.chart.tagName === "svg" ? drawn.chart : drawn.chart.querySelector("svg")!;
  const chart = source.cloneNode(true) as SVGElement;
  const width = Number(chart.getAttribute("width")), height = Number(chart.getAttribute("height"));
  chart.setAttribute("y", "48");
  const legend = drawn.scale.domain.map((name, i) => svg("g", { transform: `translate(${10 + i * 90} 36)` },
    svg("circle", { r: 5, fill: drawn.scale.range[i] }), svg("text", { x: 9, y: 4 }, name)));
  const whole = svg("svg", { xmlns: svgNamespace, width, height: height + 48, viewBox: `0 0 ${width} ${height + 48}`,
    "font-family": "system-ui, sans-serif", "font-size": 12, color: "#000", style: "color: #000; background: #fff" },
    svg("text", { x: 5, y: 18, "font-size": 15 }, heading), ...legend, chart);
  // Of the page's own colours there is only the paper's.
  return new XMLSerializer().serializeToString(whole).replaceAll("var(--paper)", "#fff");
}

/** `draw` returns nothing where the choices leave nothing to draw. */
export function plotFrame(id: string, heading: string, choices: Choices,
  draw: (chosen: Record<string, string>, width: number) => Drawn | null): HTMLElement {
  const chosen = Object.fromEntries(Object.entries(choices).map(([name, options]) => [name, options[0]?.[0] ?? ""]));
  const place = h("div", { class: "chart" });
  const caption = h("figcaption", {});
  let drawn: Drawn | null = null;
  const redraw = () => {
    const width = Math.min(Math.max(place.clientWidth, 300), 1600); // of a place not laid out: 300
    drawn = draw(chosen, width);
    place.replaceChildren(...(drawn ? [legendOf(drawn), drawn.chart] : [h("p", { class: "note" }, "Nothing was measured for this choice.")]));
    caption.textContent = drawn?.caption ?? "";
  };
  // A plot is drawn when it is laid out, which may be later than its buttons are reached.
  const save = (end: string, type: string, write: (shown: Drawn) => string) => {
    if (!drawn) redraw();
    if (drawn) download(`${id}.${end}`, type, write(drawn));
  };
  const tools = h("div", { class: "tools" },
    ...Object.entries(choices).filter(([, options]) => options.length > 1).map(([name, options]) =>
      choice(name, options, chosen[name]!, (value) => { chosen[name] = value; redraw(); })),
    button("SVG", () => save("svg", "image/svg+xml", (shown) => toSvg(heading, shown)), { "data-file": "svg" }),
    button("CSV", () => save("csv", "text/csv", (shown) => toCsv(shown.points)), { "data-file": "csv" }));
  const figure = h("figure", { class: "plot", id: `plot-${id}` }, h("h3", {}, heading), place, tools, caption);
  let width = 0;
  new ResizeObserver(() => {
    if (Math.abs(place.clientWidth - width) < 8) return;
    width = place.clientWidth;
    redraw();
  }).observe(place);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  return figure;
}

const shapes = ["circle", "square", "triangle", "diamond2", "star", "wye", "cross", "hexagon"];
export function symbols(domain: string[]): string[] { return domain.map((_, i) => shapes[i % shapes.length]!); }

const marks: Record<string, string> = { circle: "\u25cf", square: "\u25a0", triangle: "\u25b2", diamond2: "\u25c6", star: "\u2605", wye: "\u2442", cross: "\u271a", hexagon: "\u2b22" };

function legendOf({ scale }: Drawn): HTMLElement {
  const shape = symbols(scale.domain);
  return h("div", { class: "plot-legend" }, ...scale.domain.map((name, i) =>
    h("span", {}, h("span", { style: `color: ${scale.range[i]}` }, marks[shape[i]!] ?? "\u25cf"), ` ${name}`)));
}
