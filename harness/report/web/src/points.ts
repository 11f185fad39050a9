// Measurements as points of plots.
import { Data, Row, colour, findGroup, title, varying } from "./data";
import { toNumber } from "./numbers";

export interface Point {
  method: string; // its title
  name: string; // its name
  facts: Record<string, string>; // parameters and resolution
  metric: string;
  stage: string;
  value: number;
  lower: number; // the value where there is no interval
  upper: number;
  n: number;
  label: string; // "samples 32"
  href: string;
  measured: boolean; // has an interval
}

/** Whole views only: closeups have rows of their own in the tables. */
const wholeView = (row: Row) => !row.view.includes("[");

export class Points {
  private readonly names: string[];

  constructor(readonly data: Data) {
    this.names = varying(this.all());
  }

  private all(): { method: string; parameters: Record<string, string> }[] {
    return this.data.plots.groups.map(({ method, parameters, resolution }) => ({ method, parameters: { ...parameters, resolution } }));
  }

  /** Numbers with a value, of one metric and stage. */
  of(metric: string, stage?: string): Point[] {
    return this.data.plots.rows.filter((row) => row.metric === metric && wholeView(row) &&
      (stage === undefined || (row.stage ?? "") === stage) && row.value !== undefined).map((row) => this.point(row));
  }

  metrics(prefix: string): string[] {
    const names = this.data.plots.rows.filter((row) => row.metric.startsWith(prefix)).map((row) => row.metric.slice(prefix.length));
    return [...new Set(names)];
  }

  has(metric: string): boolean { return this.data.plots.rows.some((row) => row.metric === metric && row.value !== undefined); }

  stages(metric: string): string[] {
    return [...new Set(this.data.plots.rows.filter((row) => row.metric === metric).map((row) => row.stage ?? ""))];
  }

  private point(row: Row): Point {
    const { method, parameters, resolution } = this.data.plots.groups[row.group]!;
    const facts = { ...parameters, resolution };
    const value = toNumber(row.value), measured = row.lower !== undefined;
    const label = this.names.filter((name) => facts[name as keyof typeof facts]).map((name) => `${name} ${facts[name as keyof typeof facts]}`).join(", ");
    return {
      method: title(this.data, method), name: method, facts, metric: row.metric, stage: row.stage ?? "", value,
      lower: measured ? toNumber(row.lower) : value, upper: measured ? toNumber(row.upper) : value, n: row.n, label, measured,
      href: this.href(method, parameters, row.metric),
    };
  }

  /** A mark leads to its cell, times that have none to their table. */
  private href(method: string, parameters: Record<string, string>, metric: string): string {
    const group = this.data.groups[findGroup(this.data, method, parameters)];
    const cell = group?.cells[0];
    return cell ? `#cell=${cell.id}` : metric.startsWith("time_") ? "#cell=table-timing" : "#cell=tables";
  }

  /** Facts that are numbers and take at least two values among the points of one method. */
  axes(points: Point[]): string[] {
    return varying(points.map(({ name, facts }) => ({ method: name, parameters: facts })))
      .filter((name) => points.every(({ facts }) => !facts[name] || Number.isFinite(along(facts, name))));
  }

  /** The points that lie on curves of at least two along an axis, all else being equal. */
  curves(points: Point[], axis: string): (Point & { along: number; curve: string })[] {
    const placed = points.filter(({ facts }) => facts[axis]).map((point) => {
      const rest = Object.entries(point.facts).filter(([name]) => name !== axis).flat();
      return { ...point, along: along(point.facts, axis), curve: JSON.stringify([point.name, rest]) };
    });
    const counts = new Map<string, number>();
    for (const { curve } of placed) counts.set(curve, (counts.get(curve) ?? 0) + 1);
    return placed.filter(({ curve }) => counts.get(curve)! > 1).sort((a, b) => a.along - b.along);
  }

  /** Titles and colours of the methods among points, in the order of the run. */
  scale(points: Point[]): { domain: string[]; range: string[] } {
    const names = [...new Set(points.map(({ name }) => name))];
    return { domain: names.map((name) => title(this.data, name)), range: names.map((name) => forScreen(colour(this.data, name))) };
  }
}

/** Where a point lies on an axis; a resolution by its pixels. */
function along(facts: Record<string, string>, name: string): number {
  const text = facts[name] ?? "";
  const size = /^(\d+)x(\d+)$/.exec(text);
  return size ? Number(size[1]) * Number(size[2]) : Number(text);
}

/** The figures' colours are for white paper: on a dark screen they are mixed with white. */
export function forScreen(hex: string): string {
  if (!matchMedia("(prefers-color-scheme: dark)").matches) return hex;
  const mixed = [1, 3, 5].map((at) => Math.round(0.55 * parseInt(hex.slice(at, at + 2), 16) + 0.45 * 255));
  return `rgb(${mixed.join(",")})`;
}
