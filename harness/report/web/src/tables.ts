import { Data, Table, TableCell } from "./data";
import { h, section } from "./dom";
import { toNumber, withInterval, short } from "./numbers";

const openBelow = 30; // rows; longer tables are folded

function cell(content: TableCell, footnotes: string[]): HTMLTableCellElement {
  if (typeof content === "string") return h("td", {}, content);
  if ("missing" in content) {
    if (!footnotes.includes(content.missing)) footnotes.push(content.missing);
    const mark = String(footnotes.indexOf(content.missing) + 1);
    return h("td", { class: "number missing", title: content.missing }, "\u2013 ", h("sup", {}, mark));
  }
  const value = toNumber(content.value);
  const strong = (text: string) => (content.winner ? h("strong", { class: "winner" }, text) : text);
  if (content.lower === undefined) return h("td", { class: "number" }, strong(short(value)));
  const [middle, lower, upper] = withInterval(value, toNumber(content.lower), toNumber(content.upper));
  return h("td", { class: "number", title: `${content.value} [${content.lower}, ${content.upper}]` },
    strong(middle), h("span", { class: "interval" }, ` [${lower}, ${upper}]`));
}

function matches(row: TableCell[], words: string[]): boolean {
  const text = row.filter((content) => typeof content === "string").join(" ").toLowerCase();
  return words.every((word) => text.includes(word));
}

function filter(table: Table, rows: HTMLTableRowElement[]): HTMLElement {
  const input = h("input", {
    type: "search", placeholder: "rows with\u2026", "aria-label": `Filter the rows of ${table.title}`,
    input: () => {
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      rows.forEach((row, i) => { row.hidden = !matches(table.rows[i]!, words); });
    },
  });
  return input;
}

function fill(table: Table, long: boolean): Node[] {
  const footnotes: string[] = [];
  const numeric = table.columns.map((_, c) => table.rows.some((row) => typeof row[c] !== "string"));
  const head = table.columns.map((column, c) =>
    h("th", { scope: "col", class: numeric[c] ? "number" : undefined },
      column.name, column.unit && h("span", { class: "unit" }, ` ${column.unit}`)));
  const rows = table.rows.map((row) => h("tr", {}, ...row.map((content) => cell(content, footnotes))));
  const notes = h("ul", { class: "notes" },
    ...footnotes.map((note, i) => h("li", {}, h("sup", {}, String(i + 1)), ` ${note}`)),
    ...table.notes.map((note) => h("li", {}, note)));
  const files = h("p", { class: "files" }, "As ", ...["csv", "json", "md", "tex"].flatMap((end, i) =>
    [i > 0 ? ", " : "", h("a", { href: `../tables/${encodeURIComponent(table.name)}.${end}` }, end)]));
  const scroll = h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": table.title },
    h("table", {}, h("thead", {}, h("tr", {}, ...head)), h("tbody", {}, ...rows)));
  return [...(long ? [filter(table, rows)] : []), scroll, notes, files];
}

function makeTable(table: Table): HTMLElement {
  const long = table.rows.length > openBelow;
  const details = h("details", { open: !long, class: "table", id: `table-${table.name}` },
    h("summary", {}, h("h3", {}, table.title), h("span", { class: "count" }, ` ${table.rows.length} rows`)));
  let filled = false;
  // Long tables are made when they are opened; on paper all are open.
  const open = () => {
    if (!filled) details.append(...fill(table, long));
    filled = true;
  };
  if (!long) open();
  details.addEventListener("toggle", () => details.open && open());
  window.addEventListener("beforeprint", () => { open(); details.open = true; });
  return details;
}

export function tables(data: Data): HTMLElement | null {
  if (data.tables.length === 0) return null;
  return section("tables", "Tables",
    h("p", {}, "Brackets hold intervals: 95%, of times the quartiles, where the notes under a table do " +
      "not say otherwise. Bold is better than every other method, where the comparisons resolve it."),
    ...data.tables.map(makeTable));
}
