// The report's script: what makes a page that already reads without it come alive.
import { OrganView } from "../view/organ_view";

declare global {
  interface Window {
    palpate?: Record<string, unknown>;
  }
}

window.palpate = { OrganView };
