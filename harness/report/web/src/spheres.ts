// Functions on the sphere, drawn as spheres seen from the camera.
import { button, h } from "./dom";

export type Direction = [number, number, number]; // view space: x right, y up, z towards the camera

/** Order-4 real SH with the signs of renderers/shared/sh.h (Sloan 2008, appendix A2). */
export function basis([x, y, z]: Direction): number[] {
  const xx = x * x, yy = y * y, zz = z * z;
  return [
    0.2820947918, -0.4886025119 * y, 0.4886025119 * z, -0.4886025119 * x,
    1.0925484306 * x * y, -1.0925484306 * y * z, 0.3153915653 * (3 * zz - 1), -1.0925484306 * x * z,
    0.5462742153 * (xx - yy), -0.5900435899 * y * (3 * xx - yy), 2.8906114426 * x * y * z, -0.4570457995 * y * (5 * zz - 1),
    0.3731763326 * z * (5 * zz - 3), -0.4570457995 * x * (5 * zz - 1), 1.4453057213 * z * (xx - yy), -0.5900435899 * x * (xx - 3 * yy),
  ];
}

export function dot(a: ArrayLike<number>, b: ArrayLike<number>): number {
  let sum = 0;
  for (let i = 0; i < a.length; ++i) sum += a[i]! * b[i]!;
  return sum;
}

export interface Sphere {
  key: string;
  caption: string;
  colourOf: (direction: Direction, values: number[]) => [number, number, number]; // 0 to 255; values: the basis
}

const size = 220; // pixels

/** Spheres that turn together, by mouse and arrow keys. */
export class Spheres {
  readonly element = h("div", { class: "lobes" });
  private turn: [number, number] = [0, 0]; // radians: right, up
  private shown: { sphere: Sphere; canvas: HTMLCanvasElement }[] = [];

  show(spheres: Sphere[]): void {
    this.shown = spheres.map((sphere) => ({ sphere, canvas: this.canvas(sphere) }));
    const back = () => { this.turn = [this.turn[0] + Math.PI, -this.turn[1]]; this.draw(); };
    const front = () => { this.turn = [0, 0]; this.draw(); };
    this.element.replaceChildren(
      ...this.shown.map(({ sphere, canvas }) => h("figure", { class: "lobe", "data-lobe": sphere.key }, canvas, h("figcaption", {}, sphere.caption))),
      h("div", { class: "buttons" }, button("from the camera", front), button("from behind", back)));
    this.draw();
  }

  private canvas(sphere: Sphere): HTMLCanvasElement {
    const canvas = h("canvas", { width: size, height: size, tabindex: 0, role: "img", "aria-label": sphere.caption });
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons !== 1) return;
      this.turn = [this.turn[0] + event.movementX * 0.01, this.turn[1] + event.movementY * 0.01];
      this.draw();
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (!step) return;
      event.preventDefault();
      this.turn = [this.turn[0] + step[0]!, this.turn[1] + step[1]!];
      this.draw();
    });
    return canvas;
  }

  private draw(): void {
    const [cosine, sine] = [Math.cos(this.turn[0]), Math.sin(this.turn[0])];
    const [cosineUp, sineUp] = [Math.cos(this.turn[1]), Math.sin(this.turn[1])];
    const images = this.shown.map(({ canvas }) => canvas.getContext("2d")!.createImageData(size, size));
    for (let row = 0; row < size; ++row) {
      for (let column = 0; column < size; ++column) {
        const u = (2 * (column + 0.5)) / size - 1, v = 1 - (2 * (row + 0.5)) / size;
        const inside = 1 - u * u - v * v;
        if (inside < 0) continue;
        // What faces us, turned back: first about x, then about y.
        const w = Math.sqrt(inside);
        const y = cosineUp * v + sineUp * w, z = cosineUp * w - sineUp * v;
        const direction: Direction = [cosine * u - sine * z, y, sine * u + cosine * z];
        const values = basis(direction), at = 4 * (row * size + column);
        this.shown.forEach(({ sphere }, i) => images[i]!.data.set([...sphere.colourOf(direction, values), 255], at));
      }
    }
    this.shown.forEach(({ canvas }, i) => canvas.getContext("2d")!.putImageData(images[i]!, 0, 0));
  }
}
