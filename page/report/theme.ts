// Light and dark: what the system asks for, until a reader chooses.
const NAMES = ["system", "light", "dark"] as const;
type Theme = (typeof NAMES)[number];

/** Whether the page is dark now. */
export function isDark(): boolean {
  const chosen = document.documentElement.dataset["theme"];
  return chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

/** A colour of the page's style sheet, such as "--ink". */
export function pageColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

const listeners = new Set<() => void>();

/** Calls `listener` each time the page turns light or dark. */
export function onTheme(listener: () => void): void {
  listeners.add(listener);
}

function tell(): void {
  for (const listener of listeners) listener();
}

/** Adds the switch to the page's bar. */
export function addThemeSwitch(bar: Element): void {
  const label = document.createElement("label");
  label.className = "theme";
  const choice = document.createElement("select");
  for (const name of NAMES) choice.append(new Option(name, name));
  label.append("Colours ", choice);
  choice.addEventListener("change", () => {
    const theme = choice.value as Theme;
    if (theme === "system") delete document.documentElement.dataset["theme"];
    else document.documentElement.dataset["theme"] = theme;
    tell();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", tell);
  bar.append(label);
}
