// Charts from the page's data, by Observable Plot: one small plot for each panel, all on the same axes.
import * as Plot from "@observablehq/plot";
import { logTicks, NAME_PIXELS, tickText, wrapped, type Range } from "./axes";
import { addKeys, pointsOf } from "./chart_keys";
import { openDetails, rowsOf, tipText, type Row } from "./details";
import { readBlock, showFault, type AxisData, type ChartData, type MarkData, type RunData } from "./page_data";
import { placeNames, styleSeries, type SeriesStyle } from "./series_style";
import { isDark, onTheme, pageColour } from "./theme";

interface Panel {
  name: string;
  rows: Row[];
}

const LEAST_PANEL = 300; // pixels
const LEAST_PLOT = 170; // pixels of a panel beside the names of its rows
const NAME_GAP = 14;
const LINE_PIXELS = 14; // of a name in several lines
const MARK_PIXELS = 12; // between the names of marks, one above the other

/** Draws the chart whose data the place names, once a reader comes near it or prints, and again whenever its width or the colours change. */
export function enlivenChart(place: HTMLElement, run: RunData): void {
  let started = false;
  const start = () => {
    if (started) return;
    started = true;
    observer.disconnect();
    startChart(place, run);
  };
  const observer = new IntersectionObserver((entries) => entries.some((entry) => entry.isIntersecting) && start(), { rootMargin: "900px" });
  observer.observe(place);
  addEventListener("beforeprint", start);
}

function startChart(place: HTMLElement, run: RunData): void {
  const figure = place.closest("figure");
  try {
    const chart = readBlock<ChartData>(place.dataset["chart"]!);
    const rows = rowsOf(chart);
    if (figure && panelsOf(chart, rows).length > 1) figure.classList.add("wide");
    let width = 0;
    const draw = () => {
      width = place.clientWidth;
      if (width > 0) place.replaceChildren(...drawChart(chart, rows, width, run));
    };
    draw();
    place.classList.add("is-drawn");
    new ResizeObserver(() => {
      if (Math.abs(place.clientWidth - width) > 8) draw();
    }).observe(place);
    onTheme(draw);
    if (figure) figure.append(saveButtons(place, chart.title));
  } catch (error) {
    showFault(place, "This chart could not be drawn", error);
  }
}

function panelsOf(chart: ChartData, rows: Row[]): Panel[] {
  if (!chart.facet) return [{ name: "", rows }];
  const panels = new Map<string, Row[]>();
  for (const row of rows) {
    const name = String(row[chart.facet] ?? "");
    if (!panels.has(name)) panels.set(name, []);
    panels.get(name)!.push(row);
  }
  return [...panels].map(([name, own]) => ({ name, rows: own }));
}

function seriesOf(chart: ChartData): string[] {
  return chart.series ? [...new Set(Array.from({ length: chart.rows }, (_, k) => String(chart.columns[chart.series]?.[k] ?? "")))] : [""];
}

let places: Map<string, number> | undefined;

/** The places of all series of the page's charts; a block that is broken is told of where it is drawn. */
function placesOfPage(): Map<string, number> {
  const namesOf = (place: HTMLElement): string[] => {
    try {
      return seriesOf(readBlock<ChartData>(place.dataset["chart"]!));
    } catch {
      return [];
    }
  };
  return (places ??= placeNames([...document.querySelectorAll<HTMLElement>("[data-chart]")].map(namesOf)));
}

/** Pixels of the longest name of a row; 0 where rows have none. */
function namePixels(chart: ChartData, rows: Row[]): number {
  return chart.kind === "ranges" ? NAME_GAP + NAME_PIXELS * Math.max(...rows.map((row) => String(row[chart.y.key]).length)) : 0;
}

function drawChart(chart: ChartData, rows: Row[], width: number, run: RunData): Element[] {
  const names = seriesOf(chart);
  const style = styleSeries(names, isDark(), placesOfPage());
  const panels = panelsOf(chart, rows);
  const columns = Math.max(1, Math.min(panels.length, Math.floor(width / Math.max(LEAST_PANEL, namePixels(chart, rows) + LEAST_PLOT))));
  const own = Math.floor((width - 16 * (columns - 1)) / columns);
  const domains = { x: rangeOf(chart, rows, chart.x), y: rangeOf(chart, rows, chart.y) };
  const grid = document.createElement("div");
  grid.className = "panels";
  grid.style.gridTemplateColumns = `repeat(${columns}, 1fr)`;
  for (const panel of panels) grid.append(drawPanel(chart, panel, own, domains, style, run));
  const isNamed = chart.kind === "bars" || (chart.kind === "ranges" && (chart.series === chart.facet || rows.every((row) => String(row[chart.y.key]).startsWith(String(row[chart.series])))));
  const needsLegend = names.length > 1 && !isNamed;
  return needsLegend ? [legendOf(style), grid] : [grid];
}

function drawPanel(chart: ChartData, panel: Panel, width: number, domains: { x?: Range; y?: Range }, style: SeriesStyle, run: RunData): Element {
  const box = document.createElement("div");
  if (panel.name) box.append(Object.assign(document.createElement("div"), { className: "panel-title", textContent: panel.name }));
  const marks = chart.marks.filter((mark) => mark.facet === undefined || mark.facet === panel.name);
  const options = optionsOf(chart, panel, width, domains, marks);
  const plot = Plot.plot({
    ...options,
    symbol: { domain: style.names, range: style.marks },
    style: { background: "transparent", color: pageColour("--ink"), fontSize: "12px", overflow: "visible" },
    marks: [...logAxes(chart, domains, options), ...ground(chart, marks), ...marksOf(chart, panel.rows, style), tip(chart, panel.rows)],
  });
  const count = `${panel.rows.length} point${panel.rows.length === 1 ? "" : "s"}`;
  const title = [chart.title, panel.name, count].filter(Boolean).join(", ");
  plot.setAttribute("aria-hidden", "true"); // the box says what it is
  box.setAttribute("role", "img");
  box.setAttribute("aria-label", title);
  const open = (row: Row) => openDetails(row, chart, run);
  plot.addEventListener("click", () => {
    const row = (plot as unknown as { value: Row | null }).value;
    if (row) open(row);
  });
  box.append(plot);
  const [x, y] = pointOf(chart);
  addKeys(box, plot, pointsOf(plot as unknown as Plot.Plot, panel.rows, x, y), title, (row) => tipText(row, chart), open);
  return box;
}

function optionsOf(chart: ChartData, panel: Panel, width: number, domains: { x?: Range; y?: Range }, marks: MarkData[]): Plot.PlotOptions {
  const scale = (axis: AxisData, domain?: Range): Plot.ScaleOptions => ({
    type: axis.log ? "log" : "linear",
    ...(domain ? { domain } : {}),
    label: axisTitle(axis),
    nice: !axis.log && !(chart.kind === "lines" && axis === chart.x),
    grid: !axis.log,
    ...(axis.log ? { axis: null } : wholeTicks(panel.rows, axis, domain)), // drawn by logAxis
  });
  if (chart.kind === "ranges") {
    const names = [...new Set(panel.rows.map((row) => String(row[chart.y.key])))];
    const marginLeft = Math.min(Math.max(0.5 * width, width - LEAST_PLOT), namePixels(chart, panel.rows));
    const tickFormat = (name: string) => wrapped(name, Math.floor((marginLeft - NAME_GAP) / NAME_PIXELS + 0.01));
    const lines = Math.max(...names.map((name) => tickFormat(name).split("\n").length));
    return {
      width, height: Math.max(24, LINE_PIXELS * lines + 4) * names.length + 54 + MARK_PIXELS * marks.length, marginLeft, marginRight: 18,
      marginTop: 10 + MARK_PIXELS * marks.length, marginBottom: 38, x: scale(chart.x, domains.x), y: { type: "point", domain: names, label: null, padding: 0.6, tickSize: 0, tickFormat },
    };
  }
  const height = chart.kind === "bars" ? Math.max(170, Math.min(240, 0.62 * width)) : Math.max(240, Math.min(420, 0.66 * width));
  return { width, height, marginLeft: 52, marginBottom: 40, marginTop: 24, marginRight: 18, x: scale(chart.x, domains.x), y: scale(chart.y, domains.y) };
}

const MOST_WHOLE = 12;

/** Of what is counted, numbers at whole ones alone. */
function wholeTicks(rows: Row[], axis: AxisData, domain?: Range): { ticks?: number[]; tickFormat?: string } {
  if (!domain || axis.unit || domain[1] - domain[0] > MOST_WHOLE || !rows.every((row) => Number.isInteger(row[axis.key] ?? 0))) return {};
  return { tickFormat: "d", ticks: Array.from({ length: MOST_WHOLE + 1 }, (_, k) => Math.ceil(domain[0]) + k).filter((value) => value <= domain[1]) };
}

function axisTitle(axis: AxisData): string {
  return axis.unit ? `${axis.title}, ${axis.unit}` : axis.title;
}

// Grid and numbers of the logarithmic axes.
function logAxes(chart: ChartData, domains: { x?: Range; y?: Range }, { width, marginLeft, marginRight }: Plot.PlotOptions): Plot.Markish[] {
  const found: Plot.Markish[] = [];
  if (chart.x.log && domains.x) {
    const ticks = logTicks(domains.x, width! - marginLeft! - marginRight!);
    found.push(Plot.gridX(ticks), Plot.axisX(ticks, { text: tickText, label: axisTitle(chart.x) } as Plot.AxisXOptions));
  }
  if (chart.y.log && domains.y && chart.kind !== "ranges") {
    const ticks = logTicks(domains.y);
    found.push(Plot.gridY(ticks), Plot.axisY(ticks, { text: tickText, label: axisTitle(chart.y) } as Plot.AxisYOptions));
  }
  return found;
}

/** What an axis has to hold: all values, their intervals, and the marks; room on both sides. */
function rangeOf(chart: ChartData, rows: Row[], axis: AxisData): Range | undefined {
  let [low, high] = [Infinity, -Infinity];
  const take = (value: unknown) => {
    if (typeof value !== "number" || (axis.log && value <= 0)) return;
    low = Math.min(low, value * axis.factor);
    high = Math.max(high, value * axis.factor);
  };
  for (const row of rows) for (const end of ["", "_low", "_high", "_to"]) take(row[axis.key + end]);
  if (chart.kind === "bars" && axis === chart.y) for (const row of rows) take(row["beside"]);
  const isX = axis === chart.x;
  if (isX && chart.kind !== "bars") for (const mark of chart.marks) take(mark.value);
  if (low > high) return undefined;
  if (chart.kind === "bars") return isX ? [low, high] : [Math.min(0, low), high * 1.05 || 1];
  if (axis.log) return low === high ? [low / 2, high * 2] : [low / 1.15, high * 1.15];
  if (isX && chart.kind === "lines") return low < high ? [low, high] : [low - 1, high + 1]; // a history ends where it ends
  const room = 0.05 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low >= 0 && low < room ? 0 : low - room, high + room]; // what is never below zero has no axis there
}

const at = (axis: AxisData, end = "") => (row: Row) => {
  const value = row[axis.key + end];
  return typeof value === "number" && !(axis.log && value <= 0) ? value * axis.factor : null;
};

function ground(chart: ChartData, marks: MarkData[]): Plot.Markish[] {
  const faint = pageColour("--faint");
  const found: Plot.Markish[] = [];
  if (chart.kind === "bars") found.push(Plot.ruleY([0]));
  const x = (mark: MarkData) => mark.value * chart.x.factor;
  if (marks.length && chart.kind !== "bars") {
    found.push(Plot.ruleX(marks, { x, stroke: faint, strokeDasharray: "4 3" }));
    marks.forEach((mark, place) => found.push(Plot.text([mark], { x, text: "title", fill: faint, fontSize: 10.5, frameAnchor: "top", lineAnchor: "bottom", dy: -2 - MARK_PIXELS * place })));
  }
  return found;
}

function marksOf(chart: ChartData, rows: Row[], style: SeriesStyle): Plot.Markish[] {
  const place = (row: Row) => Math.max(0, style.names.indexOf(String(chart.series ? (row[chart.series] ?? "") : "")));
  const colour = (row: Row) => style.colours[place(row)]!;
  const paper = pageColour("--paper");
  const fill = (row: Row) => (row["hollow"] ? paper : colour(row));
  const symbol = (row: Row) => style.names[place(row)]!;
  const plain = { symbol, stroke: { value: colour, scale: null }, fill: { value: fill, scale: null } } as unknown as Plot.DotOptions;
  const [x, y] = [at(chart.x), at(chart.y)];
  const line = { stroke: { value: colour, scale: null } } as unknown as Plot.RuleYOptions;
  switch (chart.kind) {
    case "ranges":
      return [
        Plot.ruleY(rows, { ...line, x1: at(chart.x, "_low"), x2: at(chart.x, "_high"), y: chart.y.key, strokeWidth: 2 } as Plot.RuleYOptions),
        Plot.dot(rows, { ...plain, x, y: chart.y.key, r: 4.5, strokeWidth: 1.5 } as Plot.DotOptions),
      ];
    case "points":
      return [
        Plot.ruleY(rows, { ...line, x1: at(chart.x, "_low"), x2: at(chart.x, "_high"), y, strokeOpacity: 0.7 } as Plot.RuleYOptions),
        Plot.ruleX(rows, { ...line, y1: at(chart.y, "_low"), y2: at(chart.y, "_high"), x, strokeOpacity: 0.7 } as unknown as Plot.RuleXOptions),
        Plot.dot(rows, { ...plain, x, y, r: 4.5, strokeWidth: 1.5 } as Plot.DotOptions),
      ];
    case "lines":
      return [
        Plot.line(rows, { x, y, z: chart.series || undefined, stroke: { value: colour, scale: null }, strokeWidth: 1.6 } as unknown as Plot.LineOptions),
        ...(rows.length <= 60 ? [Plot.dot(rows, { ...plain, x, y, r: 2.6 } as Plot.DotOptions)] : []),
      ];
    case "bars":
      return barMarks(chart, rows, x, y, colour);
  }
}

// Bars with the input's outline, and whiskers over the seeds.
function barMarks(chart: ChartData, rows: Row[], x: (row: Row) => number | null, y: (row: Row) => number | null, colour: (row: Row) => string): Plot.Markish[] {
  const to = at(chart.x, "_to");
  const ink = pageColour("--ink");
  const middle = (row: Row) => ((x(row) ?? 0) + (to(row) ?? 0)) / 2;
  const beside = rows.filter((row) => typeof row["beside"] === "number");
  return [
    Plot.rect(rows, { x1: x, x2: to, y1: 0, y2: y, fill: { value: colour, scale: null }, inset: 1 } as unknown as Plot.RectOptions),
    Plot.ruleX(rows, { x: middle, y1: at(chart.y, "_low"), y2: at(chart.y, "_high"), stroke: ink, strokeWidth: 1.2 }),
    Plot.ruleY(beside, { x1: x, x2: to, y: "beside", stroke: ink, strokeDasharray: "3 2", strokeWidth: 1.3 } as Plot.RuleYOptions),
  ];
}

/** Where a row's tip points to, in the units of the axes. */
function pointOf(chart: ChartData): [(row: Row) => number | null, (row: Row) => unknown] {
  const x = chart.kind === "bars" ? (row: Row) => ((at(chart.x)(row) ?? 0) + (at(chart.x, "_to")(row) ?? 0)) / 2 : at(chart.x);
  return [x, chart.kind === "ranges" ? (row) => row[chart.y.key] : at(chart.y)];
}

function tip(chart: ChartData, rows: Row[]): Plot.Markish {
  const options = { title: (row: Row) => tipText(row, chart), fill: pageColour("--paper"), stroke: pageColour("--faint"), maxRadius: 30, lineWidth: 40 };
  const [x, y] = pointOf(chart);
  return Plot.tip(rows, (chart.kind === "bars" ? Plot.pointerX : Plot.pointer)({ ...options, x, y } as Plot.TipOptions));
}

function legendOf(style: SeriesStyle): Element {
  const list = document.createElement("ul");
  list.className = "legend";
  style.names.forEach((name, place) => {
    const item = document.createElement("li");
    const mark = Plot.plot({
      width: 14, height: 14, margin: 0, axis: null, x: { domain: [-1, 1] }, y: { domain: [-1, 1] }, style: { background: "transparent", overflow: "visible" },
      marks: [Plot.dot([0], { x: 0, y: 0, r: 4.5, symbol: style.marks[place]!, fill: style.colours[place]!, stroke: style.colours[place]! })],
    });
    mark.setAttribute("aria-hidden", "true");
    item.append(mark, name);
    list.append(item);
  });
  return list;
}

// --- Saving ---------------------------------------------------------------------------------------------------------------------------

function saveButtons(place: HTMLElement, title: string): Element {
  const bar = document.createElement("p");
  bar.className = "files save";
  for (const kind of ["SVG", "PNG"] as const) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: `Save as ${kind}` });
    button.addEventListener("click", () => void save(place, title, kind));
    bar.append(button);
  }
  return bar;
}

/** All panels of a chart as one SVG, on the page's ground. */
function joinedSvg(place: HTMLElement): { text: string; width: number; height: number } {
  const box = place.getBoundingClientRect();
  const inner: string[] = [];
  for (const svg of place.querySelectorAll("svg")) {
    const own = svg.getBoundingClientRect();
    const copy = svg.cloneNode(true) as SVGElement;
    copy.removeAttribute("aria-hidden");
    copy.setAttribute("x", String(own.left - box.left));
    copy.setAttribute("y", String(own.top - box.top));
    inner.push(new XMLSerializer().serializeToString(copy));
  }
  for (const label of place.querySelectorAll<HTMLElement>(".panel-title, .legend li")) {
    const own = label.getBoundingClientRect();
    const text = document.createElementNS("http://www.w3.org/2000/svg", "text");
    text.textContent = label.textContent;
    const indent = label.matches("li") ? 18 : 0;
    Object.entries({ x: own.left - box.left + indent, y: own.top - box.top + 14, fill: pageColour("--ink"), "font-size": 13, "font-family": "sans-serif" })
      .forEach(([name, value]) => text.setAttribute(name, String(value)));
    inner.push(new XMLSerializer().serializeToString(text));
  }
  const [width, height] = [Math.ceil(box.width), Math.ceil(box.height)];
  const ground = `<rect width="100%" height="100%" fill="${pageColour("--paper")}"/>`;
  return { text: `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">${ground}${inner.join("")}</svg>`, width, height };
}

async function save(place: HTMLElement, title: string, kind: "SVG" | "PNG"): Promise<void> {
  const { text, width, height } = joinedSvg(place);
  const address = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  if (kind === "SVG") return download(address, `${title}.svg`);
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => blob && download(URL.createObjectURL(blob), `${title}.png`));
}

/** Hands a file to the reader. */
export function download(address: string, name: string): void {
  const link = Object.assign(document.createElement("a"), { href: address, download: name.replace(/[^\w.-]+/g, "_") });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
