// What the viewer shows: all of it stands in the address, so that a link opens the same view.

export interface State {
  show: string; // key of a set of panels
  layer: string;
  mode: "grid" | "flip" | "slider";
  active: number; // panel that flip shows, and the slider on its right side
  left: number; // panel on the slider's left side
  split: number; // the slider's place, 0 to 1
  as: "image" | "false" | "signed" | "relative" | "angle";
  stops: number;
  curve: "clamp" | "reinhard" | "filmic";
  scale: number; // end of the colour scales of differences and maps
  zoom: number; // 1: the frame fits
  x: number; // the frame's pixel in the middle of a panel; NaN: the frame's middle
  y: number;
  pin: [number, number] | null; // the pixel whose values are kept
  boxes: boolean; // closeup rectangles
}

export const scales = [0.05, 0.1, 0.25, 0.5, 1, 2];
export const defaults: State = {
  show: "", layer: "radiance", mode: "grid", active: 0, left: 0, split: 0.5, as: "image", stops: 0,
  curve: "clamp", scale: 0.5, zoom: 1, x: NaN, y: NaN, pin: null, boxes: false,
};

function oneOf<T extends string>(text: string | undefined, accepted: readonly T[], otherwise: T): T {
  return accepted.includes(text as T) ? (text as T) : otherwise;
}

function number(text: string | undefined, otherwise: number, least: number, most: number): number {
  const value = text === undefined || text === "" ? NaN : Number(text);
  return Number.isFinite(value) ? Math.min(Math.max(value, least), most) : otherwise;
}

/** Reads an address's "#a=1&b=2"; what is odd in it is left out. */
export function readHash(hash: string, base: State): { state: State; cell: string; viewed: boolean } {
  const parts = new Map(hash.replace(/^#/, "").split("&").map((part) => {
    const [name, ...value] = part.split("=");
    let text = value.join("=");
    try { text = decodeURIComponent(text); } catch { /* kept as it is */ }
    return [name ?? "", text] as const;
  }));
  const get = (name: string) => parts.get(name);
  const pin = (get("pin") ?? "").split(",").map(Number);
  const state: State = {
    show: get("show") ?? base.show,
    layer: get("layer") ?? base.layer,
    mode: oneOf(get("mode"), ["grid", "flip", "slider"], base.mode),
    active: number(get("active"), base.active, 0, 99),
    left: number(get("left"), base.left, 0, 99),
    split: number(get("split"), base.split, 0, 1),
    as: oneOf(get("as"), ["image", "false", "signed", "relative", "angle"], base.as),
    stops: number(get("ev"), base.stops, -12, 12),
    curve: oneOf(get("curve"), ["clamp", "reinhard", "filmic"], base.curve),
    scale: scales.includes(Number(get("scale"))) ? Number(get("scale")) : base.scale,
    zoom: number(get("zoom"), base.zoom, 1, 64),
    x: number(get("x"), base.x, 0, 1e6),
    y: number(get("y"), base.y, 0, 1e6),
    pin: pin.length === 2 && pin.every((p) => Number.isInteger(p) && p >= 0) ? [pin[0]!, pin[1]!] : base.pin,
    boxes: get("boxes") === undefined ? base.boxes : get("boxes") === "1",
  };
  return { state, cell: get("cell") ?? "", viewed: parts.has("show") };
}

export function writeHash(state: State): string {
  const parts: [string, string][] = [
    ["show", state.show], ["layer", state.layer], ["mode", state.mode], ["active", String(state.active)],
    ["left", String(state.left)], ["split", String(Number(state.split.toFixed(4)))], ["as", state.as],
    ["ev", String(state.stops)], ["curve", state.curve], ["scale", String(state.scale)],
    ["zoom", String(Number(state.zoom.toFixed(4)))], ["x", Number.isNaN(state.x) ? "" : state.x.toFixed(2)],
    ["y", Number.isNaN(state.y) ? "" : state.y.toFixed(2)], ["pin", state.pin ? state.pin.join(",") : ""],
    ["boxes", state.boxes ? "1" : "0"],
  ];
  return "#" + parts.filter(([, value]) => value !== "").map(([name, value]) =>
    `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`).join("&");
}
