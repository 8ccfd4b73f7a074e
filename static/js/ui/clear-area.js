// The part of the large view over which no panel lies: the view fills the window, its middle is in that part.

/** @typedef {{left: number, top: number, right: number, bottom: number}} Insets [px] from the edges of the view */

/**
 * Tell how much of a view panels cover at each edge, now and whenever it changes; its style has it as `--clear-left` etc.
 * A view that lies elsewhere (the small one of map and camera, a page's) is covered by nothing.
 * @param {HTMLElement} view
 * @param {(insets: Insets) => void} then
 */
export function watchClearArea(view, then) {
  const over = /** @type {HTMLElement} */ (document.querySelector(".over"));
  const look = () => {
    const [all, free] = [view.getBoundingClientRect(), over.getBoundingClientRect()];
    const insets = insetsOf(all, free);
    for (const [side, inset] of Object.entries(insets)) view.style.setProperty(`--clear-${side}`, `${inset}px`);
    then(insets);
  };
  const watch = new ResizeObserver(look);
  for (const part of [view, over]) watch.observe(part);
  addEventListener("views-swapped", () => requestAnimationFrame(look));
}

/** States of the status that pass by themselves: the map gives no way to them. */
const PASSES = ["refused", "failed", "done", "stopped"];

/**
 * Tell how much of the large view's lower edge the status takes, with what a running command shows above it.
 * @param {(height: number) => void} then [px]
 */
export function watchLowerEdge(then) {
  const parts = /** @type {HTMLElement[]} */ ([...document.querySelectorAll(".now > :not(notice-toasts)")]);
  const watch = new ResizeObserver(() => {
    const height = heightOf(parts);
    if (height !== null) then(height);
  });
  for (const part of parts) watch.observe(part);
}

/**
 * How high the parts stand that are shown, one above the other.
 * @param {ReadonlyArray<Pick<HTMLElement, "offsetTop" | "offsetHeight" | "dataset">>} parts
 * @returns {number | null} [px]; null while one says what passes by itself
 */
export function heightOf(parts) {
  const shown = parts.filter(({ offsetHeight }) => offsetHeight > 0);
  if (shown.some(({ dataset }) => PASSES.includes(dataset["state"] ?? ""))) return null;
  const ends = shown.map(({ offsetTop, offsetHeight }) => offsetTop + offsetHeight);
  return shown.length ? Math.max(...ends) - Math.min(...shown.map(({ offsetTop }) => offsetTop)) : 0;
}

/** @param {Insets} all of the window @param {Insets} free of the window @returns {Insets} */
export function insetsOf(all, free) {
  const inside = free.left >= all.left && free.top >= all.top && free.right <= all.right && free.bottom <= all.bottom;
  if (!inside) return { left: 0, top: 0, right: 0, bottom: 0 };
  return {
    left: free.left - all.left,
    top: free.top - all.top,
    right: all.right - free.right,
    bottom: all.bottom - free.bottom,
  };
}
