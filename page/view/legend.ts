// The legend of a colour scale: beside the view, and in an exported picture.
import { colourAt, rangeOf, shortNumber, type Scalars, type ScaleName } from "./colour_scale";

const STOPS = 12;

export interface LegendText {
  title: string;
  ticks: string[];
  scale: ScaleName;
}

/** What a legend says: name and unit, and the numbers at both ends and in the middle. */
export function legendText(scalars: Scalars): LegendText {
  const [low, high] = scalars.range ?? rangeOf(scalars.values);
  return {
    title: scalars.unit ? `${scalars.name}, ${scalars.unit}` : scalars.name,
    ticks: [low, (low + high) / 2, high].map(shortNumber),
    scale: scalars.scale ?? "viridis",
  };
}

/** Fills a legend's element; empties it where there are no figures. */
export function showLegend(element: HTMLElement, scalars: Scalars | null): void {
  element.replaceChildren();
  element.hidden = !scalars;
  if (!scalars) return;
  const { title, ticks, scale } = legendText(scalars);
  const stops = Array.from({ length: STOPS + 1 }, (_, i) => `rgb(${colourAt(scale, i / STOPS).join(" ")})`);
  const name = document.createElement("div");
  name.textContent = title;
  const bar = document.createElement("div");
  bar.className = "organ-legend-bar";
  bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  const numbers = document.createElement("div");
  numbers.className = "organ-legend-ticks";
  for (const tick of ticks) numbers.append(Object.assign(document.createElement("span"), { textContent: tick }));
  element.append(name, bar, numbers);
}

/** Draws the legend into a picture, at its lower left. */
export function drawLegend(context: CanvasRenderingContext2D, scalars: Scalars, ink: string, size: number): void {
  const { title, ticks, scale } = legendText(scalars);
  const [left, width, height] = [size, 14 * size, size];
  const top = context.canvas.height - 3.4 * size;
  for (let x = 0; x < width; x++) {
    context.fillStyle = `rgb(${colourAt(scale, x / (width - 1)).join(" ")})`;
    context.fillRect(left + x, top, 1.5, height);
  }
  context.fillStyle = ink;
  context.font = `${size}px sans-serif`;
  context.textBaseline = "alphabetic";
  context.textAlign = "left";
  context.fillText(title, left, top - 0.5 * size);
  (["left", "center", "right"] as const).forEach((align, i) => {
    context.textAlign = align;
    context.fillText(ticks[i]!, left + (width * i) / 2, top + 2.3 * size);
  });
}
