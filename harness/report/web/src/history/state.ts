// What the page of a history shows: all of it stands in the address, so that a link opens the same.

/** Properties of a series that can be filtered by, in the order of their lists. */
export const fields = ["experiment", "scene", "view", "resolution", "probe", "method", "stage", "metric", "device"] as const;
export type Field = (typeof fields)[number];
export const verdicts = ["", "open", "WORSE", "BETTER", "CHANGED", "none"] as const;

export interface State {
  only: Record<Field, string>; // "": all
  verdict: (typeof verdicts)[number];
  text: string;
  floors: boolean; // errors divided by the noise floor
  series: string; // key of the one that is drawn large; "": the first of the list
  from: number; // ids of the first and the last run that is drawn; NaN: all
  to: number;
  at: number; // id of the run whose values are kept; NaN: none
  image: string; // which picture, by what it is of; "": the first
  a: number; // ids of the two runs that are flipped; NaN: chosen by the page
  b: number;
  side: "a" | "b" | "difference";
}

export const defaults: State = {
  only: Object.fromEntries(fields.map((field) => [field, ""])) as Record<Field, string>,
  verdict: "", text: "", floors: false, series: "", from: NaN, to: NaN, at: NaN, image: "", a: NaN, b: NaN, side: "b",
};

function whole(text: string | null): number {
  return text !== null && /^\d{1,15}$/.test(text) ? Number(text) : NaN;
}

/** Reads an address's "#a=1&b=2"; what is odd in it is left out. */
export function readHash(hash: string): State {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  const verdict = verdicts.find((known) => known === parts.get("verdict")) ?? "";
  const side = (["a", "b", "difference"] as const).find((known) => known === parts.get("side")) ?? "b";
  return {
    only: Object.fromEntries(fields.map((field) => [field, parts.get(field) ?? ""])) as Record<Field, string>,
    verdict, side, text: parts.get("text") ?? "", floors: parts.get("floors") === "1", series: parts.get("series") ?? "",
    from: whole(parts.get("from")), to: whole(parts.get("to")), at: whole(parts.get("at")),
    image: parts.get("image") ?? "", a: whole(parts.get("a")), b: whole(parts.get("b")),
  };
}

export function writeHash(state: State): string {
  const id = (value: number) => (Number.isNaN(value) ? "" : String(value));
  const parts: [string, string][] = [
    ...fields.map((field): [string, string] => [field, state.only[field]]), ["verdict", state.verdict], ["text", state.text],
    ["floors", state.floors ? "1" : ""], ["series", state.series], ["from", id(state.from)], ["to", id(state.to)], ["at", id(state.at)],
    ["image", state.image], ["a", id(state.a)], ["b", id(state.b)], ["side", state.side === "b" ? "" : state.side],
  ];
  return "#" + new URLSearchParams(parts.filter(([, value]) => value !== "")).toString();
}
