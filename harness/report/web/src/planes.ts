// Pixels of a layer: a script of one call, as harness/report/plane_codec.h describes.
import { Layer } from "./data";

export interface Pixels {
  width: number;
  height: number;
  channels: number;
  step: number; // the frame's pixels between two of these
  halves: Uint16Array; // IEEE halves, channels interleaved, top row first
}

const firstCode = 0x100;
const predictors = [
  { gradient: false, distance: 1 }, { gradient: true, distance: 1 },
  { gradient: false, distance: 4 }, { gradient: true, distance: 4 },
];

export function bytesOf(text: string, size: number): Uint8Array<ArrayBuffer> {
  if (text.length !== Math.ceil((size * 8) / 15)) throw new Error("cut short");
  const bytes = new Uint8Array(size);
  let bits = 0, count = 0, at = 0;
  for (let i = 0; i < text.length; ++i) {
    bits |= (text.charCodeAt(i) - firstCode) << count;
    count += 15;
    while (count >= 8 && at < bytes.length) {
      bytes[at++] = bits & 0xff;
      bits >>>= 8;
      count -= 8;
    }
  }
  return bytes;
}

/** zlib's own checksum makes this fail for damaged data. */
async function inflate(bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function plane(stream: Uint8Array, at: number, width: number, height: number): Uint16Array {
  const predictor = predictors[stream[at]!];
  if (!predictor) throw new Error("unknown predictor");
  const count = width * height, d = predictor.distance;
  const high = stream.subarray(at + 1, at + 1 + count);
  const low = stream.subarray(at + 1 + count, at + 1 + 2 * count);
  const values = new Uint16Array(count);
  for (let i = 0, y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x, ++i) {
      const z = (high[i]! << 8) | low[i]!;
      const residual = z & 1 ? -((z + 1) >> 1) : z >> 1;
      const left = x >= d ? values[i - d]! : 0;
      let guess = left;
      if (predictor.gradient) {
        const above = y >= d ? values[i - d * width]! : 0;
        const corner = x >= d && y >= d ? values[i - d * width - d]! : 0;
        const sloped = left + above - corner;
        guess = Math.min(Math.max(sloped, Math.min(left, above)), Math.max(left, above));
      }
      values[i] = guess + residual;
    }
  }
  return values;
}

export async function decode(layer: Layer, text: string, size: number): Promise<Pixels> {
  const { width, height, channels } = layer;
  const count = width * height;
  const stream = await inflate(bytesOf(text, size));
  if (stream.length !== channels * (1 + 2 * count)) throw new Error("of another size");
  const planes: Uint16Array[] = [];
  for (let c = 0; c < channels; ++c) planes.push(plane(stream, c * (1 + 2 * count), width, height));
  if (channels === 3) {
    const [green, red, blue] = planes as [Uint16Array, Uint16Array, Uint16Array];
    for (let i = 0; i < count; ++i) {
      red[i]! += green[i]!;
      blue[i]! += green[i]!;
    }
    planes.splice(0, 3, red, green, blue);
  }
  const halves = new Uint16Array(channels * count);
  planes.forEach((values, c) => {
    for (let i = 0; i < count; ++i) {
      const rising = values[i]!;
      halves[channels * i + c] = rising & 0x8000 ? rising - 0x8000 : 0xffff - rising;
    }
  });
  return { width, height, channels, step: layer.step, halves };
}

export function halfToNumber(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1, exponent = (bits >> 10) & 0x1f, fraction = bits & 0x3ff;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

/** The stored values that stand for a pixel of the frame: with a step, those of the pixel above left. */
export function valuesAt(pixels: Pixels, x: number, y: number): number[] {
  const column = Math.min(Math.floor(x / pixels.step), pixels.width - 1);
  const row = Math.min(Math.floor(y / pixels.step), pixels.height - 1);
  const first = (row * pixels.width + column) * pixels.channels;
  return Array.from(pixels.halves.subarray(first, first + pixels.channels), halfToNumber);
}

interface Packed { size: number; text: string }
const waiting = new Map<string, (packed: Packed) => void>();
const loaded = new Map<string, Promise<Pixels>>();

declare global {
  interface Window { occlabLayer: (id: string, size: number, text: string) => void }
}
window.occlabLayer = (id, size, text) => waiting.get(id)?.({ size, text });

function script(layer: Layer): Promise<Packed> {
  return new Promise((resolve, reject) => {
    const element = document.createElement("script");
    const finish = (problem: string) => {
      waiting.delete(layer.id);
      element.remove();
      reject(new Error(problem)); // nothing happens where the call has come
    };
    waiting.set(layer.id, resolve);
    element.onerror = () => finish("its file is missing");
    element.onload = () => finish("its file is damaged");
    element.src = `data/${layer.id}.js`;
    document.head.append(element);
  });
}

/** The pixels of a layer, read once. Rejected where its file is missing or damaged. */
export function load(layer: Layer): Promise<Pixels> {
  let pixels = loaded.get(layer.id);
  if (!pixels) {
    const decoded = ({ text, size }: Packed) => decode(layer, text, size).catch((error: unknown) => {
      throw new Error(`its file is damaged (${error instanceof Error ? error.message : String(error)})`);
    });
    pixels = script(layer).then(decoded);
    loaded.set(layer.id, pixels);
  }
  return pixels;
}
