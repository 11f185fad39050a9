// One picture at two commits, flipped in place.
import { button, h, section } from "../dom";
import { Update } from "./detail";
import { History, Picture, Series, Step, dateOf, shortCommit } from "./data";
import { State } from "./state";

const safeFile = /^images\/[A-Za-z0-9_.-]+$/;

/** What a picture is of, without its commit. */
export function subjectOf(picture: Omit<Picture, "run" | "file">): string {
  const parameters = Object.entries(picture.parameters).map(([name, value]) => `${name} ${value}`).join(", ");
  return [picture.scene, picture.view, picture.method, parameters, picture.stage].filter(Boolean).join(" \u00b7 ");
}

/** Is a picture of what a series was measured on? */
function fits(picture: Picture, series: Series): boolean {
  return picture.scene === series.scene && picture.view === series.view.replace(/ \[.*\]$/, "") && picture.method === series.method &&
    (!series.stage || picture.stage === series.stage) &&
    Object.entries(picture.parameters).every(([name, value]) => (series.parameters[name] ?? value) === value);
}

export class Flip {
  readonly element: HTMLElement;
  private readonly subjects = new Map<string, Picture[]>(); // by what they are of, in the order of the runs
  private readonly subject = h("select", { "data-flip": "image", change: () => this.update({ image: this.subject.value }) });
  private readonly selects = { a: this.runs("a"), b: this.runs("b") };
  private readonly buttons: HTMLButtonElement[];
  private readonly stage: HTMLElement;
  private readonly images = { a: h("img", { alt: "" }), b: h("img", { alt: "" }) };
  private readonly label = h("p", { class: "flip-label", role: "status" });
  private options = "";
  private state: State | null = null;

  constructor(private readonly history: History, private readonly update: Update) {
    for (const picture of [...history.images].sort((x, y) => x.run - y.run)) {
      if (!history.runs[picture.run]) continue;
      const key = subjectOf(picture);
      this.subjects.set(key, [...(this.subjects.get(key) ?? []), picture]);
    }
    this.subject.append(...[...this.subjects.keys()].map((key) => h("option", { value: key }, key)));
    const sides: [State["side"], string, string][] = [["a", "first", "1"], ["b", "second", "2"], ["difference", "difference \u00d7 8", "3"]];
    this.buttons = sides.map(([side, text, key]) => button(text, () => this.update({ side }), { "data-side": side, title: `key ${key}` }));
    this.stage = h("div", { class: "flip-stage", tabindex: 0, role: "group", "aria-label": "Picture; key f flips between the two commits", keydown: (event: KeyboardEvent) => this.key(event), click: () => this.other() }, this.images.a, this.images.b);
    this.element = section("images", "Images", h("p", {}, "The same picture at two commits. ", h("kbd", {}, "f"), " or a click flips, ", h("kbd", {}, "1"), " ", h("kbd", {}, "2"), " ", h("kbd", {}, "3"),
      " show one or their difference, ", h("kbd", {}, ","), " ", h("kbd", {}, "."), " move the second along the commits."),
      h("div", { class: "controls" }, h("label", { class: "control" }, h("span", {}, "picture"), this.subject),
        h("label", { class: "control" }, h("span", {}, "first"), this.selects.a), h("label", { class: "control" }, h("span", {}, "second"), this.selects.b),
        h("div", { class: "buttons", role: "group", "aria-label": "What is shown" }, ...this.buttons)), this.label, this.stage);
  }

  get there(): boolean { return this.subjects.size > 0; }

  /** The change of state that shows a step's images; null where there are none. */
  ofStep(step: Step): Partial<State> | null {
    const series = this.history.series[step.series]!;
    for (const [key, pictures] of this.subjects) {
      const before = pictures.findLast(({ run }) => run <= step.before_run), after = pictures.find(({ run }) => run >= step.run);
      if (before && after && fits(before, series)) return { image: key, a: this.history.runs[before.run]!.id, b: this.history.runs[after.run]!.id, side: "b" };
    }
    return null;
  }

  sync(state: State): void {
    this.state = state;
    const { key, pictures, a, b } = this.current();
    if (!pictures) return;
    this.subject.value = key;
    if (this.options !== key) {
      this.options = key;
      for (const select of Object.values(this.selects)) {
        select.replaceChildren(...pictures.map(({ run }) => h("option", { value: this.history.runs[run]!.id }, this.runText(run))));
      }
    }
    for (const [side, picture] of [["a", a], ["b", b]] as const) {
      this.selects[side].value = String(this.history.runs[picture!.run]!.id);
      const image = this.images[side], file = safeFile.test(picture!.file) ? picture!.file : "";
      if (image.getAttribute("src") !== file) image.setAttribute("src", file);
      image.alt = `${key} at ${this.runText(picture!.run)}`;
    }
    this.stage.dataset.side = state.side;
    for (const one of this.buttons) one.setAttribute("aria-pressed", String(one.dataset.side === state.side));
    const same = a!.file === b!.file ? " Both are the same file: no pixel differs." : "";
    this.label.textContent = (state.side === "difference" ? `|${this.runText(b!.run)} \u2212 ${this.runText(a!.run)}|, 8 times as bright, of the pictures as they are shown.`
      : this.runText((state.side === "a" ? a : b)!.run)) + same;
  }

  private runText(run: number): string {
    const facts = this.history.runs[run]!;
    return `${shortCommit(facts.commit)} ${dateOf(facts)} ${facts.subject.slice(0, 60)}`;
  }

  private runs(side: "a" | "b"): HTMLSelectElement {
    const select: HTMLSelectElement = h("select", { "data-flip": side, change: () => this.update({ [side]: Number(select.value) }) });
    return select;
  }

  private current() {
    const wanted = this.state?.image ?? "", key = this.subjects.has(wanted) ? wanted : [...this.subjects.keys()][0] ?? "";
    const pictures = this.subjects.get(key);
    const of = (id: number) => pictures?.find(({ run }) => this.history.runs[run]!.id === id);
    const b = of(this.state?.b ?? NaN) ?? pictures?.at(-1);
    return { key, pictures, a: of(this.state?.a ?? NaN) ?? pictures?.at(-2) ?? b, b };
  }

  private other(): void { this.update({ side: this.state?.side === "a" ? "b" : "a" }); }

  private move(by: number): void {
    const { pictures, b } = this.current();
    const to = pictures && b ? pictures[pictures.indexOf(b) + by] : undefined;
    if (to) this.update({ b: this.history.runs[to.run]!.id });
  }

  private key(event: KeyboardEvent): void {
    const act: Record<string, () => void> = {
      f: () => this.other(), " ": () => this.other(), "1": () => this.update({ side: "a" }), "2": () => this.update({ side: "b" }),
      "3": () => this.update({ side: "difference" }), ",": () => this.move(-1), ".": () => this.move(1),
    };
    if (event.ctrlKey || event.metaKey || event.altKey || !act[event.key]) return;
    event.preventDefault();
    act[event.key]!();
  }
}
