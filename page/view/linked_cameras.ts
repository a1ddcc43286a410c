// Views that turn together.
import type { OrganView } from "./organ_view";

/** Makes views turn together. Returns what undoes it. */
export function linkCameras(views: readonly OrganView[]): () => void {
  let busy = false;
  const undo = views.map((view) => {
    const follow = () => {
      if (busy) return;
      busy = true;
      for (const other of views) if (other !== view) other.copyCamera(view);
      busy = false;
    };
    view.cameraListeners.add(follow);
    return () => view.cameraListeners.delete(follow);
  });
  return () => undo.forEach((each) => each());
}
