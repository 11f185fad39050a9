// Where panels lie and which part of the frame they show.
import { State } from "./state";

export interface Rect { x: number; y: number; width: number; height: number }

const gap = 6; // CSS pixels

/** CSS pixels; as text, it grows with the window. */
export function rootFontSize(): number {
  return parseFloat(getComputedStyle(document.documentElement).fontSize);
}
export function labelHeight(): number { return Math.round(1.7 * rootFontSize()); }

/** Rectangles of `count` images of the frame's shape, as large as they fit side by side. */
export function layOut(count: number, width: number, height: number, aspect: number): { rects: Rect[]; height: number } {
  const label = labelHeight();
  let best = { columns: 1, imageWidth: 0 };
  for (let columns = 1; columns <= count; ++columns) {
    const rows = Math.ceil(count / columns);
    const byWidth = (width - gap * (columns - 1)) / columns;
    const byHeight = ((height - gap * (rows - 1)) / rows - label) * aspect;
    const imageWidth = Math.min(byWidth, byHeight);
    // More columns leave less of the page empty and need less of its height.
    if (imageWidth > 0.9 * best.imageWidth) best = { columns, imageWidth };
  }
  const imageWidth = Math.max(best.imageWidth, 40), imageHeight = imageWidth / aspect;
  const rects = Array.from({ length: count }, (_, i) => ({
    x: (i % best.columns) * (imageWidth + gap),
    y: Math.floor(i / best.columns) * (imageHeight + label + gap) + label,
    width: imageWidth, height: imageHeight,
  }));
  const last = rects[rects.length - 1];
  return { rects, height: last ? last.y + last.height : label };
}

export interface Transform { center: [number, number]; scale: number } // CSS pixels of a frame's pixel

export function transformOf(state: State, rect: Rect, frame: [number, number]): Transform {
  const fit = Math.min(rect.width / frame[0], rect.height / frame[1]);
  const x = Number.isNaN(state.x) ? frame[0] / 2 : state.x, y = Number.isNaN(state.y) ? frame[1] / 2 : state.y;
  return { center: [x, y], scale: fit * state.zoom };
}

/** The frame's position under a place in a panel. */
export function toFrame(at: Transform, rect: Rect, x: number, y: number): [number, number] {
  return [at.center[0] + (x - rect.x - rect.width / 2) / at.scale, at.center[1] + (y - rect.y - rect.height / 2) / at.scale];
}

/** Keeps the frame's edges at or outside of the panel's. */
export function clampCenter(state: State, frame: [number, number]): void {
  const clamp = (value: number, extent: number) => {
    const half = extent / (2 * state.zoom);
    return Math.min(Math.max(Number.isNaN(value) ? extent / 2 : value, half), extent - half);
  };
  if (state.zoom <= 1) {
    [state.zoom, state.x, state.y] = [1, NaN, NaN];
  } else {
    [state.x, state.y] = [clamp(state.x, frame[0]), clamp(state.y, frame[1])];
  }
}
