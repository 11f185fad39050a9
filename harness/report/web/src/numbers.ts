// Numbers for people, as the tables of occlab print them (harness/table_formats.cpp).

export function short(value: number, digits = 4): string {
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "\u221e" : "\u2212\u221e";
  if (value === 0) return "0";
  const magnitude = Math.abs(value);
  const text = magnitude < 1e-4 || magnitude >= 1e7
    ? value.toExponential(digits - 1)
    : String(Number(value.toPrecision(digits)));
  return text.replace("-", "\u2212");
}

/** With a plus sign before what is positive. */
export function signed(value: number, digits = 3): string {
  return (value > 0 ? "+" : "") + short(value, digits);
}

/** A number and its interval, rounded alike: to two digits of the interval's half-width. */
export function withInterval(value: number, lower: number, upper: number): [string, string, string] {
  const half = (upper - lower) / 2;
  const largest = Math.max(Math.abs(value), Math.abs(lower), Math.abs(upper));
  if (!(half > 0) || !Number.isFinite(half) || !Number.isFinite(value)) {
    return [short(value), short(lower), short(upper)];
  }
  const exponent = Math.floor(Math.log10(half));
  const minus = (text: string) => text.replace("-", "\u2212");
  if (largest < 1e-4 || largest >= 1e7) {
    const digits = Math.min(Math.max(Math.floor(Math.log10(largest)) - exponent + 1, 0), 16);
    const spell = (number: number) => minus(number.toExponential(digits));
    return [spell(value), spell(lower), spell(upper)];
  }
  const decimals = Math.min(Math.max(1 - exponent, 0), 16);
  const spell = (number: number) => minus(number.toFixed(decimals));
  return [spell(value), spell(lower), spell(upper)];
}

/** JSON has no infinity: occlab writes "inf" and "-inf". */
export function toNumber(value: number | string | undefined): number {
  if (typeof value === "number") return value;
  return value === "inf" ? Infinity : value === "-inf" ? -Infinity : NaN;
}

/** 1, 2 or 5 times a power of ten, about `count` of them. */
export function niceTicks(low: number, high: number, count: number): number[] {
  if (!(high > low)) return [low];
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((factor) => factor * power >= rough) ?? 10);
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push(Number((i * step).toPrecision(12)));
  return ticks;
}

/** Of a logarithmic axis: powers of ten, with 2 and 5 times these below two decades; niceTicks() below one. */
export function logTicks(low: number, high: number): number[] {
  if (!(low > 0) || !(high > low)) return low > 0 ? [low] : [];
  const decades = Math.log10(high / low);
  if (decades < 1) return niceTicks(low, high, 6).filter((tick) => tick > 0);
  const ticks: number[] = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); ++power) {
    for (const factor of decades < 2.5 ? [1, 2, 5] : [1]) ticks.push(Number((factor * 10 ** power).toPrecision(12)));
  }
  return ticks.filter((tick) => tick >= low && tick <= high);
}
