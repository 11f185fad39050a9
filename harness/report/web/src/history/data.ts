// What occlab wrote into the page of a history (occlab history report), and how the page reads it.

export type Verdict = "WORSE" | "BETTER" | "CHANGED";
export interface Run {
  id: number; commit: string; subject: string; commit_time: string; added: string;
  experiment: string; device: string; baseline: boolean;
}
export interface Series {
  key: string; experiment: string; scene: string; view: string; resolution: string; probe: string;
  method: string; parameters: Record<string, string>; stage: string; metric: string; unit: string;
  device: string; better: "lower" | "higher" | "none"; noise_floor: number | null;
}
export interface Step {
  series: number; run: number; before_run: number; // indices; the runs after and before the step
  before: number; after: number;
  lower: number | null; upper: number | null; // 95% interval of after / before
  p: number | null; verdict: Verdict;
  intended: { who: string; when: string; why: string } | null;
}
export interface Picture {
  run: number; scene: string; view: string; method: string; parameters: Record<string, string>;
  stage: string; file: string;
}
export interface History {
  format: number; written: string; project: string; level: number; minimum_effect: number;
  accept_command?: string;
  runs: Run[]; series: Series[]; steps: Step[]; images: Picture[];
}
interface Packed { encoding: string; value: string; lower: string; upper: string }

/** Numbers of all series, those of a series one after the other in the order of the runs. */
export interface Values { runs: number; value: Float32Array; lower: Float32Array; upper: Float32Array }

export function readHistory(): History {
  const history = JSON.parse(document.getElementById("occlab-data")?.textContent ?? "") as History;
  if (history.format !== 1) throw new Error(`the data has format ${String(history.format)}, this page reads 1`);
  return history;
}

async function floats(text: string, count: number, name: string): Promise<Float32Array> {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  if (buffer.byteLength !== 4 * count) throw new Error(`values.${name}: ${buffer.byteLength} bytes instead of ${4 * count}`);
  if (new Uint8Array(new Uint16Array([1]).buffer)[0] === 1) return new Float32Array(buffer);
  const view = new DataView(buffer);
  return Float32Array.from({ length: count }, (_, i) => view.getFloat32(4 * i, true));
}

/** Resolves when all of the page's file has been read. */
function wholePage(): Promise<void> {
  return new Promise((resolve) => {
    if (document.readyState !== "loading") resolve();
    else document.addEventListener("DOMContentLoaded", () => resolve(), { once: true });
  });
}

export async function readValues(history: History): Promise<Values> {
  await wholePage();
  const runs = history.runs.length, count = history.series.length * runs;
  const { value, lower, upper } = JSON.parse(document.getElementById("occlab-values")?.textContent ?? "") as Packed;
  const all = await Promise.all([floats(value, count, "value"), floats(lower, count, "lower"), floats(upper, count, "upper")]);
  return { runs, value: all[0], lower: all[1], upper: all[2] };
}

export const shortCommit = (commit: string): string => (commit ? commit.slice(0, 10) : "no commit");
export const dateOf = (run: Run): string => (run.commit_time || run.added).slice(0, 10);
/** "a1b2c3..d4e5f6": what git log takes for the commits that may have caused a step. */
export function commitRange(history: History, step: Step): string {
  const [before, after] = [history.runs[step.before_run], history.runs[step.run]];
  return `${shortCommit(before?.commit ?? "")}..${shortCommit(after?.commit ?? "")}`;
}
