// What occlab wrote into the page (harness/report/writer.cpp), and how the page names it.

export interface Cell { id: string; seed: string; problem: string }
export interface Group {
  method: string;
  parameters: Record<string, string>;
  reference: boolean;
  truth: number; // index of the group that it is compared with, where there is a reference
  cells: Cell[];
}
export interface Layer {
  id: string; owner: string; name: string; kind: Kind; cell: string;
  width: number; height: number; channels: number; step: number;
  note: string; bytes: number; preview: string;
}
export type Kind = "radiance" | "share" | "direction" | "signed" | "positive" | "coefficients";
export interface TableNumber { value: number | string; lower?: number | string; upper?: number | string; winner?: boolean }
export type TableCell = string | TableNumber | { missing: string };
export interface Table {
  name: string; title: string;
  columns: { name: string; unit: string }[];
  rows: TableCell[][];
  notes: string[];
}
export interface PlotGroup { method: string; parameters: Record<string, string>; resolution: string; scene: string }
export interface Row {
  group: number; view: string; metric: string; n: number;
  stage?: string; unit?: string; value?: number | string; lower?: number | string; upper?: number | string;
  reason?: string; clock?: string;
}
export interface Figure {
  name: string; kind: string; title: string; stage: string; scale: number;
  file?: string; width?: number; height?: number; missing?: string;
}
export interface Closeup {
  figure: string; stage: string; label: string;
  rectangle: [number, number, number, number];
  select: Record<string, string>;
}
export interface Published {
  source: string;
  times: { method: string; device: string; samples: string; steps: string; time_ms: number; resolution: string; origin: string }[];
}
export interface Data {
  format: number;
  occlab: string;
  complete: boolean;
  problems: string[];
  leftOut: string[];
  run: Record<string, unknown> | null;
  tables: Table[];
  plots: { groups: PlotGroup[]; rows: Row[] };
  published: Published | null;
  figures: Figure[];
  closeups: Closeup[];
  methods: Record<string, { title: string; colour: string }>;
  frame: { width: number; height: number; meanLuminance: number; exposure: number };
  metrics: { name: string; unit: string; definition: string; lowerIsBetter: boolean }[];
  colourMaps: { signed: string[]; positive: string[] };
  groups: Group[];
  otherCells: (Cell & { method: string; parameters: Record<string, string> })[];
  layers: Layer[];
  light: { sh?: number[][]; note?: string; missing?: string };
}

export function readData(): Data {
  const element = document.getElementById("occlab-data");
  return JSON.parse(element?.textContent ?? "") as Data;
}

/** The value at a path of run.json, as text; "" where it is not there. */
export function fact(data: Data, ...path: string[]): string {
  let value: unknown = data.run;
  for (const key of path) {
    if (typeof value !== "object" || value === null) return "";
    value = (value as Record<string, unknown>)[key];
  }
  return value === undefined || value === null || typeof value === "object" ? "" : String(value);
}

export function title(data: Data, method: string): string {
  return data.methods[method]?.title ?? method;
}

export function colour(data: Data, method: string): string {
  return data.methods[method]?.colour ?? "#888888";
}

/** Parameters that tell groups of one method apart, in the order of their first appearance. */
export function varying(groups: { method: string; parameters: Record<string, string> }[]): string[] {
  const values = new Map<string, Map<string, Set<string>>>();
  for (const group of groups) {
    for (const [name, value] of Object.entries(group.parameters)) {
      if (!value) continue;
      const byMethod = values.get(name) ?? new Map<string, Set<string>>();
      const seen = byMethod.get(group.method) ?? new Set<string>();
      values.set(name, byMethod.set(group.method, seen.add(value)));
    }
  }
  const several = (byMethod: Map<string, Set<string>>) => [...byMethod.values()].some((set) => set.size > 1);
  return [...values.entries()].filter(([, byMethod]) => several(byMethod)).map(([name]) => name);
}

/** "samples 32": what tells a group from others of its method. */
export function variantLabel(parameters: Record<string, string>, names: string[]): string {
  return names.filter((name) => parameters[name]).map((name) => `${name} ${parameters[name]}`).join(", ");
}

/** The index in data.groups of the group with a method and parameters; -1 if no image is of it. */
export function findGroup(data: Data, method: string, parameters: Record<string, string>): number {
  return data.groups.findIndex((group) => group.method === method &&
    Object.entries(group.parameters).every(([name, value]) => parameters[name] === value));
}
