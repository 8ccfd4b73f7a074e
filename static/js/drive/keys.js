// Map keys to intentions. Uses key codes, so that W A S D stay together on every keyboard layout.

/** @typedef {{v: number, w: number}} Velocity requested by keys or stick, −1 to 1 each: forward, turn left */

/** @type {Readonly<Record<string, Velocity>>} */
const AXES = {
  KeyW: { v: 1, w: 0 },
  ArrowUp: { v: 1, w: 0 },
  KeyS: { v: -1, w: 0 },
  ArrowDown: { v: -1, w: 0 },
  KeyA: { v: 0, w: 1 },
  ArrowLeft: { v: 0, w: 1 },
  KeyD: { v: 0, w: -1 },
  ArrowRight: { v: 0, w: -1 },
};

/** @type {Readonly<Record<string, number>>} [s] by which a key moves in a recording */
const SEEKS = { ArrowLeft: -5, ArrowRight: 5, Home: -Infinity, End: Infinity };

/** @param {number} value */
const unit = (value) => Math.min(1, Math.max(-1, value));

/** The driving keys that are down. */
export class HeldKeys {
  /** @type {Set<string>} */
  #down = new Set();

  /** @param {string} code */
  press(code) {
    if (code in AXES) this.#down.add(code);
  }

  /** @param {string} code */
  release(code) {
    this.#down.delete(code);
  }

  clear() {
    this.#down.clear();
  }

  /** @returns {Velocity} opposite keys cancel */
  get velocity() {
    let [v, w] = [0, 0];
    for (const code of this.#down) {
      v += AXES[code]?.v ?? 0;
      w += AXES[code]?.w ?? 0;
    }
    return { v: unit(v), w: unit(w) };
  }
}

/**
 * @typedef {object} KeyPress the relevant part of a KeyboardEvent
 * @property {string} code
 * @property {string} key
 * @property {boolean} ctrlKey
 * @property {boolean} altKey
 * @property {boolean} metaKey
 */

/**
 * @typedef {{does: "stop"} | {does: "seek", seconds: number} | {does: "drive"} | {does: "slow"} | {does: "preset", preset: number} | {does: "words"}
 *   | {does: "talk"}
 *   | {does: "begin"}
 *   | {does: "help"}} Intention
 */

export const TALK = "KeyV"; // held to talk
const ARROWS = /^Arrow(?:Up|Down|Left|Right)$/;

/**
 * Intention of a key; null when the page does not handle it.
 * @param {KeyPress} press
 * @param {{typing: boolean, singleKeys: boolean, scrolling?: boolean, reading?: boolean, waiting?: boolean, recording?: boolean}} where
 *   typing: a text box has the focus; singleKeys: single letters, digits and Space act; scrolling: the arrows move
 *   what has the focus; reading: a dialog is open; waiting: Enter begins a pending command; recording: the arrows
 *   seek
 * @returns {Intention | null}
 */
export function intentionOf(
  press,
  { typing, singleKeys, scrolling = false, reading = false, waiting = false, recording = false },
) {
  if (press.key === "Escape" || press.code === "Escape") return { does: "stop" };
  if (typing || press.ctrlKey || press.altKey || press.metaKey) return null;
  if (press.key === "Enter") return waiting && !reading ? { does: "begin" } : null;
  if (!singleKeys) return null;
  if (press.code === "Space") return { does: "stop" };
  if (recording && press.code in SEEKS)
    return reading || scrolling ? null : { does: "seek", seconds: SEEKS[press.code] ?? 0 };
  if (press.code in AXES) return reading || (scrolling && ARROWS.test(press.code)) ? null : { does: "drive" };
  if (press.code === "ShiftLeft" || press.code === "ShiftRight") return { does: "slow" };
  if (press.code === TALK) return reading ? null : { does: "talk" };
  if (press.key === "/") return { does: "words" };
  if (press.key === "?") return { does: "help" };
  const digit = /^(?:Digit|Numpad)([1-5])$/.exec(press.code)?.[1];
  return digit ? { does: "preset", preset: Number(digit) } : null;
}

const TEXT_TYPES = new Set(["text", "search", "password", "number", "email", "url", "tel"]);

/**
 * True when the element takes text. Works across the scene frame, whose elements belong to another realm.
 * @param {EventTarget | null | undefined} target
 */
export function takesText(target) {
  const element = /** @type {Partial<HTMLInputElement> | null | undefined} */ (target);
  const tag = element?.tagName?.toLowerCase();
  if (tag === "input") return TEXT_TYPES.has(element?.type ?? "text");
  return tag === "textarea" || tag === "select" || element?.isContentEditable === true;
}

/**
 * True when the arrow keys move something in the element, such as a list or a slider.
 * @param {EventTarget | null | undefined} target
 */
export function scrolls(target) {
  const element = /** @type {Partial<HTMLElement> | null | undefined} */ (target);
  return (
    element?.closest?.(
      ".scrolls, [role=tabpanel], [role=tab]:focus-visible, input[type=range], [role=listbox], [role=slider]",
    ) != null
  );
}

/**
 * True when Enter belongs to the element: one focused by the keyboard, or STOP.
 * @param {EventTarget | null | undefined} target
 */
export function takesEnter(target) {
  const element = /** @type {Partial<HTMLElement> | null | undefined} */ (target);
  const control = element?.closest?.("button, a[href], summary, input, [role=button], [role=option]");
  return control != null && (control.matches(":focus-visible") || control.closest("stop-button") !== null);
}
