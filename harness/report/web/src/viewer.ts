// The image viewer: panels of one frame, zoomed and panned together.
import { Controls, controls } from "./controls";
import { Data } from "./data";
import { displayOf, legend, readingAt, scaleOf, unitOf } from "./display";
import { h, section } from "./dom";
import { Rect, clampCenter, labelHeight, layOut, toFrame, transformOf } from "./layout";
import { Catalogue, Panel } from "./panels";
import { Pixels, load } from "./planes";
import { Line, readout } from "./readout";
import { PanelDrawing, Renderer } from "./renderer";
import { State, writeHash } from "./state";

interface Placed { panel: Panel; rect: Rect; clip: [number, number] }

export class Viewer {
  readonly element: HTMLElement;
  /** Called when a pixel has been clicked or moved. */
  onPin: (pin: [number, number] | null) => void = () => undefined;
  private readonly canvas = h("canvas", {});
  private readonly overlay = h("div", { class: "overlay" });
  private readonly stage = h("div", { class: "stage", tabindex: 0, role: "application",
    "aria-label": "Images. Keys 1 to 9 flip, g side by side, f flip, s slider, arrows move, plus and minus zoom, " +
      "0 whole image, e and E exposure, d difference, l layer, Shift with arrows moves the pixel" }, this.canvas, this.overlay);
  private readonly legendBox = h("div", { class: "legends" });
  private readonly readoutBox = h("div", {});
  private readonly bar: Controls;
  private readonly frame: [number, number];
  private renderer: Renderer | null = null;
  private started = false;
  private failure = "";
  private pixels = new Map<string, Pixels | string>(); // a text: why there are none
  private hover: [number, number] | null = null;
  private placed: Placed[] = [];
  private scheduled = false;
  private timer = 0;

  constructor(private readonly data: Data, private readonly catalogue: Catalogue, private state: State) {
    this.frame = [data.frame.width, data.frame.height];
    this.bar = controls(data, catalogue, (change) => this.update(change));
    this.element = section("viewer", "Images", this.bar.element, this.stage, this.legendBox, this.readoutBox,
      h("p", { class: "note" }, "Keys on the images: 1 to 9 flip, g, f, s arrangement, arrows and +, \u2212, 0 move and zoom " +
        "(as the mouse does; the wheel zooms once the images are clicked), e and E exposure, d difference, l layer. Grey: no surface; magenta: not a finite number."));
    this.listen();
    new ResizeObserver(() => this.schedule()).observe(this.stage);
    this.update({});
    // The page is painted with the previews first: WebGL takes a while to start.
    requestAnimationFrame(() => setTimeout(() => this.start(), 0));
  }

  private start(): void {
    this.started = true;
    try {
      this.renderer = new Renderer(this.canvas, this.data.colourMaps);
    } catch (error) {
      this.failure = `No HDR view: ${error instanceof Error ? error.message : String(error)}. The previews are shown.`;
    }
    this.mask();
    this.schedule();
  }

  get current(): State { return this.state; }

  update(change: Partial<State>): void {
    const before = this.state.pin;
    this.state = { ...this.state, ...change };
    const set = this.catalogue.find(this.state.show);
    if (!set) return;
    this.state.show = set.key;
    if (set.layers.length > 0 && !set.layers.includes(this.state.layer)) this.state.layer = set.layers[0]!;
    const last = Math.max(set.panels(this.state.layer).length - 1, 0);
    this.state.active = Math.min(this.state.active, last);
    this.state.left = Math.min(this.state.left, last);
    clampCenter(this.state, this.frame);
    this.bar.sync(this.state);
    this.schedule();
    if (change.pin !== undefined && change.pin !== before) this.onPin(this.state.pin);
    this.remember();
  }

  /** Not at once: browsers allow only so many changes of the address in a row. */
  private remember(): void {
    clearTimeout(this.timer);
    this.stage.dataset.address = "to be written";
    this.timer = window.setTimeout(() => {
      const hash = writeHash(this.state);
      if (hash !== location.hash) history.replaceState(null, "", hash);
      this.stage.dataset.address = "written";
    }, 200);
  }

  private panels(): Panel[] { return this.catalogue.find(this.state.show)?.panels(this.state.layer) ?? []; }

  private schedule(): void {
    if (this.scheduled) return;
    this.scheduled = true;
    this.stage.dataset.drawn = "false";
    requestAnimationFrame(() => { this.scheduled = false; this.draw(); });
  }

  private fetch(panel: Panel): void {
    for (const layer of [panel.layer, panel.reference]) {
      if (!layer || this.pixels.has(layer.id)) continue;
      this.pixels.set(layer.id, "loading\u2026");
      load(layer).then((pixels) => this.pixels.set(layer.id, pixels),
        (error: unknown) => this.pixels.set(layer.id, `not shown: ${error instanceof Error ? error.message : String(error)}`))
        .finally(() => this.schedule());
    }
  }

  private mask(): void {
    const layer = this.data.layers.find(({ name }) => name === "mask");
    if (layer) this.fetch({ layer, reference: null, label: "", colour: "", group: -1 });
  }

  private maskPixels(): Pixels | null | "loading" {
    const layer = this.data.layers.find(({ name }) => name === "mask");
    if (!layer) return null;
    const pixels = this.pixels.get(layer.id);
    return typeof pixels === "object" ? pixels : "loading";
  }

  private place(): Placed[] {
    const width = this.stage.clientWidth;
    const height = Math.max(window.innerHeight * 0.8, 320);
    const panels = this.panels(), aspect = this.frame[0] / this.frame[1];
    if (panels.length === 0 || width === 0) return [];
    const { mode, active, left, split } = this.state;
    const { rects, height: used } = layOut(mode === "grid" ? panels.length : 1, width, height, aspect);
    this.stage.style.height = `${Math.ceil(used)}px`;
    const whole: [number, number] = [0, 1];
    if (mode === "grid") return panels.map((panel, i) => ({ panel, rect: rects[i]!, clip: whole }));
    const rect = { ...rects[0]!, x: (width - rects[0]!.width) / 2 };
    if (mode === "flip") return [{ panel: panels[active]!, rect, clip: whole }];
    return [{ panel: panels[left]!, rect, clip: [0, split] }, { panel: panels[active]!, rect, clip: [split, 1] }];
  }

  private drawings(): PanelDrawing[] {
    const drawings: PanelDrawing[] = [];
    if (this.maskPixels() === "loading") return drawings;
    for (const { panel, rect, clip } of this.placed) {
      const pixels = this.pixels.get(panel.layer.id), display = displayOf(panel, this.state);
      const reference = panel.reference ? this.pixels.get(panel.reference.id) : null;
      const needed = display === "signed" || display === "relative" || display === "angle";
      if (typeof pixels !== "object" || !display || (needed && typeof reference !== "object")) continue;
      drawings.push({ ...rect, clip, pixels, reference: typeof reference === "object" ? reference : null, display,
        unit: display === "false" ? this.data.frame.meanLuminance : unitOf(panel, this.data),
        scale: scaleOf(panel, display, this.state) });
    }
    return drawings;
  }

  private draw(): void {
    this.placed = this.place();
    if (this.started) for (const { panel } of this.placed) this.fetch(panel);
    const first = this.placed[0];
    const drawings = this.drawings();
    if (first && this.renderer) {
      const at = transformOf(this.state, first.rect, this.frame);
      const mask = this.maskPixels();
      this.canvas.style.width = `${this.stage.clientWidth}px`;
      this.canvas.style.height = this.stage.style.height;
      this.renderer.draw(this.stage.clientWidth, parseFloat(this.stage.style.height), drawings, {
        exposure: this.data.frame.exposure * 2 ** this.state.stops, curve: this.state.curve, center: at.center,
        scaleCss: at.scale, frame: this.frame, mask: typeof mask === "object" ? mask : null });
    }
    this.overlay.replaceChildren(...this.placed.flatMap((placed, i) => this.decorate(placed, i)));
    this.drawLegend();
    this.drawReadout();
    // For those who drive the page: all that was asked for is on the canvas.
    this.stage.dataset.drawn = String(drawings.length > 0 && drawings.length === this.placed.length);
  }

  private status(panel: Panel): string {
    if (this.failure) return this.failure;
    for (const layer of [panel.layer, panel.reference]) {
      const pixels = layer ? this.pixels.get(layer.id) : undefined;
      if (typeof pixels === "string") return pixels;
    }
    return displayOf(panel, this.state) ? "" : "there is no reference for this";
  }

  /** Label, preview until the pixels are there, closeups and the kept pixel. */
  private decorate({ panel, rect, clip }: Placed, index: number): HTMLElement[] {
    const at = transformOf(this.state, rect, this.frame), status = this.status(panel);
    const left = (x: number) => (x - at.center[0]) * at.scale + rect.width / 2;
    const top = (y: number) => (y - at.center[1]) * at.scale + rect.height / 2;
    const inside: HTMLElement[] = [];
    if (panel.layer.preview && typeof this.pixels.get(panel.layer.id) !== "object" && this.state.as === "image") {
      inside.push(h("img", { src: panel.layer.preview, alt: "", class: "preview", style:
        `left:${left(0)}px;top:${top(0)}px;width:${this.frame[0] * at.scale}px;height:${this.frame[1] * at.scale}px` }));
    }
    if (status) inside.push(h("p", { class: "status", role: "status" }, status));
    if (this.state.boxes) {
      for (const { rectangle: [x, y, width, height], label } of this.data.closeups) {
        inside.push(h("div", { class: "box", title: label, style:
          `left:${left(x)}px;top:${top(y)}px;width:${width * at.scale}px;height:${height * at.scale}px` }));
      }
    }
    const mark = this.hover ?? this.state.pin;
    if (mark) inside.push(h("div", { class: "cross", style: `left:${left(mark[0] + 0.5)}px;top:${top(mark[1] + 0.5)}px` }));
    const number = this.state.mode === "grid" ? index : index === 0 && this.state.mode === "slider" ? this.state.left : this.state.active;
    const labelRect = `left:${rect.x + clip[0] * rect.width}px;top:${rect.y - labelHeight()}px;` +
      `width:${(clip[1] - clip[0]) * rect.width}px;height:${labelHeight() - 3}px;border-color:${panel.colour}`;
    const elements = [
      h("div", { class: "label", style: labelRect }, h("kbd", {}, String(number + 1)), h("span", { style: `background:${panel.colour}` }, panel.label)),
      h("div", { class: "panel", "data-layer": panel.layer.id, "data-x": rect.x, "data-y": rect.y, "data-width": rect.width, "data-height": rect.height,
        style: `left:${rect.x}px;top:${rect.y}px;width:${rect.width}px;height:${rect.height}px;` +
          `clip-path: inset(0 ${(1 - clip[1]) * 100}% 0 ${clip[0] * 100}%)` }, ...inside),
    ];
    if (this.state.mode === "slider" && index === 1) {
      elements.push(h("div", { class: "divider", style:
        `left:${rect.x + clip[0] * rect.width}px;top:${rect.y}px;height:${rect.height}px` }));
    }
    return elements;
  }

  private drawLegend(): void {
    const seen = new Map<string, HTMLElement>();
    for (const { panel } of this.placed) {
      const display = displayOf(panel, this.state);
      if (display && !seen.has(display)) seen.set(display, legend(display, panel, this.state, this.data));
    }
    this.legendBox.replaceChildren(...seen.values());
  }

  private drawReadout(): void {
    const pixel = this.hover ?? this.state.pin;
    const lines: Line[] = this.panels().map((panel) => {
      const pixels = this.pixels.get(panel.layer.id);
      if (typeof pixels !== "object") return { panel, reading: pixels ?? "not looked at yet" };
      if (!pixel) return { panel, reading: "" };
      const reference = panel.reference ? this.pixels.get(panel.reference.id) : null;
      return { panel, reading: readingAt(panel, this.data, pixels, typeof reference === "object" ? reference : null, ...pixel) };
    });
    this.readoutBox.replaceChildren(readout(this.data, lines, pixel, !this.hover && Boolean(this.state.pin)));
  }

  /** The panel and the frame's position under the mouse. */
  private under(event: MouseEvent): { rect: Rect; at: [number, number]; pixel: [number, number] | null } | null {
    const box = this.stage.getBoundingClientRect();
    const x = event.clientX - box.left, y = event.clientY - box.top;
    const hit = this.placed.find(({ rect, clip }) => y >= rect.y && y < rect.y + rect.height &&
      x >= rect.x + clip[0] * rect.width && x < rect.x + clip[1] * rect.width);
    if (!hit) return null;
    const at = toFrame(transformOf(this.state, hit.rect, this.frame), hit.rect, x, y);
    const pixel: [number, number] = [Math.floor(at[0]), Math.floor(at[1])];
    const inside = pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < this.frame[0] && pixel[1] < this.frame[1];
    return { rect: hit.rect, at, pixel: inside ? pixel : null };
  }

  private listen(): void {
    let drag: { x: number; y: number; moved: boolean; divides: boolean; center: [number, number] } | null = null;
    this.stage.addEventListener("pointerdown", (event) => {
      const hit = this.under(event);
      if (!hit || event.button !== 0) return;
      this.stage.focus({ preventScroll: true });
      this.stage.setPointerCapture(event.pointerId);
      const edge = hit.rect.x + this.state.split * hit.rect.width + this.stage.getBoundingClientRect().left;
      drag = { x: event.clientX, y: event.clientY, moved: false,
        divides: this.state.mode === "slider" && Math.abs(event.clientX - edge) < 14,
        center: transformOf(this.state, hit.rect, this.frame).center };
    });
    this.stage.addEventListener("pointermove", (event) => {
      const first = this.placed[0];
      if (!drag || !first) {
        this.hover = this.under(event)?.pixel ?? null;
        this.schedule();
        return;
      }
      const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
      drag.moved ||= Math.hypot(dx, dy) > 3;
      if (drag.divides) {
        const left = first.rect.x + this.stage.getBoundingClientRect().left;
        this.update({ split: Math.min(Math.max((event.clientX - left) / first.rect.width, 0), 1) });
      } else if (drag.moved && this.state.zoom > 1) {
        const { scale } = transformOf(this.state, first.rect, this.frame);
        this.update({ x: drag.center[0] - dx / scale, y: drag.center[1] - dy / scale });
      }
    });
    this.stage.addEventListener("pointerup", (event) => {
      const hit = this.under(event);
      if (drag && !drag.moved && !drag.divides && hit?.pixel) this.update({ pin: hit.pixel });
      drag = null;
    });
    this.stage.addEventListener("pointerleave", () => { this.hover = null; this.schedule(); });
    this.stage.addEventListener("dblclick", () => this.update({ zoom: 1 }));
    this.stage.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && document.activeElement !== this.stage) return; // the page scrolls
      const hit = this.under(event);
      if (!hit) return;
      event.preventDefault();
      this.zoomAt(hit.at, Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.002)));
    }, { passive: false });
    this.stage.addEventListener("keydown", (event) => {
      if (!event.ctrlKey && !event.altKey && !event.metaKey && this.press(event.key, event.shiftKey)) event.preventDefault();
    });
  }

  /** Zooms so that the frame's position `at` stays where it is. */
  private zoomAt(at: [number, number], factor: number): void {
    const zoom = Math.min(Math.max(this.state.zoom * factor, 1), 64);
    const x = Number.isNaN(this.state.x) ? this.frame[0] / 2 : this.state.x;
    const y = Number.isNaN(this.state.y) ? this.frame[1] / 2 : this.state.y;
    const share = this.state.zoom / zoom;
    this.update({ zoom, x: at[0] + (x - at[0]) * share, y: at[1] + (y - at[1]) * share });
  }

  private press(key: string, shift: boolean): boolean {
    const { state } = this;
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key];
    if (arrow && shift) {
      const [x, y] = state.pin ?? [this.frame[0] >> 1, this.frame[1] >> 1];
      const clamp = (value: number, extent: number) => Math.min(Math.max(value, 0), extent - 1);
      this.hover = null;
      this.update({ pin: [clamp(x + arrow[0]!, this.frame[0]), clamp(y + arrow[1]!, this.frame[1])] });
    } else if (arrow && state.mode === "slider" && state.zoom === 1) {
      this.update({ split: Math.min(Math.max(state.split + 0.02 * arrow[0]!, 0), 1) });
    } else if (arrow) {
      if (state.zoom === 1) return false; // the page scrolls
      const step = this.frame[0] / state.zoom / 10;
      this.update({ x: state.x + arrow[0]! * step, y: state.y + arrow[1]! * step });
    } else if (/^[1-9]$/.test(key)) {
      if (Number(key) > this.panels().length) return true;
      this.update({ active: Number(key) - 1, mode: state.mode === "grid" ? "flip" : state.mode });
    } else {
      return this.pressLetter(key);
    }
    return true;
  }

  private pressLetter(key: string): boolean {
    const { state } = this;
    const x = Number.isNaN(state.x) ? this.frame[0] / 2 : state.x, y = Number.isNaN(state.y) ? this.frame[1] / 2 : state.y;
    const views: State["as"][] = ["image", "signed", "relative", "angle"];
    const layers = this.catalogue.find(state.show)?.layers ?? [];
    const actions: Record<string, () => void> = {
      g: () => this.update({ mode: "grid" }), f: () => this.update({ mode: "flip" }), s: () => this.update({ mode: "slider" }),
      "0": () => this.update({ zoom: 1 }), "+": () => this.zoomAt([x, y], 1.5), "=": () => this.zoomAt([x, y], 1.5),
      "-": () => this.zoomAt([x, y], 1 / 1.5),
      e: () => this.update({ stops: Math.min(state.stops + 0.5, 8) }), E: () => this.update({ stops: Math.max(state.stops - 0.5, -8) }),
      d: () => this.update({ as: views[(views.indexOf(state.as) + 1) % views.length]! }),
      l: () => layers.length > 0 && this.update({ layer: layers[(layers.indexOf(state.layer) + 1) % layers.length]! }),
      Escape: () => this.update({ pin: null }),
    };
    if (!actions[key]) return false;
    actions[key]();
    return true;
  }
}
