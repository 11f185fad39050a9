// What S3HO and SSBN know of a pixel, as the S3HO paper's Fig. 5 shows it.
import { Data, Layer } from "./data";
import { h, section } from "./dom";
import { short } from "./numbers";
import { Catalogue } from "./panels";
import { load, valuesAt } from "./planes";
import { Direction, Sphere, Spheres, basis, dot } from "./spheres";

type Rgb = [number, number, number];

const visibilityScale = 1; // of a lobe: the clamped cosine's is about that high

function srgb(linear: number): number {
  const value = Math.min(Math.max(linear, 0), 1);
  return 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
}

function mapColour(colours: string[], position: number): Rgb {
  const index = Math.round(Math.min(Math.max(position, 0), 1) * (colours.length - 1));
  const colour = colours[index]!;
  return [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)) as Rgb;
}

/** The largest value of a light in any direction, from directions spread evenly. */
function peak(sh: number[][]): number {
  const count = 4000, golden = Math.PI * (3 - Math.sqrt(5));
  let most = 0;
  for (let i = 0; i < count; ++i) {
    const y = 1 - (2 * i + 1) / count, radius = Math.sqrt(1 - y * y), phi = golden * i;
    const values = basis([Math.cos(phi) * radius, y, Math.sin(phi) * radius]);
    for (const channel of sh) most = Math.max(most, dot(channel, values));
  }
  return most;
}

/** Half-angle of the bent cone, radians (renderers/shared/representation_bent_cone.h). */
export function coneAngle(length: number, exact: boolean): number {
  const cosine = Math.min(Math.max(2 * length - 1, 0), 1);
  return exact ? Math.acos(cosine) : ((1 - cosine) * Math.PI) / 2;
}

export class Lobes {
  readonly element: HTMLElement;
  private readonly spheres = new Spheres();
  private readonly text = h("p", { class: "note", role: "status" }, "Click a pixel of an image above.");
  private readonly exposure: number; // of light: its peak is white
  private request = 0;

  private constructor(private readonly data: Data, private readonly catalogue: Catalogue,
    private readonly coefficients: Layer[], private readonly bent: Layer[]) {
    const { light } = data;
    this.exposure = light.sh ? 1 / Math.max(peak(light.sh), 1e-30) : 1;
    this.element = section("lobes", "SH lobes", this.text,
      light.missing && h("p", { class: "note" }, `The light is not shown: ${light.missing}.`),
      light.note && h("p", { class: "note" }, `The light is ${light.note}.`), this.spheres.element);
  }

  /** Nothing where no layer holds coefficients or bent normals. */
  static of(data: Data, catalogue: Catalogue): Lobes | null {
    const coefficients = data.layers.filter(({ kind }) => kind === "coefficients");
    const bent = data.layers.filter(({ name }) => name === "bent_normal");
    return coefficients.length + bent.length > 0 ? new Lobes(data, catalogue, coefficients, bent) : null;
  }

  async show(pin: [number, number] | null): Promise<void> {
    const request = ++this.request;
    if (!pin) {
      this.text.textContent = "Click a pixel of an image above.";
      this.spheres.show([]);
      return;
    }
    const spheres: Sphere[] = [];
    try {
      for (const layer of this.coefficients) spheres.push(...this.ofCoefficients(layer, valuesAt(await load(layer), ...pin)));
      if (this.data.light.sh) spheres.push(this.light(this.data.light.sh));
      for (const layer of this.bent) spheres.push(this.ofBentNormal(layer, valuesAt(await load(layer), ...pin)));
    } catch (error) {
      this.text.textContent = `Not shown: ${error instanceof Error ? error.message : String(error)}`;
      return;
    }
    if (request !== this.request) return; // another pixel was asked for meanwhile
    const steps = [...this.coefficients, ...this.bent].map(({ step }) => step);
    const nearest = Math.max(...steps) > 1 ? `; of every ${[...new Set(steps)].join(" or ")} pixels one is stored, the nearest above left is shown` : "";
    this.text.textContent = `Pixel ${pin.join(", ")}, in view space, seen from the camera; drag or arrow keys turn the spheres${nearest}. ` +
      `Lobes: red is +${visibilityScale}, white 0, blue \u2212${visibilityScale}. Light: its brightest channel anywhere is white; what order 4 makes negative is black.`;
    this.spheres.show(spheres);
  }

  private label(layer: Layer): string { return this.catalogue.groupLabel(Number(layer.owner.slice(1))); }

  private toned(radiance: ArrayLike<number>): Rgb {
    return [0, 1, 2].map((c) => srgb(radiance[c]! * this.exposure)) as Rgb;
  }

  private ofCoefficients(layer: Layer, c: number[]): Sphere[] {
    const map = this.data.colourMaps.signed, label = this.label(layer);
    const spheres: Sphere[] = [{
      key: "visibility",
      caption: `${label}: visibility times cosine, order 4; ambient occlusion ${short(1.1283791671 * c[0]!, 3)}`,
      colourOf: (_, values) => mapColour(map, 0.5 + (0.5 * dot(c, values)) / visibilityScale),
    }];
    const { sh } = this.data.light;
    if (sh) {
      const irradiance = sh.map((channel) => dot(channel, c));
      spheres.push({
        key: "product",
        caption: `${label}: light that gets through; its integral is the irradiance, ${irradiance.map((value) => short(value, 4)).join(", ")}`,
        colourOf: (_, values) => this.toned(sh.map((channel) => dot(channel, values) * dot(c, values))),
      });
    }
    return spheres;
  }

  private light(sh: number[][]): Sphere {
    return {
      key: "light", caption: "Incoming light, order 4",
      colourOf: (_, values) => this.toned(sh.map((channel) => dot(channel, values))),
    };
  }

  private ofBentNormal(layer: Layer, bent: number[]): Sphere {
    const { sh } = this.data.light;
    const length = Math.hypot(...bent);
    const exact = this.data.groups[Number(layer.owner.slice(1))]?.parameters.cone_angle === "exact";
    const angle = coneAngle(length, exact), edge = 0.02;
    const axis = bent.map((value) => value / length) as Direction;
    return {
      key: "cone",
      caption: length > 0
        ? `${this.label(layer)}: bent cone on the light, half-angle ${short((angle * 180) / Math.PI, 3)}\u00b0, |N| = ${short(length, 3)}`
        : `${this.label(layer)}: nothing is visible, there is no cone`,
      colourOf: (direction, values) => {
        const light: Rgb = sh ? this.toned(sh.map((channel) => dot(channel, values))) : [128, 128, 128];
        if (!(length > 0)) return light;
        const away = Math.acos(Math.min(Math.max(dot(direction, axis), -1), 1));
        if (away < 0.03 || Math.abs(away - angle) < edge) return [255, 255, 255];
        if (Math.abs(away - angle) < 2 * edge || away < 0.05) return [0, 0, 0];
        return away < angle ? light : (light.map((value) => 0.35 * value) as Rgb);
      },
    };
  }
}
