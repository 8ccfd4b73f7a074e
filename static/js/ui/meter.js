// A bar that fills.

import { make, mark } from "./element.js";

/**
 * @param {`div.meter${string}`} selector
 * @param {{role?: "progressbar" | "meter", [attribute: string]: string | boolean | undefined}} attributes
 */
export function meter(selector, attributes) {
  const fill = make("span.meter-fill");
  const range = attributes.role ? { "aria-valuemin": "0", "aria-valuemax": "100" } : {};
  const element = make(/** @type {"div"} */ (selector), { ...range, ...attributes }, fill);
  /** @param {number | null} part 0 to 1; null: nobody knows how far it is */
  const set = (part) => {
    const percent = part === null ? null : String(Math.round(100 * part));
    fill.style.width = `${percent ?? 100}%`;
    mark(element, "data-uncounted", percent === null);
    if (attributes.role) mark(element, "aria-valuenow", percent);
  };
  return { element, fill, set };
}
