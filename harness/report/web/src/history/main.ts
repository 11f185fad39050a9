import { h, section } from "../dom";
import { Catalogue, isOpen } from "./catalogue";
import { History, Step, readHistory, readValues } from "./data";
import { Detail } from "./detail";
import { filters } from "./filters";
import { Flip } from "./flip";
import { SeriesList } from "./list";
import { Steps } from "./regressions";
import { State, readHash, writeHash } from "./state";

interface Part { sync: (state: State, shown: number[], selected: number) => void }

function header(history: History): HTMLElement {
  const devices = [...new Set(history.runs.map(({ device }) => device))].filter(Boolean);
  const facts: [string, string][] = [
    ["Runs", `${history.runs.length}, of ${new Set(history.runs.map(({ commit }) => commit)).size} commits`],
    ["Series", String(history.series.length)], ["Device", devices.join("; ")],
    ["Steps", `of at least the minimum effect (${100 * history.minimum_effect}% of an error), found at a level of ${history.level}`],
    ["Written", history.written.slice(0, 16).replace("T", " ")],
  ];
  return h("header", {}, h("h1", {}, `${history.project || "Project"}: history`),
    h("dl", { class: "facts" }, ...facts.filter(([, value]) => value).flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])));
}

/** Resolves when the page has been painted: what is done in the first frame is shown with the second. */
function nextFrame(): Promise<void> {
  return new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(resolve, 0))));
}

class Page {
  private state = readHash(location.hash);
  private readonly catalogue: Catalogue;
  private readonly parts: Part[] = [];
  private readonly flip: Flip;
  private written = location.hash;
  private timer = 0;

  constructor(private readonly history: History, private readonly root: HTMLElement) {
    this.catalogue = new Catalogue(history);
    document.title = `${history.project || "project"} \u2013 occlab history`;
    const controls = filters(this.catalogue, () => this.state, this.update);
    this.flip = new Flip(history, this.update);
    const actions = {
      plot: (step: Step) => this.goTo(step), hasImages: (step: Step) => this.flip.ofStep(step) !== null,
      images: (step: Step) => { this.update(this.flip.ofStep(step) ?? {}); this.flip.element.scrollIntoView({ behavior: "smooth" }); },
    };
    const worse = new Steps(this.catalogue, "regressions", "Regressions", ({ verdict }) => verdict === "WORSE", actions, "No step for the worse.");
    this.parts.push(controls, worse);
    this.root.append(header(history), controls.element, worse.element);
    this.sync();
    const others = new Steps(this.catalogue, "steps", "Other steps", ({ verdict }) => verdict !== "WORSE", actions, "No other step.");
    void nextFrame().then(() => this.rest(others)).catch((error: unknown) => this.fail(error));
    window.addEventListener("hashchange", () => {
      if (location.hash === this.written) return;
      clearTimeout(this.timer);  // a change that was to be written is over
      this.written = location.hash;
      this.state = readHash(location.hash);
      this.sync();
    });
  }

  /** What needs the values, which are large, comes after the first paint. */
  private async rest(others: Steps): Promise<void> {
    const values = await readValues(this.history);
    const choose = (index: number) => this.update({ series: this.history.series[index]!.key });
    const list = new SeriesList(this.catalogue, values, choose);
    const detail = new Detail(this.catalogue, values, this.update, (step) => this.update(this.flip.ofStep(step) ?? {}));
    this.root.append(section("series", "Series", h("div", { class: "overview" }, list.element, detail.element)));
    this.parts.push({ sync: (state, shown, selected) => { list.sync(state, shown, selected); detail.sync(state, selected); } });
    if (this.flip.there) {
      this.root.append(this.flip.element);
      this.parts.push(this.flip);
    }
    this.root.append(others.element);
    this.parts.push(others);
    this.sync();
    this.root.dataset.ready = "true";
  }

  fail(error: unknown): void {
    this.root.append(h("div", { class: "notice problem", role: "alert" }, h("strong", {}, "The curves cannot be shown: "), error instanceof Error ? error.message : String(error)));
    this.root.dataset.ready = "failed";
  }

  private readonly update = (change: Partial<State>): void => {
    this.state = { ...this.state, ...change };
    this.sync();
    // Browsers limit how often the address may change.
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => {
      this.written = writeHash(this.state);
      window.history.replaceState(null, "", this.written);
    }, 150);
  };

  private goTo(step: Step): void {
    const { runs, series } = this.history, reach = 60;
    const from = Math.max(0, step.before_run - reach), to = Math.min(runs.length - 1, step.run + reach);
    this.update({ series: series[step.series]!.key, from: runs[from]!.id, to: runs[to]!.id, at: runs[step.run]!.id });
    document.getElementById("series")?.scrollIntoView({ behavior: "smooth" });
  }

  private sync(): void {
    const shown = this.catalogue.filter(this.state);
    const wanted = shown.find((index) => this.history.series[index]!.key === this.state.series);
    const selected = wanted ?? shown[0] ?? -1;
    for (const part of this.parts) part.sync(this.state, shown, selected);
    const open = shown.flatMap((index) => this.catalogue.steps[index]!).filter(isOpen).length;
    document.documentElement.dataset.open = String(open);
  }
}

const root = document.getElementById("page")!;
try {
  new Page(readHistory(), root);
} catch (error) {
  root.append(h("div", { class: "notice problem", role: "alert" }, h("strong", {}, "This page cannot be shown: "), error instanceof Error ? error.message : String(error)));
}
