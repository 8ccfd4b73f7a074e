// Element <gamepad-sheet>: dialog with the live state of the gamepads and the mapping of each, to learn it by pressing.

import {
  CURVE,
  DEAD_ZONE,
  defaultMapping,
  deflection,
  isComplete,
  isPressed,
  PRESSES,
  STICKS,
  stickVelocity,
  TITLES,
} from "../drive/gamepad-mapping.js";
import { inputName, padName } from "../drive/gamepad-names.js";
import { isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { Sheet } from "../ui/sheet.js";
import { t } from "../ui/texts.js";

/** @import { GamepadInput } from "../drive/gamepad-input.js" */
/** @import { Mapping, Pad, PadAction } from "../drive/gamepad-mapping.js" */
/** @import { View } from "../net/session.js" */

const ABSENT = t("gamepad-sheet.no_gamepad_connect_one_and_press");
const WITHHELD = t("gamepad-sheet.this_browser_gives_gamepads_only_to");

export class GamepadSheet extends Sheet {
  #status = make("p.pad-status");
  #choice = make("div.pad-choice", { role: "group", "aria-label": t("gamepad-sheet.gamepad") });
  #forward = meter(t("gamepad-sheet.forward"));
  #left = meter(t("gamepad-sheet.turn_left"));
  #asked = make("p.note");
  /** @type {Map<PadAction, {row: HTMLElement, name: HTMLElement, change: HTMLButtonElement}>} */
  #rows = new Map([...PRESSES, ...STICKS].map((action) => [action, this.#row(action)]));
  #prompt = make("p.pad-prompt");
  #cancel = make("button.button", { hidden: true }, t("gamepad-sheet.cancel"));
  #setUp = make("button.button", t("gamepad-sheet.set_up_by_pressing"));
  #reset = make("button.button", t("gamepad-sheet.default_mapping"));
  #deadZone = slider(t("gamepad-sheet.dead_zone"), DEAD_ZONE);
  #curve = slider(t("gamepad-sheet.gentle_near_the_centre"), CURVE);
  #buttons = make("div.pad-buttons", { role: "img" });
  #axes = make("div.pad-axes");
  #body = make(
    "div.pad-body",
    { hidden: true },
    this.#choice,
    make("div.pad-meters", this.#forward.row, this.#left.row),
    this.#asked,
    make("div.row.pad-learn", this.#prompt, this.#cancel, this.#setUp, this.#reset),
    make("div.pad-rows", ...[...this.#rows.values()].map(({ row }) => row)),
    make("div.pad-meters", this.#deadZone.row, this.#curve.row),
    make("h3.card-title", t("gamepad-sheet.everything_on_it")),
    this.#buttons,
    this.#axes,
  );
  /** @type {GamepadInput | null} */
  #gamepad = null;
  #chosen = -1; // index of the gamepad that is shown
  #said = "";

  /** @override */
  build() {
    const note = t("gamepad-sheet.nothing_drives_while_this_is_open");
    this.frame(t("gamepad-sheet.gamepad"), this.#status, this.#body, make("p.note", note));
  }

  /** @param {GamepadInput} gamepad */
  hold(gamepad) {
    this.#gamepad = gamepad;
    for (const [action, { change }] of this.#rows) {
      change.addEventListener("click", () => this.#with((pad) => gamepad.learn(pad, [action])));
    }
    this.#setUp.addEventListener("click", () => this.#with((pad) => gamepad.setUp(pad)));
    this.#reset.addEventListener("click", () => this.#with((pad) => gamepad.keep(pad, defaultMapping(pad))));
    this.#cancel.addEventListener("click", () => {
      gamepad.stopLearning();
      this.#setUp.focus();
    });
    /** @param {"deadZone" | "curve"} key @param {HTMLInputElement} input */
    const tune = (key, input) =>
      input.addEventListener("input", () =>
        this.#with((pad) => gamepad.keep(pad, { ...gamepad.mappingOf(pad), [key]: Number(input.value) })),
      );
    tune("deadZone", this.#deadZone.input);
    tune("curve", this.#curve.input);
  }

  /** @override */
  shut() {
    this.#gamepad?.stopLearning();
    super.shut();
  }

  /** @override @param {View} view */
  show({ permission }) {
    const gamepad = this.#gamepad;
    if (this.hidden || !gamepad) return;
    const pad = this.#pad;
    this.#body.hidden = !pad;
    write(this.#status, pad ? statusOf(pad, gamepad, permission) : gamepad.available ? ABSENT : WITHHELD);
    if (!pad) return;
    const mapping = gamepad.mappingOf(pad);
    this.#showChoice(gamepad.pads, pad);
    this.#showJog(pad, mapping);
    this.#showRows(pad, mapping, gamepad.learning.action);
    this.#showLearning(gamepad.learning);
    this.#deadZone.set(mapping.deadZone);
    this.#curve.set(mapping.curve);
    this.#showAll(pad);
  }

  get #pad() {
    const pads = this.#gamepad?.pads ?? [];
    return pads.find(({ index }) => index === this.#chosen) ?? pads[0];
  }

  /** @param {(pad: Pad) => void} act */
  #with(act) {
    const pad = this.#pad;
    if (pad) act(pad);
  }

  /** @param {PadAction} action */
  #row(action) {
    const name = make("span.pad-input");
    const change = make(
      "button.button",
      { "aria-label": t("gamepad-sheet.change_titles", { titles: TITLES[action] }) },
      t("gamepad-sheet.change"),
    );
    const row = make("div.pad-row", make("span.pad-title", TITLES[action]), name, change);
    return { row, name, change };
  }

  /** @param {readonly Pad[]} pads @param {Pad} shown */
  #showChoice(pads, shown) {
    this.#choice.hidden = pads.length < 2;
    if (isNew(this.#choice, ...pads.map(({ index, id }) => [index, id]))) {
      this.#choice.replaceChildren(
        ...pads.map(({ index, id }) => {
          const words = `${index + 1}: ${padName(id)}`;
          const button = make("button.button", { "data-index": String(index) }, words);
          button.addEventListener("click", () => {
            this.#gamepad?.stopLearning();
            this.#chosen = index;
          });
          return button;
        }),
      );
    }
    for (const button of this.#choice.children) {
      mark(button, "aria-pressed", String(button.getAttribute("data-index") === String(shown.index)));
    }
  }

  /** @param {Pad} pad @param {Mapping} mapping */
  #showJog(pad, mapping) {
    const { v, w } = stickVelocity(pad, mapping);
    this.#forward.set(v);
    this.#left.set(w);
    const { deadman } = mapping.inputs;
    const held = isPressed(pad, deadman);
    const name = deadman ? inputName(pad, deadman) : t("gamepad-sheet.the_button");
    write(
      this.#asked,
      held
        ? t("gamepad-sheet.name_is_held_this_would_drive", { name })
        : t("gamepad-sheet.drives_only_while_name_is_held", { name }),
    );
  }

  /** @param {Pad} pad @param {Mapping} mapping @param {PadAction | null} learning */
  #showRows(pad, mapping, learning) {
    for (const [action, { row, name, change }] of this.#rows) {
      const input = mapping.inputs[action];
      const moved =
        input && "axis" in input ? Math.abs(deflection(pad, input)) > mapping.deadZone : isPressed(pad, input);
      write(name, input ? inputName(pad, input) : t("gamepad-sheet.not_set"));
      mark(row, "data-lit", moved);
      mark(row, "data-learning", action === learning);
      change.disabled = learning !== null;
    }
  }

  /** @param {GamepadInput["learning"]} learning */
  #showLearning({ action, prompt, outcome }) {
    const words = action ? `${TITLES[action]}: ${prompt}` : outcome;
    write(this.#prompt, words);
    if (words && words !== this.#said) this.session.announce(words);
    this.#said = words;
    if (action && this.#cancel.hidden) {
      this.#cancel.hidden = false;
      this.#cancel.focus();
    } else if (!action && !this.#cancel.hidden) {
      const focused = document.activeElement === this.#cancel;
      this.#cancel.hidden = true;
      if (focused) this.#setUp.focus();
    }
    this.#setUp.hidden = this.#reset.hidden = action !== null;
  }

  /** @param {Pad} pad */
  #showAll({ id, mapping, buttons, axes }) {
    if (isNew(this.#axes, id, buttons.length, axes.length)) {
      const name = { id, mapping };
      this.#buttons.replaceChildren(
        ...buttons.map((_, button) => make("span.pad-button", inputName(name, { button }))),
      );
      this.#axes.replaceChildren(...axes.map((_, axis) => meter(axisName(name, axis)).row));
    }
    for (const [index, { pressed }] of buttons.entries()) {
      const lamp = this.#buttons.children[index];
      if (lamp) mark(lamp, "data-lit", pressed);
    }
    const down = buttons.flatMap(({ pressed }, button) => (pressed ? [inputName({ id, mapping }, { button })] : []));
    mark(
      this.#buttons,
      "aria-label",
      t("gamepad-sheet.buttons_pressed_join", { join: down.join(", ") || t("gamepad-sheet.none") }),
    );
    for (const [index, value] of axes.entries()) showPart(this.#axes.children[index], value);
  }
}

/** @param {Pick<Pad, "id" | "mapping">} pad @param {number} axis */
const axisName = (pad, axis) => inputName(pad, { axis, sign: 1, rest: 0 }).replace(/ \+$/, "");

/** @param {Pad} pad @param {GamepadInput} gamepad @param {View["permission"]} permission */
function statusOf(pad, gamepad, permission) {
  if (!isComplete(gamepad.mappingOf(pad)))
    return t("gamepad-sheet.padname_this_browser_does_not_know", { padname: padName(pad.id) });
  return t("gamepad-sheet.padname_is_connected_value", {
    padname: padName(pad.id),
    value: permission.may === "no" ? permission.why : t("gamepad-sheet.close_this_dialog_to_drive"),
  });
}

/** A bar from the middle to either side. @param {string} title */
function meter(title) {
  const bar = make(
    "span.pad-bar",
    { role: "meter", "aria-label": title, "aria-valuemin": "-100", "aria-valuemax": "100" },
    make("span.pad-part"),
  );
  const row = make("div.pad-meter", make("span", title), bar, make("span.pad-figure"));
  showPart(row, 0);
  return { row, set: (/** @type {number} */ part) => showPart(row, part) };
}

/** @param {Element | undefined} row made by `meter` @param {number} part −1 to 1 */
function showPart(row, part) {
  const [bar, figure] = [row?.querySelector(".pad-bar"), row?.querySelector(".pad-figure")];
  if (!(bar instanceof HTMLElement) || !figure) return;
  const shown = Math.min(1, Math.max(-1, Number.isFinite(part) ? part : 0));
  bar.style.setProperty("--part", shown.toFixed(3));
  mark(bar, "aria-valuenow", String(Math.round(shown * 100)));
  write(figure, `${fixed(shown * 100, 0)} %`);
}

/** @param {string} title @param {{least: number, most: number}} bounds */
function slider(title, { least, most }) {
  const input = make("input", { type: "range", min: String(least), max: String(most), step: "0.01" });
  const figure = make("span.pad-figure");
  /** @param {number} value */
  const set = (value) => {
    if (Number(input.value) !== value) input.value = String(value);
    write(figure, `${fixed(value * 100, 0)} %`);
  };
  return { row: make("label.pad-meter", make("span", title), input, figure), input, set };
}

customElements.define("gamepad-sheet", GamepadSheet);
