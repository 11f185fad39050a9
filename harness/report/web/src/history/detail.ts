// The series that is drawn large: its curve, the values under the cursor, and its files.
import { button, csv, download, h, svg } from "../dom";
import { rootFontSize } from "../layout";
import { short } from "../numbers";
import { Catalogue, scaleOf } from "./catalogue";
import { Chart, View, chartOf } from "./chart";
import { Step, Values, shortCommit } from "./data";
import { palette } from "./palette";
import { lastMeasured } from "./sampling";
import { State } from "./state";

const svgNamespace = "http://www.w3.org/2000/svg";
export type Update = (change: Partial<State>) => void;

export class Detail {
  readonly element: HTMLElement;
  private readonly heading = h("h3", {});
  private readonly place: HTMLElement;
  private readonly readout = h("div", { class: "readout" });
  private readonly cursor = svg("line", { class: "cursor", stroke: "currentColor", "stroke-dasharray": "2 3" });
  private chart: Chart | null = null;
  private state: State | null = null;
  private index = -1;
  private hovered = -1;
  private dragged = -1; // where a drag began
  private drawnAs = "";

  constructor(private readonly catalogue: Catalogue, private readonly values: Values, private readonly update: Update, private readonly choose: (step: Step) => void) {
    this.place = h("div", {
      class: "chart", tabindex: 0, role: "group", "aria-label": "Curve; arrow keys move along the runs",
      pointermove: (event: PointerEvent) => this.hover(this.runAt(event)), pointerleave: () => this.hover(-1),
      pointerdown: (event: PointerEvent) => { this.dragged = this.runAt(event); }, pointerup: (event: PointerEvent) => this.drop(event),
      dblclick: () => update({ from: NaN, to: NaN }), keydown: (event: KeyboardEvent) => this.key(event),
    });
    const file = () => `${this.catalogue.history.series[this.index]?.key ?? "series"}`;
    this.element = h("figure", { class: "plot detail" }, this.heading, this.place,
      h("div", { class: "tools" },
        button("all runs", () => update({ from: NaN, to: NaN }), { title: "key 0" }),
        button("closer", () => this.zoom(0.5), { title: "key +" }), button("further", () => this.zoom(2), { title: "key \u2212" }),
        button("SVG", () => download(`${file()}.svg`, "image/svg+xml", this.toSvg()), { "data-file": "svg" }),
        button("CSV", () => download(`${file()}.csv`, "text/csv", this.toCsv()), { "data-file": "csv" })),
      h("figcaption", { class: "note" }, "Band: the measurements' own 95% intervals. Tinted: the commits between which a step lies. Drag over runs to look closer; ",
        h("kbd", {}, "\u2190"), " ", h("kbd", {}, "\u2192"), " move along them, ", h("kbd", {}, "["), " ", h("kbd", {}, "]"), " from step to step."),
      this.readout);
    new ResizeObserver(() => { this.draw(); this.show(); }).observe(this.place);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.drawnAs = ""; this.draw(); this.show(); });
  }

  sync(state: State, index: number): void {
    [this.state, this.index] = [state, index];
    this.draw();
    this.show();
  }

  private get runs() { return this.catalogue.history.runs; }
  private runOf(id: number): number { return this.runs.findIndex((run) => run.id === id); }

  private view(): View {
    const series = this.catalogue.history.series[this.index]!, { divisor, unit } = scaleOf(series, this.state!.floors);
    const from = Math.max(this.runOf(this.state!.from), 0), to = this.runOf(this.state!.to);
    const last = to >= from ? to : this.runs.length - 1;
    const direction = series.better === "none" ? "" : `, ${series.better} is better`;
    return { series: this.index, from, to: last, divisor, label: `${series.metric}${unit ? ` (${unit})` : ""}${direction}` };
  }

  private size(onPaper = false) {
    const text = onPaper ? 13 : 0.8 * rootFontSize();
    const width = onPaper ? 900 : Math.min(Math.max(this.place.clientWidth, 300), 2400);
    return { width, height: Math.round(Math.max(width * 0.45, 16 * text)), text };
  }

  private draw(): void {
    if (!this.state || this.place.clientWidth === 0) return;
    if (this.index < 0) {
      this.drawnAs = "";
      this.chart = null;
      this.heading.textContent = "";
      this.place.replaceChildren(h("p", { class: "note" }, "No series is left by the filters."));
      return;
    }
    const view = this.view(), size = this.size(), key = JSON.stringify([view, size]);
    if (key === this.drawnAs) return;
    this.drawnAs = key;
    this.heading.replaceChildren(this.catalogue.title(this.index), " ", h("small", {}, this.catalogue.place(this.index)));
    this.chart = chartOf(this.catalogue.history, this.values, view, this.catalogue.steps[this.index]!, size, palette(), this.choose);
    this.place.replaceChildren(this.chart?.element ?? h("p", { class: "note" }, "Nothing was measured in these runs."));
    this.chart?.element.append(this.cursor);
  }

  private runAt(event: PointerEvent): number {
    if (!this.chart) return -1;
    const { frame } = this.chart, view = this.view();
    const x = event.clientX - this.chart.element.getBoundingClientRect().left;
    const along = (x - frame.left) / Math.max(frame.right - frame.left, 1);
    return Math.round(view.from + Math.min(Math.max(along, 0), 1) * (view.to - view.from));
  }

  private hover(run: number): void {
    this.hovered = run;
    this.show();
  }

  private drop(event: PointerEvent): void {
    const run = this.runAt(event), [from, to] = [Math.min(run, this.dragged), Math.max(run, this.dragged)], view = this.view();
    if (run >= 0 && from >= 0) {
      const wide = to - from >= Math.max(2, 0.02 * (view.to - view.from));
      this.update(wide ? { from: this.runs[from]!.id, to: this.runs[to]!.id } : { at: this.runs[run]!.id });
    }
    this.dragged = -1;
  }

  private zoom(factor: number): void {
    const view = this.view(), middle = Math.max(this.current(), 0), half = Math.max(1, ((view.to - view.from) * factor) / 2);
    const from = Math.max(0, Math.round(middle - half)), to = Math.min(this.runs.length - 1, Math.round(middle + half));
    const all = from === 0 && to === this.runs.length - 1;
    this.update(all ? { from: NaN, to: NaN } : { from: this.runs[from]!.id, to: this.runs[to]!.id });
  }

  private key(event: KeyboardEvent): void {
    const view = this.view(), now = this.current(), steps = this.catalogue.steps[this.index] ?? [];
    const to: Record<string, () => number> = {
      ArrowLeft: () => now - 1, ArrowRight: () => now + 1, Home: () => view.from, End: () => view.to,
      "[": () => steps.findLast((step) => step.run < now)?.run ?? now, "]": () => steps.find((step) => step.run > now)?.run ?? now,
    };
    const act: Record<string, () => void> = { "+": () => this.zoom(0.5), "-": () => this.zoom(2), "0": () => this.update({ from: NaN, to: NaN }) };
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in to || event.key in act) || this.index < 0) return;
    event.preventDefault();
    act[event.key]?.();
    const run = to[event.key]?.();
    if (run === undefined) return;
    const at = Math.min(Math.max(run, 0), this.runs.length - 1);
    this.update({ at: this.runs[at]!.id, ...(at < view.from || at > view.to ? { from: NaN, to: NaN } : {}) });
  }

  /** The run whose values are shown: under the cursor, else the kept one, else the last. */
  private current(): number {
    if (this.hovered >= 0) return this.hovered;
    const kept = this.runOf(this.state?.at ?? NaN);
    return kept >= 0 ? kept : lastMeasured(this.values, Math.max(this.index, 0), this.runs.length - 1);
  }

  private show(): void {
    if (this.index < 0 || !this.state) { this.readout.replaceChildren(); return; }
    const run = this.current(), view = this.view();
    if (this.chart) {
      const { frame } = this.chart, x = frame.x(run), inside = run >= view.from && run <= view.to;
      for (const [name, value] of Object.entries({ x1: x, x2: x, y1: frame.top, y2: frame.bottom })) this.cursor.setAttribute(name, String(value));
      this.cursor.setAttribute("visibility", inside ? "visible" : "hidden");
    }
    const facts = this.runs[run];
    if (!facts) { this.readout.replaceChildren(); return; }
    const rows = [this.index, ...this.catalogue.siblings(this.index)].slice(0, 12).map((index) => this.valueRow(index, run));
    const head = ["series", "value", "95% interval", "change", "in noise floors"].map((text, i) => h("th", { scope: "col", class: i > 0 ? "number" : undefined }, text));
    this.readout.replaceChildren(
      h("p", {}, h("code", {}, shortCommit(facts.commit)), " ", facts.subject, " ",
        h("span", { class: "note" }, `${(facts.commit_time || facts.added).slice(0, 16).replace("T", " ")}, ${facts.device}${facts.baseline ? ", baseline" : ""}`)),
      h("div", { class: "scroll" }, h("table", {}, h("thead", {}, h("tr", {}, ...head)), h("tbody", {}, ...rows))));
  }

  private valueRow(index: number, run: number): HTMLElement {
    const series = this.catalogue.history.series[index]!, { divisor } = scaleOf(series, this.state!.floors), at = index * this.values.runs + run;
    const number = (value: number) => (Number.isNaN(value) ? "\u2013" : short(value));
    const value = this.values.value[at]!, lower = this.values.lower[at]!, upper = this.values.upper[at]!;
    const before = lastMeasured(this.values, index, run - 1);
    const change = before < 0 ? NaN : value / this.values.value[index * this.values.runs + before]! - 1;
    const cells = [
      number(value / divisor),
      Number.isNaN(lower) || Number.isNaN(upper) ? "\u2013" : `[${number(lower / divisor)}, ${number(upper / divisor)}]`,
      Number.isFinite(change) ? `${change > 0 ? "+" : ""}${short(100 * change, 3)}%` : "\u2013",
      series.noise_floor && series.noise_floor > 0 ? number(value / series.noise_floor) : "\u2013"];
    return h("tr", {}, h("th", { scope: "row" }, this.catalogue.title(index)), ...cells.map((text) => h("td", { class: "number" }, text)));
  }

  /** A file that stands alone: black on white, titled. */
  private toSvg(): string {
    if (this.index < 0) return "";
    const size = this.size(true), colours = palette(true);
    const chart = chartOf(this.catalogue.history, this.values, this.view(), this.catalogue.steps[this.index]!, size, colours, () => {});
    const title = `${this.catalogue.title(this.index)} \u00b7 ${this.catalogue.place(this.index)}`;
    chart?.element.setAttribute("y", "32");
    const whole = svg("svg", { xmlns: svgNamespace, width: size.width, height: size.height + 32, viewBox: `0 0 ${size.width} ${size.height + 32}`, "font-family": "system-ui, sans-serif", color: "#000" },
      svg("rect", { width: "100%", height: "100%", fill: "#fff" }), svg("text", { x: 5, y: 20, "font-size": 15 }, title), chart?.element);
    return new XMLSerializer().serializeToString(whole);
  }

  private toCsv(): string {
    const { runs, values, index } = this, steps = this.catalogue.steps[Math.max(index, 0)] ?? [], view = this.view();
    const shown = (value: number) => (Number.isNaN(value) ? "" : value);
    const rows = runs.slice(view.from, view.to + 1).map((run, i) => {
      const at = index * values.runs + view.from + i, step = steps.find((one) => one.run === view.from + i);
      return [run.id, run.commit, run.commit_time, run.added, run.device, shown(values.value[at]!), shown(values.lower[at]!), shown(values.upper[at]!),
        run.baseline ? "yes" : "", step?.verdict ?? "", step?.intended?.why ?? "", run.subject];
    });
    return csv(["run", "commit", "commit_time", "added", "device", "value", "lower", "upper", "baseline", "step", "intended", "subject"], rows);
  }
}
