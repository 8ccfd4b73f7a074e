// Element <settings-sheet>: the common settings, from their declarations; each is saved by itself.

import { call, sentenceOf as reasonOf, send } from "../net/api.js";
import { make, mark, write } from "../ui/element.js";
import { Sheet } from "../ui/sheet.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { SettingState as Setting } from "../net/rest.js" */
/** @typedef {boolean | number | string} Value */
/** @typedef {{row: HTMLElement, input: HTMLInputElement | HTMLSelectElement, says: HTMLElement, back: HTMLButtonElement}} Field */

/** What a section is called here, in this order; the file calls it by its own name. @type {Readonly<Record<string, string>>} */
const SECTIONS = {
  person_following: t("settings-sheet.coming_and_following"),
  wall: t("settings-sheet.walls"),
  steering: t("settings-sheet.steering"),
  voice: t("settings-sheet.robot_s_voice"),
  limits: t("settings-sheet.limits_of_the_gate"),
  planner: t("settings-sheet.ways"),
  speech: t("settings-sheet.speech"),
  people: t("settings-sheet.people"),
  occupancy: t("settings-sheet.map"),
  recording: t("pages.recordings"),
  simulation: t("settings-sheet.simulated_robot"),
  time_offset: t("settings-sheet.clocks"),
  image_quality: t("settings-sheet.pictures"),
  chapter: t("settings-sheet.chapter"),
};

export class SettingsSheet extends Sheet {
  #file = make("p.note.settings-file");
  #restart = make("p.settings-restart", { role: "status", hidden: true });
  #list = make("div.settings-list");
  /** @type {Map<string, Field>} */
  #fields = new Map();

  /** @override */
  build() {
    this.frame(t("settings-sheet.settings"), this.#file, this.#restart, this.#list);
  }

  /** @override */
  toggle() {
    super.toggle();
    if (!this.hidden) void this.session.attempt(() => this.#read());
  }

  get #may() {
    return this.session.hello !== null && this.session.hello.you.role !== "viewer";
  }

  async #read() {
    const { file, restart, settings } = await call("api/settings");
    write(
      this.#file,
      this.#may
        ? t("settings-sheet.saved_in_file_one_by_one", { file })
        : t("settings-sheet.you_are_watching_only_an_operator"),
    );
    this.#warn(restart);
    if (this.#fields.size === 0) this.#build(settings);
    for (const one of settings) this.#show(one);
  }

  /** @param {boolean} restart */
  #warn(restart) {
    this.#restart.hidden = !restart;
    write(this.#restart, restart ? t("settings-sheet.something_saved_waits_for_the_next") : "");
  }

  /** @param {Setting[]} settings */
  #build(settings) {
    const sections = new Set([...Object.keys(SECTIONS), ...settings.map(({ section }) => section)]);
    for (const section of sections) {
      const rows = settings.filter((one) => one.section === section).map((one) => this.#row(one));
      if (rows.length === 0) continue;
      const name = SECTIONS[section] ?? section;
      this.#list.append(make("fieldset.settings-section", make("legend", name), ...rows));
    }
  }

  /** @param {Setting} one */
  #row(one) {
    const id = `setting-${one.section}-${one.name}`;
    const input = inputOf(one, id);
    const says = make("span.settings-says.note", { id: `${id}-says` });
    const back = make(
      "button.button.plain",
      { hidden: true, onclick: () => void this.#change(one, null) },
      t("settings-sheet.back_to_inwords", { inwords: inWords(one, one.default) }),
    );
    input.setAttribute("aria-describedby", says.id);
    input.disabled = !this.#may;
    const row = make(
      "div.settings-row",
      make("label", { for: id }, nameOf(one), !one.live && make("span.settings-later", t("settings-sheet.restart"))),
      make("span.settings-value", input, make("span.note", one.unit)),
      says,
      back,
    );
    input.addEventListener("change", () => void this.#change(one, chosenIn(one, input)));
    this.#fields.set(key(one), { row, input, says, back });
    return row;
  }

  /** @param {Setting} one @param {Value | null} value */
  async #change(one, value) {
    const field = this.#fields.get(key(one));
    if (!field) return;
    if (Number.isNaN(value)) {
      say(field, t("settings-sheet.type_a_number"), true);
      return;
    }
    const outside = outsideOf(one, value);
    if (outside) {
      say(field, outside, true);
      this.session.announce(outside);
      return;
    }
    try {
      const { setting } = await send(`api/settings/${one.section}/${one.name}`, "PUT", { value });
      const sentence = changedTo(setting);
      this.#show(setting);
      say(field, sentence, false);
      this.session.announce(sentence);
      this.#warn((await call("api/settings")).restart);
    } catch (refusal) {
      const sentence = reasonOf(refusal);
      say(field, sentence, true);
      this.session.announce(sentence);
    }
  }

  /** @param {Setting} one */
  #show(one) {
    const field = this.#fields.get(key(one));
    if (!field) return;
    const { input, back } = field;
    if (input instanceof HTMLInputElement && input.type === "checkbox") input.checked = one.saved === true;
    else input.value = String(one.saved);
    back.hidden = !this.#may || one.saved === one.default;
    const waits =
      one.saved !== one.value
        ? t("settings-sheet.now_inwords_from_the_next_start", {
            inwords: inWords(one, one.value),
            inwords2: inWords(one, one.saved),
          })
        : "";
    const watch = t("settings-sheet.watch", { watch: inLanguage(one.watch) });
    say(field, `${bounds(one)}${sentenceOf(inLanguage(one.meaning))} ${watch}${waits}`, false);
  }
}

/** @param {Setting} one */
const key = ({ section, name }) => `${section}.${name}`;

/** @param {Setting} one */
const nameOf = ({ section, name }) => t(`setting.${section}.${name}`);

/** @param {string} meaning */
const sentenceOf = (meaning) => `${meaning.charAt(0).toUpperCase()}${meaning.slice(1)}.`;

/** @param {Setting} one */
const bounds = ({ low, high, unit }) => (low === null || high === null ? "" : `${low}–${high}${unit && ` ${unit}`}. `);

/** Why the console would refuse a number; "" where it does not. @param {Setting} one @param {Value | null} value */
function outsideOf(one, value) {
  const { low, high } = one;
  if (typeof value !== "number" || low === null || high === null || (value >= low && value <= high)) return "";
  return t("settings-sheet.must_lie_between", { name: nameOf(one), low, high: inWords(one, high), value });
}

/** @param {Setting} one after its change */
const changedTo = (one) =>
  t(one.live ? "settings-sheet.is_now" : "settings-sheet.saved_from_the_next_start", {
    name: nameOf(one),
    value: inWords(one, one.saved),
  });

/** @param {Setting} one @param {Value} value */
function inWords(one, value) {
  if (typeof value === "boolean") return t(value ? "settings-sheet.on" : "settings-sheet.off");
  if (typeof value === "number") return `${value}${one.unit && ` ${one.unit}`}`;
  const name = `setting.${one.section}.${one.name}.${value}`; // voices and programs have their names in every language
  return t(name) === name ? String(value) : t(name);
}

/** @param {Field} field @param {string} sentence @param {boolean} refused */
function say({ input, says }, sentence, refused) {
  write(says, sentence);
  mark(says, "data-refused", refused);
  mark(input, "aria-invalid", refused ? "true" : null);
}

/** @param {Setting} one @param {string} id */
function inputOf(one, id) {
  if (one.choices.length)
    return make(
      "select.field-box",
      { id },
      ...one.choices.map((choice) => make("option", { value: choice }, inWords(one, choice))),
    );
  if (one.kind === "switch") return make("input.switch", { id, type: "checkbox", role: "switch" });
  return make("input.field-box", { id, type: "number", step: one.kind === "whole" ? "1" : "any" });
}

/** @param {Setting} one @param {HTMLInputElement | HTMLSelectElement} input @returns {Value} */
function chosenIn(one, input) {
  if (one.kind === "switch") return /** @type {HTMLInputElement} */ (input).checked;
  return one.choices.length ? input.value : /** @type {HTMLInputElement} */ (input).valueAsNumber;
}

customElements.define("settings-sheet", SettingsSheet);
