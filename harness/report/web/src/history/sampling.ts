// Long series in few points: the extremes of every column of pixels.
import { Values } from "./data";

/** Of each column, over its runs: extremes of the values, and of the ends of the intervals. */
export interface Columns { count: number; low: Float32Array; high: Float32Array; lower: Float32Array; upper: Float32Array }

/** The runs [from, to] of a series in `count` columns; NaN where a column has none. */
export function columnsOf(values: Values, series: number, from: number, to: number, count: number): Columns {
  const make = () => new Float32Array(count).fill(NaN);
  const result: Columns = { count, low: make(), high: make(), lower: make(), upper: make() };
  const start = series * values.runs, span = to - from;
  for (let run = from; run <= to; ++run) {
    const value = values.value[start + run]!;
    if (Number.isNaN(value)) continue;
    const column = span === 0 ? 0 : Math.floor(((run - from) / span) * (count - 1) + 0.5);
    const lower = values.lower[start + run]!, upper = values.upper[start + run]!;
    if (!(result.low[column]! <= value)) result.low[column] = value;
    if (!(result.high[column]! >= value)) result.high[column] = value;
    if (!Number.isNaN(lower) && !(result.lower[column]! <= lower)) result.lower[column] = lower;
    if (!Number.isNaN(upper) && !(result.upper[column]! >= upper)) result.upper[column] = upper;
  }
  return result;
}

/** Least and largest finite number; null where there is none. */
export function extent(...arrays: Float32Array[]): [number, number] | null {
  let low = Infinity, high = -Infinity;
  for (const array of arrays) {
    for (const value of array) {
      if (!Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : null;
}

/** The last run at or before `run` at which a series was measured; -1 if there is none. */
export function lastMeasured(values: Values, series: number, run: number): number {
  while (run >= 0 && Number.isNaN(values.value[series * values.runs + run]!)) --run;
  return run;
}
