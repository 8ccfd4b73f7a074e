// Accept files dropped onto an element.

import { mark } from "./element.js";

/**
 * @param {HTMLElement} place gets data-dropping while files are dragged over it
 * @param {() => boolean} wants true while it accepts files
 * @param {(files: FileList) => void} take
 */
export function takeDrops(place, wants, take) {
  place.addEventListener("dragover", (event) => {
    if (!wants()) return;
    event.preventDefault();
    mark(place, "data-dropping", true);
  });
  place.addEventListener("dragleave", () => mark(place, "data-dropping", null));
  place.addEventListener("drop", (event) => {
    mark(place, "data-dropping", null);
    const files = event.dataTransfer?.files;
    if (!wants() || !files) return;
    event.preventDefault();
    take(files);
  });
}
