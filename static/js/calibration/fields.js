// Form fields: picture source, stepper for counts, length in millimetres.

import { icon, make } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @import { Source } from "./types.js" */

/**
 * @param {Source} value
 * @param {string} drawing
 * @param {string} name
 * @param {string} says
 */
export function source(value, drawing, name, says) {
  const input = make("input", { type: "radio", name: "source", value });
  const note = make("span.note", says);
  const words = make("span.source-words", make("span.source-name", name), note);
  return { input, note, says, row: make("label.source", input, icon(drawing), words) };
}

/**
 * A whole number with − and +.
 * @param {string} id
 * @param {string} name
 * @param {number} start
 */
export function stepper(id, name, start) {
  const input = make("input.words", {
    id,
    type: "text",
    inputmode: "numeric",
    value: String(start),
    autocomplete: "off",
  });
  /** @param {number} step */
  const by = (step) => {
    const sign = step < 0 ? "−" : "+";
    const button = make(
      "button.button",
      { "aria-label": `${name}: ${step < 0 ? t("fields.one_less") : t("fields.one_more")}` },
      sign,
    );
    button.addEventListener("click", () => {
      field.value = Math.min(40, Math.max(3, (field.value || start) + step));
      input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    return button;
  };
  const field = {
    row: make("div.box", make("label", { for: id }, name), make("div.corner-count", by(-1), input, by(1))),
    get value() {
      return /^\d{1,2}$/.test(input.value.trim()) ? Number(input.value) : NaN;
    },
    set value(count) {
      input.value = String(count);
    },
  };
  return field;
}

/**
 * A length, entered in millimetres.
 * @param {string} id
 * @param {string} name
 * @param {string} unit
 * @param {string} start
 */
export function box(id, name, unit, start) {
  const input = make("input.words", { id, type: "text", inputmode: "decimal", value: start, autocomplete: "off" });
  const row = make(
    "div.box",
    make("label", { for: id }, name),
    make("div.inline.with-unit", input, make("span", unit)),
  );
  return {
    row,
    get entered() {
      return input.value.trim();
    },
    /** @returns {number | null} null when it is empty, NaN when it is no number */
    get metres() {
      const text = input.value.trim().replace(",", ".");
      return text === "" ? null : Number(text) / 1000;
    },
    set metres(length) {
      input.value = length === null ? "" : String(Math.round(length * 1e5) / 100);
    },
  };
}

/** @param {string} name */
export const option = (name) => make("option", { value: name }, name === "letter" ? t("fields.us_letter") : name);
