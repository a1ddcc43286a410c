// Tables that sort by a column, filter by words, and copy as CSV. Without this script they are tables still.

type Direction = "ascending" | "descending";

/** Makes one table answer. */
export function enliven(place: HTMLElement): void {
  const table = place.querySelector("table");
  const body = table?.tBodies[0];
  const heads = table?.tHead?.rows[0]?.cells;
  if (!table || !body || !heads) return;
  const rows = [...body.rows];
  const bar = document.createElement("div");
  bar.className = "filter";
  const filter = Object.assign(document.createElement("input"), { type: "search", placeholder: "Filter rows" });
  filter.setAttribute("aria-label", `Filter rows of: ${table.caption?.textContent ?? "table"}`);
  const count = document.createElement("output");
  const copy = Object.assign(document.createElement("button"), { type: "button", textContent: "Copy as CSV" });
  bar.append(filter, copy, count);
  place.prepend(bar);

  const shown = () => [...body.rows].filter((row) => !row.hidden);
  const tell = () => {
    const visible = shown().length;
    const all = `${rows.length} row${rows.length === 1 ? "" : "s"}`;
    count.value = visible === rows.length ? all : `${visible} of ${all}`;
  };
  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of rows) {
      const text = (row.textContent ?? "").toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
    }
    tell();
  });
  copy.addEventListener("click", () => {
    void copyText(csvOf([...heads].map(textOf), shown().map((row) => [...row.cells].map(valueOf)))).then((done) => {
      copy.textContent = done ? "Copied" : "Could not copy";
      setTimeout(() => (copy.textContent = "Copy as CSV"), 1500);
    });
  });
  [...heads].forEach((head, column) => addSorting(head, column, heads, body, rows));
  tell();
}

function addSorting(head: HTMLTableCellElement, column: number, heads: HTMLCollectionOf<HTMLTableCellElement>, body: HTMLTableSectionElement, rows: HTMLTableRowElement[]): void {
  const button = Object.assign(document.createElement("button"), { type: "button", className: "sort" });
  button.append(...head.childNodes);
  head.append(button);
  button.addEventListener("click", () => {
    const direction: Direction = head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
    for (const other of heads) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", direction);
    body.append(...sorted(rows, column, direction));
  });
}

/** Rows by a column: numbers by size, texts by the alphabet; empty cells come last either way. Equal ones keep the order they were written in. */
export function sorted(rows: readonly HTMLTableRowElement[], column: number, direction: Direction): HTMLTableRowElement[] {
  const sign = direction === "ascending" ? 1 : -1;
  const keyed = rows.map((row) => ({ row, key: row.cells[column] ? valueOf(row.cells[column]!) : "" }));
  return keyed
    .sort((a, b) => {
      if (a.key === "" || b.key === "") return Number(a.key === "") - Number(b.key === "");
      if (typeof a.key === "number" && typeof b.key === "number") return sign * (a.key - b.key);
      if (typeof a.key !== typeof b.key) return typeof a.key === "number" ? -1 : 1;
      return sign * String(a.key).localeCompare(String(b.key), "en", { numeric: true });
    })
    .map(({ row }) => row);
}

function valueOf(cell: HTMLTableCellElement): string | number {
  const value = cell.dataset["value"];
  return value === undefined ? textOf(cell) : Number(value);
}

function textOf(cell: Element): string {
  return (cell.textContent ?? "").trim();
}

/** Cells as CSV (RFC 4180). */
export function csvOf(head: readonly string[], rows: readonly (readonly (string | number)[])[]): string {
  const quoted = (cell: string | number) => (/[",\r\n]/.test(String(cell)) ? `"${String(cell).replaceAll('"', '""')}"` : String(cell));
  return [head, ...rows].map((row) => row.map(quoted).join(",")).join("\r\n") + "\r\n";
}

/** Puts text on the clipboard; a page opened as a file may have to do it the old way. */
export async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = Object.assign(document.createElement("textarea"), { value: text });
    area.style.position = "fixed";
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}
