import { cells } from "./cells";
import { Data, readData } from "./data";
import { figures } from "./figures";
import { header } from "./header";
import { Catalogue } from "./panels";
import { State, defaults, readHash, writeHash } from "./state";
import { tables } from "./tables";
import { Viewer } from "./viewer";

/** The scale that the run's own error maps have. */
function ownScale(data: Data): number {
  return data.figures.find(({ kind }) => kind === "error_map")?.scale ?? defaults.scale;
}

function show(data: Data): void {
  document.title = `${String(data.run?.title ?? data.run?.experiment ?? "run")} \u2013 occlab report`;
  const base: State = { ...defaults, scale: ownScale(data) };
  const catalogue = new Catalogue(data);
  const start = readHash(location.hash, base);
  const viewer = catalogue.sets.length > 0 ? new Viewer(data, catalogue, start.state) : null;

  const shows = (group: number): string | null => {
    const place = catalogue.placeOf(group);
    return place && writeHash({ ...base, show: place.set.key, mode: "flip", active: place.place });
  };
  const parts = [viewer?.element, tables(data), figures(data), cells(data, shows)];
  const present = parts.filter((part): part is HTMLElement => Boolean(part));
  const page = document.getElementById("page")!;
  page.append(header(data, new Set(present.map(({ id }) => id))), ...present);

  const goToCell = (id: string) => {
    const target = document.getElementById(`cell-${id}`)?.closest<HTMLElement>("tr") ?? document.getElementById(id);
    target?.scrollIntoView({ block: "center" });
    target?.focus({ preventScroll: true });
    document.querySelectorAll(".found").forEach((found) => found.classList.remove("found"));
    target?.classList.add("found");
  };
  window.addEventListener("hashchange", () => {
    const { state, cell, viewed } = readHash(location.hash, viewer?.current ?? base);
    if (viewed) {
      viewer?.update(readHash(location.hash, base).state);
      viewer?.element.scrollIntoView();
    } else {
      viewer?.update(state);
    }
    if (cell) goToCell(cell);
  });
  if (start.cell) goToCell(start.cell);
}

show(readData());
