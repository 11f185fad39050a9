import { Data, Figure } from "./data";
import { h, section } from "./dom";

const kinds: Record<string, string> = {
  comparison: "The methods' images beside the reference, at one exposure.",
  closeups: "Parts of the images, enlarged, at one exposure.",
  error_map: "Images minus the reference, in mean luminances of the reference, on one fixed scale: blue is too dark, red too bright.",
  error_budget: "What each method's error is made of. The maps of a row add up to the method's image minus the reference.",
  failure_classes: "Where the depth buffer's visibility and traced rays disagree, by reason, in ambient occlusion.",
};

function figure(one: Figure): HTMLElement {
  const caption = h("figcaption", {}, h("strong", {}, one.title || one.name), " ", kinds[one.kind] ?? "",
    one.kind === "error_budget" || one.kind === "failure_classes" ? "" : ` Stage: ${one.stage}.`);
  if (!one.file) {
    return h("figure", { id: `figure-${one.name}`, class: "absent" },
      h("p", {}, `Not there: ${one.missing ?? ""}`), caption);
  }
  return h("figure", { id: `figure-${one.name}` },
    h("a", { href: `../figures/${encodeURIComponent(one.name)}.png`, title: "in full resolution" },
      h("img", {
        src: one.file, width: one.width, height: one.height, loading: "lazy", decoding: "async",
        alt: `${one.title || one.name}. ${kinds[one.kind] ?? ""}`,
      })), caption);
}

export function figures(data: Data): HTMLElement | null {
  if (data.figures.length === 0) return null;
  return section("figures", "Figures", ...data.figures.map(figure));
}
