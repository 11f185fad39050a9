// Which images there are to look at beside each other.
import { Data, Layer, colour, title, variantLabel, varying } from "./data";

export interface Panel {
  label: string;
  colour: string;
  layer: Layer;
  reference: Layer | null; // what differences are to; null: there is nothing to compare with
  group: number; // index in data.groups; -1 for the failure classes
}

export interface PanelSet {
  key: string;
  label: string;
  layers: string[]; // layers to choose from; empty: the panels are what they are
  panels: (layer: string) => Panel[];
}

const layerTitles: Record<string, string> = {
  radiance: "image", radiance_unfiltered: "image before the filter", ambient_occlusion: "ambient occlusion",
  uniform_occlusion: "uniform occlusion", bent_normal: "bent normal", irradiance: "irradiance",
  noise: "noise over the seeds", noise_unfiltered: "noise before the filter", bias: "bias over the seeds",
};

export function layerTitle(name: string): string {
  return layerTitles[name] ?? name.replace(/^(budget|failure)_/, "").replaceAll("_", " ");
}

/** Layers that a panel can show by themselves. */
function shown(layer: Layer): boolean {
  return layer.kind !== "coefficients" && layer.name !== "mask";
}

export class Catalogue {
  readonly sets: PanelSet[] = [];
  private readonly names: string[];
  private readonly reference: number;

  constructor(private readonly data: Data) {
    this.names = varying(data.groups.filter((group) => !group.reference));
    this.reference = data.groups.findIndex((group) => group.reference);
    this.addVariants();
    this.addMethods();
    this.addParts();
  }

  find(key: string): PanelSet | undefined {
    return this.sets.find((set) => set.key === key) ?? this.sets[0];
  }

  /** The first set that shows the image of a group, and its place there. */
  placeOf(group: number): { set: PanelSet; place: number } | null {
    for (const set of this.sets) {
      const place = set.panels("radiance").findIndex((panel) => panel.group === group && panel.layer.name === "radiance");
      if (place >= 0) return { set, place };
    }
    return null;
  }

  layerOf(owner: string, name: string): Layer | null {
    return this.data.layers.find((layer) => layer.owner === owner && layer.name === name) ?? null;
  }

  groupLabel(group: number): string {
    const { method, parameters, reference } = this.data.groups[group]!;
    const variant = reference ? "reference" : variantLabel(parameters, this.names);
    return [title(this.data, method), variant].filter(Boolean).join(", ");
  }

  private panel(group: number, name: string): Panel | null {
    const layer = this.layerOf(`g${group}`, name);
    if (!layer || !shown(layer)) return null;
    // Images before the filter are compared with the reference's image, too.
    const compared = layer.kind === "radiance" && name.startsWith("radiance") ? "radiance" : name;
    const comparable = (layer.kind === "radiance" || layer.kind === "share") && this.reference >= 0;
    return {
      label: this.groupLabel(group), colour: colour(this.data, this.data.groups[group]!.method), layer, group,
      reference: comparable ? this.layerOf(`g${this.data.groups[group]!.truth}`, compared) : null,
    };
  }

  private layersOf(groups: number[]): string[] {
    const names = new Set<string>();
    for (const layer of this.data.layers) {
      if (shown(layer) && !layer.name.startsWith("budget_") && groups.some((group) => layer.owner === `g${group}`)) {
        names.add(layer.name);
      }
    }
    const order = Object.keys(layerTitles);
    return [...names].sort((a, b) => (order.indexOf(a) + 99) % 99 - (order.indexOf(b) + 99) % 99);
  }

  private add(key: string, label: string, groups: number[]): void {
    const all = this.reference >= 0 ? [this.reference, ...groups] : groups;
    const panels = (layer: string) =>
      all.map((group) => this.panel(group, layer)).filter((panel): panel is Panel => panel !== null);
    this.sets.push({ key, label, layers: this.layersOf(all), panels });
  }

  private withImages(): number[] {
    return this.data.groups.map((_, i) => i).filter((i) => !this.data.groups[i]!.reference && this.layerOf(`g${i}`, "radiance"));
  }

  private addVariants(): void {
    const variants = new Map<string, number[]>();
    for (const group of this.withImages()) {
      const label = variantLabel(this.data.groups[group]!.parameters, this.names);
      variants.set(label, [...(variants.get(label) ?? []), group]);
    }
    for (const [label, groups] of variants) this.add(label || "all", label ? `all methods, ${label}` : "all methods", groups);
    if (variants.size === 0 && this.reference >= 0 && this.layerOf(`g${this.reference}`, "radiance")) {
      this.add("reference", "the reference", []);
    }
  }

  private addMethods(): void {
    const methods = new Map<string, number[]>();
    for (const group of this.withImages()) {
      const method = this.data.groups[group]!.method;
      methods.set(method, [...(methods.get(method) ?? []), group]);
    }
    for (const [method, groups] of methods) {
      if (groups.length > 1) this.add(method, `${title(this.data, method)}, all parameters`, groups);
    }
  }

  private addParts(): void {
    const parts = (prefix: string, owner: string) =>
      this.data.layers.filter((layer) => layer.owner === owner && layer.name.startsWith(prefix));
    const fixed = (key: string, label: string, layers: Layer[], group: number) => {
      if (layers.length === 0) return;
      const method = group >= 0 ? this.data.groups[group]!.method : "";
      const panels = layers.map((layer) => ({
        label: layerTitle(layer.name), colour: colour(this.data, method), layer, reference: null, group,
      }));
      this.sets.push({ key, label, layers: [], panels: () => panels });
    };
    this.data.groups.forEach((_, group) => fixed(`budget ${group}`, `error budget of ${this.groupLabel(group)}`,
      parts("budget_", `g${group}`), group));
    fixed("march", "failure classes of the march", parts("failure_", "march"), -1);
  }
}
