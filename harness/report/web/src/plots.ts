// The plots of a run. Each is drawn from measurements over all seeds of the whole view.
import * as Plot from "@observablehq/plot";
import { Data, fact } from "./data";
import { h, section } from "./dom";
import { rootFontSize } from "./layout";
import { logTicks, short } from "./numbers";
import { Drawn, plotFrame, symbols } from "./plot_frame";
import { Point, Points, forScreen } from "./points";

type Curve = Point & { along: number; curve: string };
type Options = Plot.PlotOptions;

function titleOf(point: Point): string {
  const interval = point.measured ? ` [${short(point.lower)}, ${short(point.upper)}]` : "";
  return `${point.method}${point.label ? `, ${point.label}` : ""}\n${point.metric}${point.stage ? `, ${point.stage}` : ""}: ${short(point.value)}${interval}, n = ${point.n}`;
}

function draw(points: Points, shown: Point[], caption: string, width: number, options: Options): Drawn | null {
  if (shown.length === 0) return null;
  const scale = points.scale(shown);
  const text = 0.8 * rootFontSize();
  const chart = Plot.plot({
    width, height: Math.round(Math.max(width * 0.55, 260)), grid: true,
    marginTop: 2 * text, marginLeft: 5 * text, marginRight: 6 * text, marginBottom: 3.5 * text,
    style: { fontSize: `${text}px`, background: "transparent" },
    color: { domain: scale.domain, range: scale.range },
    symbol: { domain: scale.domain, range: symbols(scale.domain) as Plot.ScaleOptions["range"] },
    ...options,
  });
  return { chart, points: shown, caption, scale };
}

const link = { href: "href", title: titleOf };
const dots = (data: Point[], x: string, y: string) =>
  Plot.dot(data, { x, y, stroke: "method", fill: "method", symbol: "method", r: 4.5, ...link });

function accuracies(points: Points): [string, string][] {
  const known = points.data.metrics.filter(({ name }) => points.has(name)).map(({ name }) => name);
  return [...(known.includes("rmse") ? ["rmse"] : []), ...known.filter((name) => name !== "rmse")].map((name) => [name, name]);
}

function unit(data: Data, metric: string): string {
  const known = data.metrics.find(({ name }) => name === metric);
  return known?.unit ? ` (${known.unit})` : "";
}

/** The axis of a logarithmic scale over some numbers. Left to itself, the scale labels few or none within a decade. */
function logAxis(axis: "x" | "y", numbers: number[]): Plot.Markish[] {
  const ticks = logTicks(Math.min(...numbers), Math.max(...numbers)), text = (value: number) => String(Number(value.toPrecision(3)));
  return axis === "x" ? [Plot.gridX(ticks), Plot.axisX(ticks, { text })] : [Plot.gridY(ticks), Plot.axisY(ticks, { text })];
}

const stages: [string, string][] = [["filtered", "after the filter"], ["unfiltered", "before the filter"]];

function passes(points: Points, prefix: string): [string, string][] {
  const names = points.metrics(prefix);
  const order = ["frame", "occlusion"].filter((name) => names.includes(name));
  return [...order, ...names.filter((name) => !order.includes(name))].map((name) => [name, name]);
}

/** No other point is both faster and better. */
function front(pairs: { time: number; value: number }[], lowerIsBetter: boolean): { time: number; value: number }[] {
  let best = lowerIsBetter ? Infinity : -Infinity;
  return [...pairs].sort((a, b) => a.time - b.time).filter(({ value }) => {
    const better = lowerIsBetter ? value < best : value > best;
    if (better) best = value;
    return better;
  });
}

function pareto(points: Points): HTMLElement | null {
  const metrics = accuracies(points), passNames = passes(points, "time_ms.");
  if (metrics.length === 0 || passNames.length === 0) return null;
  return plotFrame("pareto", "Error against time", { error: metrics, stage: stages, pass: passNames }, (chosen, width) => {
    const times = points.of(`time_ms.${chosen.pass}`);
    const lower = points.data.metrics.find(({ name }) => name === chosen.error)?.lowerIsBetter ?? true;
    const pairs = points.of(chosen.error!, chosen.stage).flatMap((point) => {
      const time = times.find((candidate) => candidate.name === point.name && candidate.href === point.href);
      return time ? [{ ...point, time: time.value, fastest: time.lower, slowest: time.upper }] : [];
    });
    // Of one parameter that varies, its values are enough.
    const labelled = [...new Set(pairs.map(({ label }) => label.replace(/ [^ ]*$/, "")))];
    const short = labelled.length === 1 && !labelled[0]!.includes(",");
    const label = (pair: Point) => (short ? pair.label.replace(/^.* /, "") : pair.label);
    return draw(points, pairs, `${short ? `Numbers: ${labelled[0]}. ` : ""}Line: the Pareto front, what no other point is both faster and better than. Whiskers: 95% interval over the seeds, quartiles of the times. Clock: ${fact(points.data, "timing", "clock")}.`,
      width, {
        x: { type: "log", label: `${chosen.pass} time (ms)`, grid: false },
        y: { label: `${chosen.error}${unit(points.data, chosen.error!)}, ${lower ? "lower" : "higher"} is better`, nice: true },
        marks: [
          ...logAxis("x", pairs.flatMap(({ fastest, slowest }) => [fastest, slowest])),
          Plot.line(front(pairs, lower), { x: "time", y: "value", stroke: "currentColor", strokeDasharray: "4 3", curve: "step-after" }),
          Plot.ruleX(pairs, { x: "time", y1: "lower", y2: "upper", stroke: "method" }),
          Plot.ruleY(pairs, { y: "value", x1: "fastest", x2: "slowest", stroke: "method" }),
          dots(pairs, "time", "value"),
          Plot.text(pairs, { x: "time", y: "value", text: label, dx: 8, dy: -8, textAnchor: "start", fill: "currentColor", stroke: "var(--paper)", strokeWidth: 3 }),
        ],
      });
  });
}

function curveMarks(data: Curve[]): Plot.Markish[] {
  return [
    Plot.areaY(data, { x: "along", y1: "lower", y2: "upper", z: "curve", fill: "method", fillOpacity: 0.2 }),
    Plot.ruleX(data, { x: "along", y1: "lower", y2: "upper", stroke: "method" }),
    Plot.line(data, { x: "along", y: "value", z: "curve", stroke: "method", strokeWidth: 1.75 }),
    dots(data, "along", "value"),
  ];
}

function axisTicks(data: Curve[]): number[] { return [...new Set(data.map(({ along }) => along))]; }

function errorAgainst(points: Points): HTMLElement | null {
  const metrics = accuracies(points);
  if (metrics.length === 0) return null;
  const axes = points.axes(points.of(metrics[0]![0]));
  if (axes.length === 0) return null;
  return plotFrame("error", "Error against samples and steps", { error: metrics, stage: stages, against: axes.map((axis) => [axis, axis]) },
    (chosen, width) => {
      const data = points.curves(points.of(chosen.error!, chosen.stage), chosen.against!);
      const others = ["samples", "steps"].filter((axis) => !axes.includes(axis)).map((axis) => `${axis} did not vary in this run`);
      return draw(points, data, `Bands: 95% intervals over ${data[0]?.n ?? 0} seeds.${others.length > 0 ? ` ${others.join(", ")}.` : ""}`, width, {
        x: { type: "log", base: 2, label: chosen.against, ticks: axisTicks(data), tickFormat: "~g" },
        y: { label: `${chosen.error}${unit(points.data, chosen.error!)}` },
        marks: curveMarks(data),
      });
    });
}

/** Stacked parts of every method, its parameters side by side. */
function stacks(points: Points, parts: (Point & { part: string })[], colours: [string, string][], caption: string, label: string, width: number): Drawn | null {
  const chart = draw(points, parts, caption, width, {
    marginTop: 3 * rootFontSize(), marginRight: 10, fx: { label: null, domain: points.scale(parts).domain }, x: { label: null, tickRotate: -30 }, marginBottom: 4 * rootFontSize(),
    y: { label, labelAnchor: "center", grid: true },
    color: { domain: colours.map(([name]) => name), range: colours.map(([, colour]) => colour) },
    marks: [
      Plot.barY(parts, { fx: "method", x: "label", y: "value", fill: "part", stroke: "var(--paper)", strokeWidth: 0.5, ...link,
        sort: { x: null } }),
      Plot.ruleY([0]),
    ],
  });
  if (chart) chart.scale = { domain: colours.map(([name]) => name), range: colours.map(([, colour]) => colour) };
  return chart;
}

function noiseAndBias(points: Points): HTMLElement | null {
  if (!points.has("noise")) return null;
  return plotFrame("noise", "Noise and bias", { stage: [stages[1]!, stages[0]!] }, (chosen, width) => {
    const noise = points.of("noise", chosen.stage).map((point) => ({ ...point, value: point.value ** 2, lower: point.lower ** 2, upper: point.upper ** 2, part: "noise\u00b2" }));
    const bias = points.of("bias_squared", chosen.stage).map((point) => ({ ...point, part: "bias\u00b2" }));
    return stacks(points, [...bias, ...noise], [["bias\u00b2", forScreen("#b85c00")], ["noise\u00b2", forScreen("#1f77b4")]],
      "Stacked, they are the expected squared error of one seed, in squared mean luminances of the reference. Noise changes with the seed, bias does not.",
      "mean luminance\u00b2", width);
  });
}

function budget(points: Points): HTMLElement | null {
  const parts = ["representation", "visibility", "sampling", "filter"];
  if (!points.has("budget_share.visibility")) return null;
  const colours = ["#7b3294", "#b85c00", "#1f77b4", "#1a8a5a"].map(forScreen);
  return plotFrame("budget", "Error budget", { stage: stages }, (chosen, width) => {
    const shares = parts.flatMap((part) => points.of(`budget_share.${part}`, chosen.stage).map((point) => ({ ...point, part })));
    return stacks(points, shares, parts.map((part, i) => [part, colours[i]!]),
      "Shares of the mean squared error; they add up to 1, and a part that works against the rest is negative.", "share of the mean squared error", width);
  });
}

/** The published times as ratios to the baseline, of the first table of the paper. */
function publishedRatios(points: Points, baseline: string): (Point & { along: number })[] {
  const { published } = points.data;
  if (!published) return [];
  const table = published.times.filter(({ origin }) => origin === published.times[0]?.origin);
  return table.flatMap((time) => {
    const base = table.find((other) => other.method === baseline && other.samples === time.samples && other.steps === time.steps && other.resolution === time.resolution);
    if (!base || !points.data.methods[time.method]) return [];
    const value = time.time_ms / base.time_ms;
    return [{ method: points.data.methods[time.method]!.title, name: time.method, facts: { samples: time.samples, steps: time.steps, resolution: time.resolution },
      metric: "published time ratio", stage: "", value, lower: value, upper: value, n: 1, label: `published on ${time.device}`, href: "#cell=table-timing", measured: false, along: Number(time.samples) }];
  });
}

function ratios(points: Points): HTMLElement | null {
  const baseline = fact(points.data, "timing_table", "baseline"), passNames = passes(points, "time_ratio.").reverse();
  if (!baseline || passNames.length === 0) return null;
  const first = passNames.sort(([a], [b]) => Number(b === "occlusion") - Number(a === "occlusion"));
  return plotFrame("ratio", `Time relative to ${points.data.methods[baseline]?.title ?? baseline}`, { pass: first }, (chosen, width) => {
    const ours = points.curves(points.of(`time_ratio.${chosen.pass}`), "samples");
    const published = publishedRatios(points, baseline);
    const caption = "Filled: ours, medians of paired repetitions with 95% intervals." + (published.length > 0
      ? ` Open, dashed: published by ${points.data.published!.source} (whether its times include the filter is not always stated), measured on ${points.data.published!.times[0]!.device}.` : "");
    return draw(points, [...ours, ...published], caption, width, {
      x: { type: "log", base: 2, label: "samples", ticks: axisTicks([...ours, ...published] as Curve[]), tickFormat: "~g" },
      y: { label: `${chosen.pass} time / ${baseline}` },
      marks: [
        Plot.ruleY([1], { stroke: "currentColor", strokeOpacity: 0.5 }), ...curveMarks(ours),
        Plot.line(published, { x: "along", y: "value", z: "method", stroke: "method", strokeDasharray: "3 3" }),
        Plot.dot(published, { x: "along", y: "value", stroke: "method", symbol: "method", fill: "var(--paper)", r: 5, strokeWidth: 1.5, ...link }),
      ],
    });
  });
}

function scaling(points: Points): HTMLElement | null {
  const passNames = passes(points, "time_ms.");
  if (passNames.length === 0) return null;
  const axes = points.axes(points.of(`time_ms.${passNames[0]![0]}`));
  if (axes.length === 0) return null;
  return plotFrame("scaling", "How times grow", { pass: passNames, against: axes.map((axis) => [axis, axis]) }, (chosen, width) => {
    const data = points.curves(points.of(`time_ms.${chosen.pass}`), chosen.against!);
    return draw(points, data, `Medians with quartiles, both axes logarithmic: a straight line of slope 1 is in proportion. Clock: ${fact(points.data, "timing", "clock")}.`, width, {
      x: { type: "log", label: chosen.against === "resolution" ? "pixels" : chosen.against, ticks: axisTicks(data), tickFormat: "~s" },
      y: { type: "log", label: `${chosen.pass} time (ms)`, grid: false },
      marks: [...logAxis("y", data.flatMap(({ lower, upper }) => [lower, upper])), ...curveMarks(data)],
    });
  });
}

/** Where spectra were measured: metrics KIND_spectrum.FREQUENCY, in cycles a pixel. */
function spectra(points: Points): HTMLElement | null {
  const kinds = [...new Set(points.data.plots.rows.map(({ metric }) => /^(\w+_spectrum)\./.exec(metric)?.[1]).filter((kind): kind is string => Boolean(kind)))];
  if (kinds.length === 0) return null;
  const ofKind = (kind: string, stage?: string): Curve[] => points.metrics(`${kind}.`).flatMap((frequency) =>
    points.of(`${kind}.${frequency}`, stage).map((point) => ({ ...point, along: Number(frequency), curve: `${point.name} ${point.label}` }))).sort((a, b) => a.along - b.along);
  return plotFrame("spectra", "Power spectra", { spectrum: kinds.map((kind) => [kind, kind.replaceAll("_", " ")]), stage: stages }, (chosen, width) => {
    const data = ofKind(chosen.spectrum!, chosen.stage).filter(({ along, value }) => along > 0 && value > 0);
    return draw(points, data, "Mean power over all directions of a frequency; flat is white noise. Over all frequencies its mean is the luminance's noise\u00b2.", width, {
      x: { type: "log", label: "cycles per pixel", grid: false }, y: { type: "log", label: "power (mean luminance\u00b2)", grid: false },
      marks: [...logAxis("x", data.map(({ along }) => along)), ...logAxis("y", data.flatMap(({ lower, upper }) => [lower, upper])), ...curveMarks(data)],
    });
  });
}

export function plots(data: Data): HTMLElement | null {
  const points = new Points(data);
  const all = [pareto, errorAgainst, noiseAndBias, ratios, budget, scaling, spectra].map((make) => make(points));
  const made = all.filter((plot): plot is HTMLElement => plot !== null);
  if (made.length === 0) return null;
  return section("plots", "Plots", h("p", {}, "Of the whole view, over all seeds. Marks lead to their cells."), h("div", { class: "plots" }, ...made));
}
