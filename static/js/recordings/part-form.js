// A part of a recording from A to B: as a recording of its own, or as a film of map and camera.

import { make, onSubmit } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @import { Part } from "../net/recordings-api.js" */
/**
 * @typedef {object} PartRequest
 * @property {number} seconds length of the recording
 * @property {boolean} may this person may save it as a recording; a film is for everybody
 * @property {(part: Part, kind: "webp" | "gif") => string} film its address
 * @property {(part: Part) => Promise<unknown>} cut
 * @property {() => void} leave
 * @property {() => number} [here] where the recording stands [s], where it plays
 * @property {(part: Part) => void} [changed]
 */

const FORMS = /** @type {const} */ (["webp", "gif"]);

/**
 * The content of a form, which the caller puts onto its page.
 * @param {HTMLFormElement} form
 * @param {PartRequest} asked
 */
export function askForPart(form, { seconds, may, film, cut, leave, here, changed }) {
  const end = Math.max(Math.floor(seconds * 10) / 10, 0.1);
  const at = { type: "number", class: "field-box", min: "0", max: String(end), step: "0.1", required: true };
  const from = make("input", { ...at, value: "0" });
  const to = make("input", { ...at, value: String(end) });
  const part = () => ({ from: from.valueAsNumber, to: to.valueAsNumber });
  const films = FORMS.map((kind) => make("a.button", { download: "", "data-film": kind }, filmWords(kind)));
  const aim = () => {
    for (const [number, kind] of FORMS.entries()) films[number]?.setAttribute("href", film(part(), kind));
    changed?.(part());
  };
  /** @param {HTMLInputElement} box @param {string} words */
  const set = (box, words) => {
    const button = make("button.button", words);
    button.addEventListener("click", () => {
      box.value = (Math.round(10 * (here?.() ?? 0)) / 10).toFixed(1);
      aim();
    });
    return button;
  };
  const quit = make("button.button", { onclick: leave }, t("map-card.leave_it"));
  form.append(
    make("label", t("part-form.from"), from),
    ...(here ? [set(from, t("part-form.from_here"))] : []),
    make("label", t("part-form.to"), to),
    ...(here ? [set(to, t("part-form.to_here"))] : []),
    ...(may ? [make("button.button.primary", { type: "submit" }, t("part-form.as_recording"))] : []),
    ...films,
    quit,
  );
  aim();
  form.addEventListener("input", aim);
  onSubmit(form, () => {
    if (may) void cut(part());
  });
  form.addEventListener("keydown", (event) => event.key === "Escape" && leave());
  from.focus();
  form.scrollIntoView({ block: "nearest" });
}

/** @param {"webp" | "gif"} kind */
const filmWords = (kind) => t("part-form.film", { kind: kind.toUpperCase() });
