// Where axes have numbers and how long names are written: as much as there is room for.

export type Range = [number, number];

export const NAME_PIXELS = 6.7; // of a letter of a label
const TICK_PIXELS = 7.2; // of a digit of an axis
const TICK_GAP = 8;

const DIGITS = [ // between powers of ten, and up to how many of these
  { digits: [1, 2, 3, 4, 5, 6, 7, 8, 9], decades: 0.35 },
  { digits: [1, 2, 3, 5, 7], decades: 0.7 },
  { digits: [1, 2, 5], decades: 2.5 },
];
const MOST_POWERS = 7;

export function tickText(value: number): string {
  return value >= 1e5 || value < 1e-3 ? value.toExponential(0).replace("e+", "e") : String(Number(value.toPrecision(3)));
}

function ticksAt([low, high]: Range, digits: readonly number[], every: number): number[] {
  const found: number[] = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++)
    if (power % every === 0) for (const digit of digits) found.push(digit * 10 ** power);
  return found.filter((value) => value >= low && value <= high);
}

/** Whether the numbers of these ticks stand apart on an axis of so many pixels. */
function standApart(ticks: readonly number[], [low, high]: Range, pixels: number): boolean {
  const at = (value: number) => (pixels * Math.log(value / low)) / Math.log(high / low);
  const half = (value: number) => 0.5 * TICK_PIXELS * tickText(value).length;
  return ticks.every((value, k) => k === 0 || at(value) - half(value) - TICK_GAP >= at(ticks[k - 1]!) + half(ticks[k - 1]!));
}

/** Where a logarithmic axis has numbers: at powers of ten, and at 2 and 5 (or at more digits) between them where there is room on so many pixels. */
export function logTicks(range: Range, pixels = 1e9): number[] {
  const decades = Math.log10(range[1] / range[0]);
  for (const { digits, decades: most } of DIGITS) {
    const ticks = ticksAt(range, digits, 1);
    if (decades < most && standApart(ticks, range, pixels)) return ticks;
  }
  for (let every = Math.max(1, Math.ceil(decades / MOST_POWERS)); ; every++) {
    const ticks = ticksAt(range, [1], every);
    if (standApart(ticks, range, pixels)) return ticks;
  }
}

/** A name in lines of at most so many letters, broken behind a space, or else a comma, a dash or an underscore, where it can be. */
export function wrapped(name: string, letters: number): string {
  const lines: string[] = [];
  let rest = name;
  while (rest.length > letters) {
    const start = rest.slice(0, letters);
    const [head] = rest.slice(0, letters + 1).match(/^.+\s/) ?? start.match(/^.+[,_/-]/) ?? [start];
    lines.push(head.trimEnd());
    rest = rest.slice(head.length);
  }
  return [...lines, rest].join("\n");
}
