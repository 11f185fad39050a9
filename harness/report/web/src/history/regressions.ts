// The steps that were found, regressions first: which commits caused them, and how to call one intended.
import { button, h, section } from "../dom";
import { short } from "../numbers";
import { Catalogue, isOpen, scaleOf } from "./catalogue";
import { History, Step, commitRange } from "./data";
import { signs } from "./palette";
import { State } from "./state";

export interface StepActions { plot: (step: Step) => void; images: (step: Step) => void; hasImages: (step: Step) => boolean }

const groupsAtOnce = 20, rowsAtOnce = 6;

/** For a POSIX shell: as it is where that is safe, else in single quotes. */
export function shellQuote(text: string): string {
  return /^[A-Za-z0-9_./:=@%+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

export function acceptCommand(history: History, step: Step, why: string): string {
  const key = history.series[step.series]!.key, commit = history.runs[step.run]!.commit;
  const reason = why ? shellQuote(why) : '"..."';
  return `${history.accept_command ?? "occlab history accept"} --series ${shellQuote(key)} --commit ${shellQuote(commit)} --why ${reason}`;
}

/** The commands for some steps, with a reason that can be typed and a button that copies them. */
function marking(history: History, steps: Step[], label: string): HTMLElement {
  const details = h("details", { class: "marking" }, h("summary", {}, label));
  details.addEventListener("toggle", () => {
    if (details.children.length > 1) return;
    const command = h("code", {}), said = h("span", { role: "status" });
    const why = h("input", { type: "text", placeholder: "why it is intended", "aria-label": "Why this change is intended", input: () => write() });
    const write = () => { command.textContent = steps.map((step) => acceptCommand(history, step, why.value.trim())).join("\n"); };
    const copy = () => void navigator.clipboard.writeText(command.textContent ?? "").then(
      () => { said.textContent = "copied"; }, () => { said.textContent = "cannot copy here: select it"; });
    write();
    details.append(h("p", {}, "Run where the history is; the next report shows it as intended. ", why, " ", button("copy", copy), " ", said), h("pre", {}, command));
  });
  return details;
}

function effect(catalogue: Catalogue, step: Step, state: State): string {
  const { divisor, unit } = scaleOf(catalogue.history.series[step.series]!, state.floors);
  const interval = step.lower === null || step.upper === null ? "" : ` [${short(step.lower)}, ${short(step.upper)}]`;
  const ratio = step.before !== 0 ? `, \u00d7 ${short(step.after / step.before)}${interval}` : "";
  return `${short(step.before / divisor)} \u2192 ${short(step.after / divisor)}${unit ? ` ${unit}` : ""}${ratio}`;
}

function row(catalogue: Catalogue, step: Step, state: State, actions: StepActions): HTMLElement {
  const { intended } = step;
  return h("li", { class: `step ${step.verdict}${intended ? " intended" : ""}` },
    h("span", { class: "verdict" }, `${signs[step.verdict]} ${step.verdict}`), " ",
    h("strong", {}, catalogue.title(step.series)), " ", h("small", {}, catalogue.place(step.series)), " ",
    h("span", { class: "effect" }, effect(catalogue, step, state)), " ",
    step.p !== null && h("small", {}, step.p < 1e-4 ? "p < 0.0001" : `p = ${short(step.p, 2)}`), " ",
    button("plot", () => actions.plot(step)), " ",
    actions.hasImages(step) && button("images", () => actions.images(step)), " ",
    intended ? h("em", {}, `intended, says ${intended.who} on ${intended.when.slice(0, 10)}: ${intended.why}`)
      : step.verdict !== "BETTER" && marking(catalogue.history, [step], "mark this change as intended"));
}

/** Steps of the same commits, newest first, those with open regressions before the others. */
function groupsOf(steps: Step[]): Step[][] {
  const groups = new Map<string, Step[]>();
  for (const step of steps) {
    const key = `${step.before_run} ${step.run}`;
    groups.set(key, [...(groups.get(key) ?? []), step]);
  }
  const open = (group: Step[]) => Number(group.some(isOpen));
  for (const group of groups.values()) group.sort((a, b) => Number(isOpen(b)) - Number(isOpen(a)));
  return [...groups.values()].sort((a, b) => open(b) - open(a) || b[0]!.run - a[0]!.run);
}

function group(catalogue: Catalogue, steps: Step[], state: State, actions: StepActions): HTMLElement {
  const { history } = catalogue, first = steps[0]!, run = history.runs[first.run]!, open = steps.filter(isOpen);
  const between = first.run - first.before_run - 1;
  const list = h("ul", {}, ...steps.slice(0, rowsAtOnce).map((step) => row(catalogue, step, state, actions)));
  const more = steps.length > rowsAtOnce && button(`all ${steps.length} series`, () => {
    list.append(...steps.slice(rowsAtOnce).map((step) => row(catalogue, step, state, actions)));
    if (more) more.remove();
  });
  return h("article", { class: "commits", "data-run": run.id },
    h("h3", {}, h("code", {}, commitRange(history, first)), " ", run.subject || "(no subject)"),
    h("p", { class: "note" }, `${(run.commit_time || run.added).slice(0, 16).replace("T", " ")}, run ${first.run + 1} of ${history.runs.length}` +
      (between > 0 ? `; ${between} runs between the two did not measure this` : "")),
    list, more, open.length > 1 && marking(history, open, `mark all ${open.length} as intended`));
}

/** `heading` over the steps that `wanted` takes among those of the shown series. */
export class Steps {
  readonly element: HTMLElement;
  private readonly place = h("div", {});
  private readonly count = h("p", { class: "note", role: "status" });
  private shownAs = "";

  constructor(private readonly catalogue: Catalogue, id: string, heading: string, private readonly wanted: (step: Step) => boolean,
    private readonly actions: StepActions, private readonly nothing: string) {
    this.element = section(id, heading, this.count, this.place);
  }

  sync(state: State, shown: number[]): void {
    const steps = shown.flatMap((index) => this.catalogue.steps[index]!).filter(this.wanted);
    const key = JSON.stringify([state.floors, steps.map((step) => [step.series, step.run])]);
    if (key === this.shownAs) return;
    this.shownAs = key;
    const groups = groupsOf(steps), open = steps.filter(isOpen).length;
    this.count.textContent = steps.length === 0 ? this.nothing
      : `${steps.length} in ${groups.length} ${groups.length === 1 ? "place" : "places"} of the history` + (open > 0 ? `, ${open} not called intended` : "");
    this.place.replaceChildren();
    this.more(groups, state);
  }

  private more(groups: Step[][], state: State): void {
    this.place.append(...groups.slice(0, groupsAtOnce).map((steps) => group(this.catalogue, steps, state, this.actions)));
    const rest = groups.slice(groupsAtOnce);
    if (rest.length === 0) return;
    const next = button(`${Math.min(rest.length, groupsAtOnce)} more of ${rest.length} older`, () => { next.remove(); this.more(rest, state); });
    this.place.append(next);
  }
}
