// The list of series: only the rows in sight exist, and only their curves are drawn.
import { h } from "../dom";
import { rootFontSize } from "../layout";
import { short } from "../numbers";
import { Catalogue, scaleOf } from "./catalogue";
import { Values } from "./data";
import { colourOf, palette, signs } from "./palette";
import { columnsOf, extent, lastMeasured } from "./sampling";
import { State } from "./state";

const rowHeight = 3.6; // rem
const printed = 60; // rows on paper

export class SeriesList {
  readonly element: HTMLElement;
  private readonly rows = h("div", { class: "rows" });
  private readonly scroller: HTMLElement;
  private readonly count = h("p", { class: "note", role: "status" });
  private shown: number[] = [];
  private state: State | null = null;
  private selected = -1;
  private made = new Map<number, HTMLElement>(); // by place in the list
  private onPaper = false;

  constructor(private readonly catalogue: Catalogue, private readonly values: Values, private readonly choose: (index: number) => void) {
    this.scroller = h("div", {
      class: "series-list", tabindex: 0, role: "listbox", "aria-label": "Series", scroll: () => this.fill(),
      keydown: (event: KeyboardEvent) => this.key(event),
    }, this.rows);
    this.element = h("div", {}, this.count, this.scroller);
    new ResizeObserver(() => this.redraw()).observe(this.scroller);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    window.addEventListener("beforeprint", () => { this.onPaper = true; this.redraw(); });
    window.addEventListener("afterprint", () => { this.onPaper = false; this.redraw(); });
  }

  sync(state: State, shown: number[], selected: number): void {
    const same = this.state && this.state.floors === state.floors && this.shown.length === shown.length && this.shown.every((index, i) => index === shown[i]);
    const moved = this.selected !== selected;
    [this.state, this.shown, this.selected] = [state, shown, selected];
    const all = this.catalogue.history.series.length;
    this.count.textContent = shown.length === all ? `${all} series` : `${shown.length} of ${all} series`;
    if (!same) this.redraw();
    if (!moved) return;
    for (const [place, row] of this.made) row.setAttribute("aria-selected", String(shown[place] === selected));
    this.reveal();
  }

  private get height(): number { return Math.round(rowHeight * rootFontSize()); }

  private redraw(): void {
    if (!this.state) return;
    this.made.clear();
    this.rows.replaceChildren();
    const count = this.onPaper ? Math.min(printed, this.shown.length) : this.shown.length;
    this.rows.style.height = `${count * this.height}px`;
    this.fill();
  }

  private reveal(): void {
    const place = this.shown.indexOf(this.selected), { scrollTop, clientHeight } = this.scroller;
    if (place < 0) return;
    const top = place * this.height;
    if (top < scrollTop) this.scroller.scrollTop = top;
    else if (top + this.height > scrollTop + clientHeight) this.scroller.scrollTop = top + this.height - clientHeight;
  }

  private fill(): void {
    const { scrollTop, clientHeight } = this.scroller;
    const first = this.onPaper ? 0 : Math.max(0, Math.floor(scrollTop / this.height) - 1);
    const last = Math.min(this.shown.length, this.onPaper ? printed : Math.ceil((scrollTop + clientHeight) / this.height) + 1) - 1;
    for (const [place, row] of this.made) {
      if (place >= first && place <= last) continue;
      row.remove();
      this.made.delete(place);
    }
    for (let place = first; place <= last; ++place) {
      if (this.made.has(place)) continue;
      const row = this.row(place);
      this.made.set(place, row);
      this.rows.append(row);
      this.paint(this.shown[place]!, row.querySelector("canvas")!);
    }
  }

  private row(place: number): HTMLElement {
    const index = this.shown[place]!, { history, steps } = this.catalogue, series = history.series[index]!;
    const { divisor, unit } = scaleOf(series, this.state!.floors);
    const run = lastMeasured(this.values, index, this.values.runs - 1);
    const last = run < 0 ? "not measured" : short(this.values.value[index * this.values.runs + run]! / divisor);
    const colours = palette(this.onPaper);
    const marks = steps[index]!.slice(-4).map((step) => h("span", {
      style: `color: ${colourOf(step, colours)}`, class: step.intended ? "intended" : undefined, title: step.verdict + (step.intended ? ", intended" : ""),
    }, signs[step.verdict]));
    return h("div", {
      class: "series", role: "option", id: `series-${series.key}`, "aria-selected": String(index === this.selected),
      style: `top: ${place * this.height}px; height: ${this.height}px`, click: () => this.choose(index),
    }, h("div", { class: "name" }, h("strong", {}, this.catalogue.title(index)), h("small", {}, this.catalogue.place(index))),
      h("canvas", {}), h("div", { class: "last" }, h("span", {}, ...marks, " ", last), h("small", {}, unit)));
  }

  private paint(index: number, canvas: HTMLCanvasElement): void {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    const context = canvas.getContext("2d");
    if (!context || width < 2) return;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    context.scale(ratio, ratio);
    const runs = this.values.runs, columns = columnsOf(this.values, index, 0, runs - 1, Math.min(runs, Math.floor(width)));
    const range = extent(columns.low, columns.high), colours = palette(this.onPaper);
    if (!range) return;
    // What is too small to be a step does not fill the height.
    const [middle, least] = [(range[0] + range[1]) / 2, 2 * this.catalogue.history.minimum_effect * Math.max(Math.abs(range[0]), Math.abs(range[1]))];
    if (range[1] - range[0] < 2 * least) range.splice(0, 2, middle - least, middle + least);
    const x = (column: number) => (columns.count > 1 ? (column / (columns.count - 1)) * (width - 4) + 2 : width / 2);
    const y = (value: number) => (range[1] > range[0] ? height - 4 - ((value - range[0]) / (range[1] - range[0])) * (height - 8) : height / 2);
    for (const step of this.catalogue.steps[index]!) {
      const at = x((step.run / Math.max(runs - 1, 1)) * (columns.count - 1));
      context.fillStyle = colourOf(step, colours);
      context.globalAlpha = step.intended ? 0.45 : 0.8;
      context.fillRect(at - 1, 0, 2, height);
    }
    context.globalAlpha = 1;
    context.strokeStyle = colours.curve;
    context.lineWidth = 1.25;
    context.beginPath();
    for (let i = 0; i < columns.count; ++i) {
      if (Number.isNaN(columns.low[i]!)) continue;
      context.lineTo(x(i), y(columns.low[i]!));
      context.lineTo(x(i), y(columns.high[i]!) - (columns.count === 1 ? 1 : 0));
    }
    context.stroke();
  }

  private key(event: KeyboardEvent): void {
    const place = this.shown.indexOf(this.selected), page = Math.max(1, Math.floor(this.scroller.clientHeight / this.height) - 1);
    const moves: Record<string, number> = { ArrowDown: place + 1, ArrowUp: place - 1, PageDown: place + page, PageUp: place - page, Home: 0, End: this.shown.length - 1 };
    const to = moves[event.key];
    if (to === undefined || this.shown.length === 0) return;
    event.preventDefault();
    this.choose(this.shown[Math.min(Math.max(to, 0), this.shown.length - 1)]!);
  }
}
