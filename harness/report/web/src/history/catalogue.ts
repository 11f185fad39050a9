// The series by name, what they can be filtered by, and their steps.
import { varying } from "../data";
import { History, Series, Step } from "./data";
import { Field, State, fields } from "./state";

const rank = { WORSE: 0, BETTER: 2, CHANGED: 3 };

export class Catalogue {
  readonly steps: Step[][]; // of each series, in the order of the runs
  readonly order: number[]; // series, regressions first
  private readonly parameters: string[];
  private readonly places: Field[];
  private readonly haystacks: string[];

  constructor(readonly history: History) {
    this.steps = history.series.map(() => []);
    for (const step of history.steps) this.steps[step.series]?.push(step);
    this.steps.forEach((steps) => steps.sort((a, b) => a.run - b.run));
    this.parameters = varying(history.series);
    this.places = (["experiment", "scene", "view", "resolution", "probe", "device"] as const)
      .filter((field) => this.valuesOf(field).length > 1);
    this.haystacks = history.series.map((series) =>
      [...fields.map((field) => series[field]), ...Object.entries(series.parameters).map(([name, value]) => `${name} ${value}`), series.key].join("\n").toLowerCase());
    const keys = this.steps.map((steps) => [Math.min(4, ...steps.map(urgency)), Math.max(-1, ...steps.map(({ run }) => run))] as const);
    this.order = history.series.map((_, i) => i).sort((a, b) =>
      keys[a]![0] - keys[b]![0] || keys[b]![1] - keys[a]![1] || a - b);
  }

  valuesOf(field: Field): string[] { return [...new Set(this.history.series.map((series) => series[field]))].filter(Boolean); }

  /** "s3ho rmse, filtered": the first line of a name. */
  title(index: number): string {
    const series = this.history.series[index]!;
    return `${series.method} ${series.metric}${series.stage ? `, ${series.stage}` : ""}`;
  }

  /** What else tells a series from the others. */
  place(index: number): string {
    const series = this.history.series[index]!;
    const parameters = this.parameters.filter((name) => series.parameters[name]).map((name) => `${name} ${series.parameters[name]}`);
    return [...this.places.map((field) => series[field]), ...parameters].filter(Boolean).join(" \u00b7 ");
  }

  /** Indices of the series that the filters leave, regressions first. */
  filter(state: State): number[] {
    const words = state.text.toLowerCase().split(/\s+/).filter(Boolean);
    const wanted = fields.filter((field) => state.only[field] !== "");
    return this.order.filter((index) => {
      const series = this.history.series[index]!;
      return wanted.every((field) => series[field] === state.only[field]) &&
        words.every((word) => this.haystacks[index]!.includes(word)) && hasVerdict(this.steps[index]!, state.verdict);
    });
  }

  /** The series that differ in the method alone, as far as their parameters can be compared. */
  siblings(index: number): number[] {
    const own = this.history.series[index]!;
    const alike = (other: Series) => other.method !== own.method &&
      fields.every((field) => field === "method" || other[field] === own[field]) &&
      Object.entries(other.parameters).every(([name, value]) => (own.parameters[name] ?? value) === value);
    return this.history.series.flatMap((other, i) => (alike(other) ? [i] : []));
  }
}

function urgency(step: Step): number { return rank[step.verdict] + (step.intended ? 1 : 0); }

export function isOpen(step: Step): boolean { return step.verdict === "WORSE" && !step.intended; }

function hasVerdict(steps: Step[], verdict: State["verdict"]): boolean {
  if (verdict === "") return true;
  if (verdict === "none") return steps.length === 0;
  return steps.some((step) => (verdict === "open" ? isOpen(step) : step.verdict === verdict));
}

/** What numbers of a series are divided by, and the unit that they then have. */
export function scaleOf(series: Series, floors: boolean): { divisor: number; unit: string } {
  const usable = series.noise_floor !== null && series.noise_floor > 0;
  return floors && usable ? { divisor: series.noise_floor!, unit: "noise floors" } : { divisor: 1, unit: series.unit === "1" ? "" : series.unit };
}
