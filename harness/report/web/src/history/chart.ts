// One series over the commits: a few SVG nodes, however many runs there are.
import { svg } from "../dom";
import { niceTicks, short } from "../numbers";
import { History, Step, Values, dateOf } from "./data";
import { Palette, colourOf, signs } from "./palette";
import { Columns, columnsOf, extent } from "./sampling";

export interface View {
  series: number; from: number; to: number; // indices of runs
  divisor: number; label: string; // of the vertical axis
}
export interface Frame {
  width: number; height: number; left: number; right: number; top: number; bottom: number;
  x: (run: number) => number; y: (value: number) => number; ticks: number[];
}
export interface Chart { element: SVGElement; frame: Frame }

function domainOf(columns: Columns, divisor: number): [number, number] | null {
  const values = extent(columns.low, columns.high), whole = extent(columns.low, columns.high, columns.lower, columns.upper);
  if (!values || !whole) return null;
  // A few wide intervals do not flatten the curve.
  const reach = 2 * (values[1] - values[0]) || Infinity;
  const low = Math.max(whole[0], values[0] - reach) / divisor, high = Math.min(whole[1], values[1] + reach) / divisor;
  const margin = high > low ? 0.05 * (high - low) : Math.abs(high) * 0.05 || 1;
  return [low - margin, high + margin];
}

function frameOf(domain: [number, number], view: View, width: number, height: number, text: number): Frame {
  const ticks = niceTicks(domain[0], domain[1], 5);
  const longest = Math.max(...ticks.map((tick) => short(tick).length), 3);
  const frame = { width, height, left: (0.62 * longest + 1) * text, right: width - 0.8 * text, top: 2.6 * text, bottom: height - 3.2 * text };
  const span = Math.max(view.to - view.from, 1);
  return {
    ...frame, ticks,
    x: (run) => frame.left + ((run - view.from) / span) * (frame.right - frame.left),
    y: (value) => frame.bottom - ((value - domain[0]) / (domain[1] - domain[0])) * (frame.bottom - frame.top),
  };
}

/** Lines through the extremes of the columns; where runs are few there is a column for each. */
function curve(columns: Columns, x: (column: number) => number, y: (value: number) => number): { line: string; band: string } {
  let line = "", band = "", upper: string[] = [], lower: string[] = [];
  const close = () => {
    if (upper.length > 0) band += `M${upper.join("L")}L${lower.reverse().join("L")}Z`;
    upper = [];
    lower = [];
  };
  for (let i = 0; i < columns.count; ++i) {
    if (Number.isNaN(columns.low[i]!)) continue;
    const at = x(i).toFixed(1);
    line += `${line ? "L" : "M"}${at},${y(columns.low[i]!).toFixed(1)}`;
    if (columns.high[i]! !== columns.low[i]!) line += `L${at},${y(columns.high[i]!).toFixed(1)}`;
    if (Number.isNaN(columns.lower[i]!) || Number.isNaN(columns.upper[i]!)) { close(); continue; }
    upper.push(`${at},${y(columns.upper[i]!).toFixed(1)}`);
    lower.push(`${at},${y(columns.lower[i]!).toFixed(1)}`);
  }
  close();
  return { line, band };
}

function axes(history: History, view: View, frame: Frame, colours: Palette, text: number): SVGElement[] {
  const nodes: SVGElement[] = [];
  for (const tick of frame.ticks) {
    const y = frame.y(tick);
    nodes.push(svg("line", { x1: frame.left, x2: frame.right, y1: y, y2: y, stroke: colours.line }),
      svg("text", { x: frame.left - 0.4 * text, y: y + 0.35 * text, "text-anchor": "end", fill: colours.ink }, short(tick)));
  }
  const room = Math.max(1, Math.floor((frame.right - frame.left) / (9 * text)));
  const count = Math.min(room, view.to - view.from + 1);
  for (let i = 0; i < count; ++i) {
    const run = Math.round(view.from + (count > 1 ? (i * (view.to - view.from)) / (count - 1) : 0));
    const anchor = i === 0 ? "start" : i === count - 1 ? "end" : "middle";
    nodes.push(svg("line", { x1: frame.x(run), x2: frame.x(run), y1: frame.bottom, y2: frame.bottom + 0.4 * text, stroke: colours.quiet }),
      svg("text", { x: frame.x(run), y: frame.bottom + 1.5 * text, "text-anchor": anchor, fill: colours.ink }, dateOf(history.runs[run]!)));
  }
  nodes.push(svg("text", { x: 0, y: 1.1 * text, fill: colours.quiet }, view.label),
    svg("text", { x: frame.right, y: frame.bottom + 2.8 * text, "text-anchor": "end", fill: colours.quiet }, `runs ${view.from + 1} to ${view.to + 1} of ${history.runs.length}, in the order of the history`));
  return nodes;
}

/** The commit range of a step, with its sign on top. */
function marker(step: Step, frame: Frame, colours: Palette, text: number, choose: (step: Step) => void): SVGElement {
  const x0 = frame.x(step.before_run), x1 = frame.x(step.run), colour = colourOf(step, colours);
  const words = `${step.verdict}${step.intended ? ", intended" : ""}`;
  return svg("g", { class: "step-marker", "data-run": step.run, click: () => choose(step) },
    svg("title", {}, words),
    svg("rect", { x: x0, y: frame.top, width: Math.max(x1 - x0, 1.5), height: frame.bottom - frame.top, fill: colour, "fill-opacity": 0.25 }),
    svg("line", { x1, x2: x1, y1: frame.top, y2: frame.bottom, stroke: colour, "stroke-width": 1.5, "stroke-dasharray": step.intended ? "4 3" : undefined }),
    svg("text", { x: x1, y: frame.top - 0.3 * text, "text-anchor": "middle", fill: colour, "font-weight": 700, "font-size": 1.2 * text }, signs[step.verdict]));
}

function baselines(history: History, view: View, frame: Frame, colours: Palette): SVGElement {
  let path = "";
  history.runs.forEach((run, i) => {
    if (run.baseline && i >= view.from && i <= view.to) path += `M${frame.x(i).toFixed(1)},${frame.bottom}l-5,8h10z`;
  });
  return svg("path", { d: path, fill: colours.curve }, svg("title", {}, "baseline"));
}

/** Nothing where no run in view has a value. Sizes in CSS pixels, `text` that of the letters. */
export function chartOf(history: History, values: Values, view: View, steps: Step[], size: { width: number; height: number; text: number },
  colours: Palette, choose: (step: Step) => void): Chart | null {
  const { width, height, text } = size;
  const runs = view.to - view.from + 1;
  const columns = columnsOf(values, view.series, view.from, view.to, Math.min(runs, Math.max(Math.floor(width), 2)));
  const domain = domainOf(columns, view.divisor);
  if (!domain) return null;
  const frame = frameOf(domain, view, width, height, text);
  const along = (column: number) => frame.left + (columns.count > 1 ? (column / (columns.count - 1)) * (frame.right - frame.left) : 0);
  const clamped = (value: number) => Math.min(Math.max(frame.y(value / view.divisor), frame.top), frame.bottom);
  const { line, band } = curve(columns, along, clamped);
  const dots = runs <= 60 ? svg("g", { fill: colours.curve }, ...Array.from({ length: columns.count }, (_, i) => i)
    .filter((i) => !Number.isNaN(columns.low[i]!)).map((i) => svg("circle", { cx: along(i), cy: clamped(columns.low[i]!), r: 0.24 * text }))) : null;
  const seen = steps.filter((step) => step.run >= view.from && step.run <= view.to && step.before_run >= view.from);
  const element = svg("svg", { width, height, viewBox: `0 0 ${width} ${height}`, "font-size": text, "font-family": "system-ui, sans-serif" },
    ...axes(history, view, frame, colours, text),
    ...seen.map((step) => marker(step, frame, colours, text, choose)),
    svg("path", { d: band, fill: colours.curve, "fill-opacity": 0.2 }),
    svg("path", { d: line, fill: "none", stroke: colours.curve, "stroke-width": 0.12 * text, "stroke-linejoin": "round", class: "curve" }),
    dots, baselines(history, view, frame, colours));
  return { element, frame };
}
