// What is known of one point of a chart: a panel with its figures and the command that repeats it.
import { SHOW_CASE, type AxisData, type ChartData, type RunData } from "./page_data";
import { copyText } from "./tables";

export type Row = Record<string, string | number | boolean | null>;

/** A chart's rows, from its columns. */
export function rowsOf(chart: ChartData): Row[] {
  const keys = Object.keys(chart.columns);
  return Array.from({ length: chart.rows }, (_, place) => Object.fromEntries(keys.map((key) => [key, chart.columns[key]![place] ?? null])));
}

/** A figure in the unit of its axis, to four digits. */
export function figureText(value: unknown, axis: AxisData): string {
  if (value === null || value === undefined || value === "") return "";
  if (typeof value !== "number") return String(value);
  return numberText(value * axis.factor) + (axis.unit ? ` ${axis.unit}` : "");
}

export function numberText(value: number): string {
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return value.toLocaleString("en");
  const size = Math.abs(value);
  return size !== 0 && (size >= 1e5 || size < 1e-4) ? value.toExponential(3) : String(Number(value.toPrecision(4)));
}

/** Title and text of each figure of a row, with its interval where it has one. */
export function factsOf(row: Row, chart: ChartData): [string, string][] {
  const facts: [string, string][] = [];
  for (const key of [chart.facet, chart.series]) if (key && row[key] !== null) facts.push(["", String(row[key])]);
  const seen = new Set<string>();
  for (const axis of [chart.y, chart.x, ...chart.shown]) {
    if (seen.has(axis.key)) continue;
    seen.add(axis.key);
    const value = figureText(row[axis.key], axis);
    if (!value || facts.some(([, text]) => text === value && typeof row[axis.key] === "string")) continue;
    const [low, high] = [row[`${axis.key}_low`], row[`${axis.key}_high`]];
    const interval = typeof low === "number" && typeof high === "number" ? ` [${numberText(low * axis.factor)}, ${numberText(high * axis.factor)}]` : "";
    const to = typeof row[`${axis.key}_to`] === "number" ? ` to ${figureText(row[`${axis.key}_to`], axis)}` : "";
    facts.push([axis.title, value + to + interval]);
  }
  if (row["note"]) facts.push(["note", String(row["note"])]);
  return facts;
}

/** As lines of text, for the tip beside the pointer. */
export function tipText(row: Row, chart: ChartData): string {
  return factsOf(row, chart)
    .map(([title, text]) => (title ? `${title}: ${text}` : text))
    .join("\n");
}

/** Opens the panel of a row. */
export function openDetails(row: Row, chart: ChartData, run: RunData): void {
  const dialog = document.createElement("dialog");
  dialog.className = "details";
  dialog.setAttribute("aria-label", "The record of a point");
  const list = document.createElement("dl");
  list.className = "facts";
  for (const [title, text] of factsOf(row, chart)) {
    list.append(Object.assign(document.createElement("dt"), { textContent: title }), Object.assign(document.createElement("dd"), { textContent: text }));
  }
  dialog.append(Object.assign(document.createElement("h3"), { textContent: chart.title }), list);
  if (row["case"]) {
    const line = `${run.command} --case ${quoted(String(row["case"]))}`;
    const copy = Object.assign(document.createElement("button"), { type: "button", textContent: "Copy" });
    copy.addEventListener("click", () => void copyText(line).then((done) => (copy.textContent = done ? "Copied" : "Could not copy")));
    const text = document.createElement("pre");
    text.append(Object.assign(document.createElement("code"), { textContent: line }));
    dialog.append(Object.assign(document.createElement("p"), { textContent: "The command that repeats it:" }), text, copy);
  }
  if (run.shown_cases.includes(String(row["case"] ?? ""))) {
    const show = Object.assign(document.createElement("button"), { type: "button", textContent: "Show in 3D" });
    show.addEventListener("click", () => {
      dialog.close();
      document.dispatchEvent(new CustomEvent<string>(SHOW_CASE, { detail: String(row["case"]) }));
    });
    dialog.append(" ", show);
  }
  const close = Object.assign(document.createElement("button"), { type: "button", textContent: "Close", autofocus: true });
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => dialog.remove());
  dialog.append(close);
  document.body.append(dialog);
  dialog.showModal();
}

/** A word for a shell. */
function quoted(word: string): string {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
}
