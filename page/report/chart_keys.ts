// Charts by the keyboard: arrows go from point to point, Enter opens the record; what a point is, is said to screen readers.
import type * as Plot from "@observablehq/plot";
import type { Row } from "./details";

/** A point of a plot: its row, and where it is in the plot's own pixels. */
export interface PlotPoint {
  row: Row;
  x: number;
  y: number;
}

type Way = (place: number, last: number) => number;

const WAYS: Record<string, Way> = {
  ArrowRight: (place, last) => Math.min(last, place + 1),
  ArrowDown: (place, last) => Math.min(last, place + 1),
  ArrowLeft: (place) => Math.max(0, place - 1),
  ArrowUp: (place) => Math.max(0, place - 1),
  Home: () => 0,
  End: (_, last) => last,
};

/** Where a plot has the values of `rows`, in the order in which keys go through them; those that an axis cannot show are left out. */
export function pointsOf(plot: Plot.Plot, rows: Row[], x: (row: Row) => unknown, y: (row: Row) => unknown): PlotPoint[] {
  const [across, up] = [plot.scale("x"), plot.scale("y")];
  if (!across || !up) return [];
  const points = rows.map((row) => ({ row, x: isThere(x(row)) ? Number(across.apply(x(row))) : NaN, y: isThere(y(row)) ? Number(up.apply(y(row))) : NaN }));
  return points.filter((point) => Number.isFinite(point.x) && Number.isFinite(point.y));
}

function isThere(value: unknown): boolean {
  return value !== null && value !== undefined;
}

/**
 * Makes the box around a plot answer the keyboard. `text` is what is said of a row, `open` what Enter does with it. The pointer's own tip is
 * shown at the point, by the events that a pointer would send.
 */
export function addKeys(box: HTMLElement, plot: SVGElement | HTMLElement, points: PlotPoint[], title: string, text: (row: Row) => string, open: (row: Row) => void): void {
  if (!points.length) return;
  const said = Object.assign(document.createElement("div"), { className: "said" });
  said.setAttribute("role", "status");
  box.append(said);
  box.tabIndex = 0;
  box.setAttribute("role", "application");
  box.setAttribute("aria-roledescription", "chart");
  box.setAttribute("aria-label", `${title}. Arrow keys go from point to point, Enter opens a point's record.`);
  const svg = plot instanceof SVGSVGElement ? plot : plot.querySelector("svg");
  const point = (type: string, at: PlotPoint) => {
    const corner = svg?.getScreenCTM();
    if (!svg || !corner) return;
    const place = new DOMPoint(at.x, at.y).matrixTransform(corner);
    svg.dispatchEvent(new PointerEvent(type, { clientX: place.x, clientY: place.y, pointerType: "mouse", bubbles: true }));
  };
  let place = -1;
  box.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = WAYS[event.key];
    const here = points[place];
    if (way) {
      place = place < 0 ? (event.key === "End" ? points.length - 1 : 0) : way(place, points.length - 1);
      const next = points[place]!;
      point("pointerenter", next);
      point("pointermove", next);
      said.textContent = text(next.row);
    } else if (event.key === "Enter" && here) {
      open(here.row);
    } else {
      return;
    }
    event.preventDefault();
  });
  box.addEventListener("blur", () => {
    const here = points[place];
    if (here) point("pointerleave", here);
    place = -1;
    said.textContent = "";
  });
}
