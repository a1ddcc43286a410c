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

/** A colour and a mark for each name; the mark changes where the colours begin again. */
export function styleSeries(names: string[], dark: boolean): SeriesStyle {
  const colours = dark ? DARK : LIGHT;
  return {
    names,
    colours: names.map((_, place) => colours[place % colours.length]!),
    marks: names.map((_, place) => MARKS[(place + Math.floor(place / colours.length)) % MARKS.length]!),
  };
}
