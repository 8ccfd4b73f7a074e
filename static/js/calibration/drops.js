// Files that are dragged onto a part of the page.

import { mark } from "../element.js";

/**
 * @param {HTMLElement} place shows by data-dropping that files would be taken
 * @param {() => boolean} wants whether it takes files now
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
