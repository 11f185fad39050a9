// Colours of verdicts, told apart by their signs too: orange and blue are so to colour-blind readers.
import { Step, Verdict } from "./data";

export const signs: Record<Verdict, string> = { WORSE: "\u2715", BETTER: "\u2713", CHANGED: "\u25c6" };

export interface Palette { ink: string; quiet: string; line: string; paper: string; curve: string; WORSE: string; BETTER: string; CHANGED: string }

const bright: Palette = {
  ink: "#1b1b1b", quiet: "#5a5a5a", line: "#d4d4d4", paper: "#ffffff", curve: "#24476b",
  WORSE: "#b8400a", BETTER: "#0b57b0", CHANGED: "#6a6a6a",
};
const dark: Palette = {
  ink: "#e4e4e4", quiet: "#a0a3a8", line: "#3a3d43", paper: "#141518", curve: "#b9cfe8",
  WORSE: "#ff9e64", BETTER: "#8ab8ff", CHANGED: "#b0b0b0",
};

export function palette(onPaper = false): Palette {
  return !onPaper && matchMedia("(prefers-color-scheme: dark)").matches ? dark : bright;
}

export function colourOf(step: Step, colours: Palette): string {
  return step.intended ? colours.quiet : colours[step.verdict];
}
