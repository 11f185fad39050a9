import { cells } from "./cells";
import { Data, readData } from "./data";
import { figures } from "./figures";
import { header } from "./header";
import { Lobes } from "./lobes";
import { Catalogue } from "./panels";
import { State, defaults, readHash, writeHash } from "./state";
import { plots } from "./plots";
import { tables } from "./tables";
import { Viewer } from "./viewer";

/** The scale that the run's own error maps have. */
function ownScale(data: Data): number {
  return data.figures.find(({ kind }) => kind === "error_map")?.scale ?? defaults.scale;
}

/** Resolves when the page has been painted. */
function nextFrame(): Promise<void> {
  return new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 0)));
}

function presentSections(data: Data, viewer: boolean, lobes: boolean): Set<string> {
  const all: [string, boolean][] = [["viewer", viewer], ["lobes", lobes], ["plots", data.plots.rows.length > 0],
    ["tables", data.tables.length > 0], ["figures", data.figures.length > 0], ["cells", true]];
  return new Set(all.filter(([, there]) => there).map(([id]) => id));
}

async function show(data: Data): Promise<void> {
  document.title = `${String(data.run?.title ?? data.run?.experiment ?? "run")} \u2013 occlab report`;
  const base: State = { ...defaults, scale: ownScale(data) };
  const catalogue = new Catalogue(data);
  const start = readHash(location.hash, base);
  const viewer = catalogue.sets.length > 0 ? new Viewer(data, catalogue, start.state) : null;

  const lobes = viewer && Lobes.of(data, catalogue);
  if (viewer && lobes) {
    viewer.onPin = (pin) => void lobes.show(pin);
    if (start.state.pin) void lobes.show(viewer.current.pin);
  }

  const shows = (group: number): string | null => {
    const place = catalogue.placeOf(group);
    return place && writeHash({ ...base, show: place.set.key, mode: "flip", active: place.place });
  };
  const page = document.getElementById("page")!;
  page.append(header(data, presentSections(data, Boolean(viewer), Boolean(lobes))), ...(viewer ? [viewer.element] : []));
  // The first paint does not wait for what is further down.
  await nextFrame();
  const rest = [lobes?.element, plots(data), tables(data), figures(data), cells(data, shows)];
  page.append(...rest.filter((part): part is HTMLElement => Boolean(part)));

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

void show(readData());
