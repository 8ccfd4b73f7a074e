// Element <command-chips>: a button for each command of this robot; commands with numbers ask for them in place.

import { exampleNumbers, filled, holes } from "../drive/suggest.js";
import { icon, iconButton, make, mark, onSubmit, write } from "../ui/element.js";
import { age, inWords } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { refill } from "../ui/press.js";
import { LastVoice } from "../ui/sensed.js";
import { t } from "../ui/texts.js";

/** @import { Kind } from "../drive/suggest.js" */
/** @import { ParameterRow as NumberRow } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

/** STOP has a button of its own; what a robot that hears is for stands before what is rarely wanted. */
const ORDER = [
  "turn_left",
  "turn_right",
  "come_here",
  "continue",
  "follow_me",
  "stop_at",
  "follow_wall",
  "stop_moving",
];

const MIN_ROOM = 240; // [px] above the line of words in which all chips stand
const OVER = 12; // [px] from the line of words to all chips

class CommandChips extends Panel {
  #chips = make("div.chips", { role: "group", "aria-label": t("command-chips.commands") });
  #more = make("button.chip.more", { "aria-expanded": "false", hidden: true }, t("command-chips.more"));
  /** @type {HTMLFormElement | null} */
  #form = null;
  #voice = new LastVoice();
  #off = false;
  #up = true;

  /** @override */
  build() {
    this.append(this.#chips, this.#more);
    this.session.on("kinds", (kinds) => {
      this.#back(false);
      const given = kinds.filter(({ name }) => name !== "start").sort((one, other) => place(one) - place(other));
      refill(this.#chips, ...given.map((kind) => this.#chip(kind)));
      this.#able();
      this.#fit();
    });
    new ResizeObserver(() => this.#fit()).observe(this);
    this.#more.addEventListener("click", () => this.#spread(!this.hasAttribute("data-spread")));
    this.#chips.addEventListener("click", () => this.#spread(false));
    addEventListener("pointerdown", ({ target }) => this.contains(/** @type {Node} */ (target)) || this.#spread(false));
    this.addEventListener("keydown", (event) => event.key === "Escape" && this.#spread(false));
  }

  /** Show all chips, or those that have room. @param {boolean} all */
  #spread(all) {
    if (all === this.hasAttribute("data-spread")) return;
    const line = document.querySelector("command-line");
    const { top } = this.getBoundingClientRect();
    const words = Math.min(top, line?.getBoundingClientRect().top ?? top);
    const down = words < MIN_ROOM;
    this.style.setProperty("--above", `${top - words + OVER}px`); // over the map, so that one can still type
    this.style.setProperty("--room", `${down ? innerHeight - top : words - 2 * OVER}px`);
    mark(this, "data-spread", all && (down ? "down" : "up"));
    mark(this.#more, "aria-expanded", String(all));
    write(this.#more, all ? t("command-chips.fewer") : t("command-chips.more"));
    this.#fit();
    const over = /** @type {HTMLElement | null} */ (this.#chips.querySelector("[data-over]"));
    if (all) over?.focus();
  }

  /** Hide what has no room, a chip's note before the chip; *more* shows it. */
  #fit() {
    const chips = /** @type {HTMLElement[]} */ ([...this.#chips.children]);
    if (this.hasAttribute("data-spread")) return;
    this.#more.hidden = false;
    for (const tight of [false, true]) {
      mark(this, "data-tight", tight);
      const low = this.#chips.getBoundingClientRect().bottom + 1;
      for (const chip of chips) mark(chip, "data-over", chip.getBoundingClientRect().bottom > low);
      if (!this.#chips.querySelector("[data-over] .chip-note")) break;
    }
    this.#more.hidden = !chips.some((chip) => chip.hasAttribute("data-over"));
  }

  /** @override @param {View} view */
  show({ up, permission, state }) {
    this.#tellVoice(state);
    const off = !up || permission.may === "no";
    if (off === this.#off && up === this.#up) return;
    [this.#off, this.#up] = [off, up];
    this.#able();
  }

  /**
   * On the chip "come here": whether the robot knows where that is.
   * @param {import("../net/messages.js").State | null} state
   */
  #tellVoice(state) {
    const chip = this.#chips.querySelector('[data-command="come_here"]');
    if (!chip || !state?.ears) return;
    const voice = this.#voice.saw(state);
    const since = this.#voice.age(state.stamp_s);
    const says = voice
      ? t("command-chips.voice_age_s_ago_inwords", { age: Math.round(voice.age), inwords: inWords(voice.azimuth) })
      : since === null
        ? t("command-chips.heard_nobody_yet")
        : t("command-chips.last_voice_age_ago", { age: age(since) });
    const note = chip.querySelector(".chip-note") ?? chip.lastElementChild?.appendChild(make("span.note.chip-note"));
    if (!note || note.textContent === says) return;
    write(note, says);
    this.#fit();
  }

  #able() {
    for (const button of this.#chips.querySelectorAll("button")) {
      button.disabled = button.dataset["command"] === "stop_moving" ? !this.#up : this.#off; // anyone may stop the robot
    }
  }

  /** @param {Kind} kind */
  #chip(kind) {
    const pattern = kind.words[0] ?? kind.name;
    const asks = holes(pattern, kind).length > 0;
    const label = asks ? `${pattern.split(" {")[0]}…` : pattern;
    const chip = make(
      "button.chip",
      { title: kind.summary, "data-command": kind.name },
      icon(kind.icon || "command"),
      make("span.chip-words", make("span", label)),
    );
    chip.addEventListener("click", () => (asks ? this.#ask(kind, pattern) : void this.session.say(pattern, "chip")));
    return chip;
  }

  /** @param {Kind} kind @param {string} pattern */
  #ask(kind, pattern) {
    const usual = exampleNumbers(kind);
    const wanted = holes(pattern, kind);
    const says = make("span.form-says", { role: "alert" });
    /** @type {Map<string, HTMLInputElement>} */
    const boxes = new Map();
    for (const number of wanted) {
      const value = usual[number.name] ?? number.default ?? "";
      boxes.set(
        number.name,
        make("input.number", {
          type: "text",
          inputmode: number.low < 0 ? "text" : "decimal",
          size: "5",
          autocomplete: "off",
          value: String(value),
          "aria-label": t("command-chips.says_low_to_high_unit", {
            says: number.says,
            low: number.low,
            high: number.high,
            unit: number.unit,
          }),
        }),
      );
    }
    const parts = pattern
      .split(/(\{\w+\})/)
      .filter((part) => part.trim())
      .map((part) => {
        const box = boxes.get(part.slice(1, -1));
        return box ?? make("span", part.trim());
      });
    const unit = /met(er|re)s/.test(pattern) ? null : make("span.note", wanted[0]?.unit ?? "");
    const back = iconButton("close", t("command-chips.back_to_the_commands"), () => this.#back(true));
    const form = make(
      "form.chip-form",
      { "aria-label": kind.summary, novalidate: true },
      icon(kind.icon || "command"),
      ...parts,
      unit,
      make("button.button.primary", { type: "submit" }, t("command-chips.go")),
      back,
      says,
    );
    form.addEventListener("keydown", (event) => event.key === "Escape" && this.#back(true));
    onSubmit(form, () => {
      const numbers = checked(wanted, boxes, says);
      if (!numbers || this.#off) return;
      void this.session.say(filled(pattern, numbers), "chip");
      this.#back(true);
    });
    this.#form = form;
    this.dataset["asks"] = kind.name;
    this.#chips.hidden = this.#more.hidden = true;
    this.append(form);
    const first = boxes.values().next().value;
    first?.focus();
    first?.select();
  }

  /** @param {boolean} focus */
  #back(focus) {
    const asked = this.dataset["asks"];
    this.#form?.remove();
    this.#form = null;
    delete this.dataset["asks"];
    this.#chips.hidden = false;
    this.#fit();
    if (!focus || !asked) return;
    const chip = this.#chips.querySelector(/** @type {"button"} */ (`[data-command="${CSS.escape(asked)}"]`));
    (chip?.hasAttribute("data-over") ? this.#more : chip)?.focus();
  }
}

/** @param {Kind} kind */
const place = ({ name }) => (ORDER.includes(name) ? ORDER.indexOf(name) : ORDER.length);

/**
 * Read the numbers in the boxes. Null when one is wrong: shows a sentence and moves the focus there.
 * @param {readonly NumberRow[]} wanted
 * @param {ReadonlyMap<string, HTMLInputElement>} boxes
 * @param {Element} says
 */
function checked(wanted, boxes, says) {
  /** @type {Record<string, string>} */
  const numbers = {};
  for (const { name, says: called, low, high, unit } of wanted) {
    const box = boxes.get(name);
    const text = (box?.value ?? "").trim().replace(",", ".").replace("−", "-");
    const value = text === "" ? NaN : Number(text);
    const fine = value >= low && value <= high;
    if (box) mark(box, "aria-invalid", fine ? null : "true");
    if (!fine) {
      write(says, t("command-chips.called_must_be_a_number_from", { called, low, high, unit }));
      box?.focus();
      return null;
    }
    numbers[name] = text;
  }
  return numbers;
}

customElements.define("command-chips", CommandChips);
