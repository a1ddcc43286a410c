// Colours and marks of series: Okabe and Ito's, apart for the colour-blind; marks tell them apart in grey print. The sky blue is darker than
// theirs: each has at least three times the page's light, or a third of it (WCAG 2.2, 1.4.11).
const LIGHT = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#8c6d1f", "#2F97CF", "#7a5195", "#444444"];
const DARK = ["#56A8E0", "#FF8A3D", "#2FC79B", "#E7A3CB", "#D9B84A", "#9AD6FF", "#B99AE0", "#C8CDD2"];
const MARKS = ["circle", "square", "triangle", "diamond", "star", "wye", "cross", "times"] as const;

export interface SeriesStyle {
  names: string[];
  colours: string[];
  marks: (typeof MARKS)[number][];
}

/** The place of each name over the charts of a page, so that a name looks alike on all of them: the first that no name beside it on any chart has. */
export function placeNames(charts: readonly (readonly string[])[]): Map<string, number> {
  const beside = new Map<string, Set<string>>();
  for (const names of charts) {
    for (const name of names) {
      const own = beside.get(name) ?? new Set();
      beside.set(name, own);
      for (const other of names) own.add(other);
    }
  }
  const places = new Map<string, number>();
  for (const [name, others] of beside) {
    const taken = new Set([...others].map((other) => places.get(other)));
    let place = 0;
    while (taken.has(place)) place++;
    places.set(name, place);
  }
  return places;
}

/** A colour and a mark for each name, by its place on the page or else in the list; the mark changes where the colours begin again. */
export function styleSeries(names: string[], dark: boolean, places?: ReadonlyMap<string, number>): SeriesStyle {
  const colours = dark ? DARK : LIGHT;
  const own = names.map((name, k) => places?.get(name) ?? k);
  return {
    names,
    colours: own.map((place) => colours[place % colours.length]!),
    marks: own.map((place) => MARKS[(place + Math.floor(place / colours.length)) % MARKS.length]!),
  };
}
