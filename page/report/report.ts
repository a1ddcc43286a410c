// The report's script: what makes a page that already reads without it come alive.
import { enlivenBodies } from "./bodies";
import { enlivenChart } from "./charts";
import { readBlock, showFault, type RunData } from "./page_data";
import { enliven } from "./tables";
import { addThemeSwitch } from "./theme";

function start(): void {
  const bar = document.getElementById("tools");
  if (bar) addThemeSwitch(bar);
  for (const table of document.querySelectorAll<HTMLElement>("div.table")) enliven(table);
  let run: RunData = { plan: "", command: "", shown_cases: [] };
  try {
    run = readBlock<RunData>("run-data");
  } catch (error) {
    const place = document.querySelector("header");
    if (place) showFault(place.appendChild(document.createElement("div")), "This page is damaged", error);
  }
  for (const place of document.querySelectorAll<HTMLElement>("[data-chart]")) enlivenChart(place, run);
  const bodies = document.querySelector<HTMLElement>("[data-bodies]");
  if (bodies) enlivenBodies(bodies);
}

start();
