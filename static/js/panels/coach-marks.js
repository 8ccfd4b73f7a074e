// Element <coach-marks>: first hints, shown once and only on the simulator; each notices when it was followed.

import { isPressed } from "../net/api.js";
import { icon, isNew, make, mark, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { apart, placed } from "../ui/placement.js";
import { t } from "../ui/texts.js";

/** @import { HistoryRow } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */
/**
 * @typedef {object} Hint
 * @property {string} at selector of its target
 * @property {string} title
 * @property {string} text
 * @property {(view: View) => boolean} [done]
 * @property {(row: HistoryRow) => boolean} [ended] a command that has ended since it was shown
 * @property {boolean} [optional] left out where its target is not on the page
 * @property {string} [opens] view or tab that shows its target
 */

const SEEN = "seen";
const ENDED = ["done", "cancelled"]; // what was pressed was understood
const UNDER_WAY = ["driving", "waiting", "paused"]; // of a route
const SAID = "notice-toasts > .toast, banner-stack > .banner:not([hidden])"; // with a card, they cover a phone's map
const EDGE = 12; // [px] from the map's upper edge
const LEAVES_MS = 6000; // of the last card
const DESK_PX = 1024; // from which the map has room beside the card
const PHONE_PX = 700; // below which one view is shown at a time
const POINTS = 20; // [px] up to which a hint points to its target; farther away something lies in between
const touch = matchMedia("(pointer: coarse)").matches;

/** @type {readonly Hint[]} */
const HINTS = [
  {
    at: '[data-command="turn_left"]',
    title: t("coach-marks.turn_the_robot"),
    text: t("coach-marks.press_turn_left_you_see_what"),
    ended: ({ name, state }) => name.startsWith("turn_") && ENDED.includes(state),
  },
  {
    at: ".stick",
    title: t("coach-marks.hold_to_drive"),
    text: touch ? t("coach-marks.push_the_stick_with_your_thumb") : t("coach-marks.hold_w_or_drag_the_stick"),
    done: ({ state, mine }) => mine && state?.gate.source === "jog" && Math.abs(state.velocity.v_m_s) > 0.02,
  },
  {
    at: ".over",
    opens: "map",
    title: touch ? t("coach-marks.tap_the_floor") : t("coach-marks.click_the_floor"),
    text: t("coach-marks.the_robot_plans_a_way_there"),
    ended: ({ source, state }) => isPressed(source) && ENDED.includes(state),
  },
  {
    at: ".person-chip",
    opens: "voices",
    title: t("coach-marks.let_someone_call_you"),
    text: touch ? t("coach-marks.press_a_name_then_come_here") : t("coach-marks.press_a_name_then_come_here_2"),
    ended: ({ name, state }) => name === "come_here" && state === "done",
    optional: true,
  },
  {
    at: ".stop",
    opens: "map",
    title: t("coach-marks.stop_at_any_time"),
    text: touch
      ? t("coach-marks.press_stop_everything_is_cancelled_and")
      : t("coach-marks.press_stop_or_esc_anywhere_everything"), // ends with the "stopped" event
  },
];

const fitting = () => HINTS.filter(({ at, optional }) => !optional || document.querySelector(at));

export class CoachMarks extends Panel {
  #step = -1;
  /** @type {readonly Hint[]} */
  #hints = HINTS;
  #title = make("h2.card-title");
  #text = make("p");
  #count = make("span.note");
  #next = make("button.button.coach-next", { onclick: () => this.#go(this.#step + 1) }, t("coach-marks.skip"));
  #tour = make("button.button.coach-tour", t("coach-marks.watch_the_tour"));
  #shut = make("button.icon-button.small", { "aria-label": t("coach-marks.close_the_hints") }, icon("close"));
  #card = make(
    "div.coach.card",
    { role: "region", "aria-label": t("coach-marks.first_steps"), hidden: true },
    make("div.coach-head", this.#title, make("span.spring"), this.#shut),
    this.#text,
    make("div.coach-foot", this.#count, make("span.spring"), this.#tour, this.#next),
    make("span.coach-tip"),
  );
  #asked = false;
  /** @type {Set<Hint>} what was done already, in whatever order */
  #met = new Set();
  /** @type {Set<number>} commands that had ended when the hint was shown */
  #old = new Set();
  #leaving = 0; // timer

  /** @override */
  build() {
    this.append(this.#card);
    this.#tour.addEventListener("click", () => {
      this.#end();
      dispatchEvent(new CustomEvent("show-tour"));
    });
    this.#shut.addEventListener("click", () => this.#end());
    this.session.on("stopped", () => this.#step === this.#hints.length - 1 && this.#go(this.#hints.length));
    let known = this.session.historyAt > 0;
    this.session.on("history", (rows) => {
      if (!known) {
        known = true; // what had ended before this page was opened
        this.#remember();
        return;
      }
      for (const hint of HINTS)
        if (hint.ended && rows.some((row) => !this.#old.has(row.id) && hint.ended?.(row))) this.#meet(hint);
    });
  }

  /** @param {number} [step] to begin with */
  begin(step = 0) {
    this.#asked = true;
    this.#met.clear();
    this.#go(Math.max(step, 0));
  }

  /** @override @param {View} view */
  show(view) {
    const { hello, state, permission, up } = view;
    const left = remembered("hints", "0"); // index of the hint that a visit before this one was left at, or "seen"
    const first = !this.#asked && left !== SEEN;
    if (
      first &&
      up &&
      hello?.robot.capabilities.includes("simulate") &&
      permission.may !== "no" &&
      state &&
      !state.slam.looking_around &&
      !state.command
    )
      this.begin(fitting().findIndex((hint) => HINTS.indexOf(hint) >= Number(left)));
    for (const one of HINTS) if (one.done?.(view)) this.#meet(one);
    const hint = this.#hints[this.#step];
    if (hint && fitting().length > this.#hints.length) this.#go(fitting().indexOf(hint)); // people came in
    this.#tour.hidden = this.#step > 0 || document.querySelector(".person-chip") === null;
    if (!this.#card.hidden) this.#place();
    // Do not cover a pending command, a zone being drawn or what was opened, and their buttons, nor a robot that obeys, nor
    // on a phone the lists of Details, unless the hint is about them; no hints while another operator drives.
    const lists = innerWidth < PHONE_PX && document.querySelector('[data-view="details"]');
    const busy =
      state?.pending_command ||
      state?.command?.state === "running" ||
      UNDER_WAY.includes(state?.route?.state ?? "") ||
      document.querySelector(".flat-mode-bar:not([hidden]), .popover:not([hidden])") ||
      (innerWidth < PHONE_PX && document.querySelector(SAID)) ||
      (lists && this.#hints[this.#step]?.opens !== "voices");
    const waits = Boolean(busy) || permission.may === "no";
    this.#card.style.visibility = waits ? "hidden" : "";
    mark(document.body, "data-hint-waits", waits);
  }

  #remember() {
    this.#old = new Set(this.session.history.filter(({ state }) => state !== "running").map(({ id }) => id));
  }

  /** @param {Hint} hint that was followed */
  #meet(hint) {
    this.#met.add(hint);
    if (this.#hints[this.#step] === hint) this.#go(this.#step + 1);
  }

  /** @param {number} step */
  #go(step) {
    this.#hints = fitting();
    for (let hint = this.#hints[step]; hint && this.#met.has(hint); hint = this.#hints[step]) step += 1;
    this.#step = step;
    this.#remember();
    const hint = this.#hints[step];
    this.#point(hint);
    clearTimeout(this.#leaving);
    if (step > this.#hints.length) {
      this.#end();
      return;
    }
    if (hint) remember("hints", String(HINTS.indexOf(hint)));
    else this.#leaving = setTimeout(() => this.#end(), LEAVES_MS);
    this.#card.hidden = false;
    this.#card.dataset["step"] = String(step + 1);
    write(this.#title, hint?.title ?? t("coach-marks.that_is_all"));
    write(
      this.#text,
      hint?.text ??
        (touch ? t("coach-marks.the_menu_shows_these_hints_again") : t("coach-marks.press_for_every_key_the_menu")),
    );
    write(this.#count, hint ? t("coach-marks.step_of_length", { step: step + 1, length: this.#hints.length }) : "");
    write(this.#next, hint ? t("coach-marks.skip") : t("coach-marks.done"));
    this.session.announce(`${this.#title.textContent}. ${this.#text.textContent}`);
  }

  /** @param {Hint | undefined} hint whose target is shown and framed; the last card has none */
  #point(hint) {
    for (const pointed of document.querySelectorAll(".is-hinted")) pointed.classList.remove("is-hinted");
    if (!hint) return;
    if (hint.opens) dispatchEvent(new CustomEvent("open-view", { detail: hint.opens }));
    if (hint.at !== ".over") document.querySelector(hint.at)?.classList.add("is-hinted");
  }

  #end() {
    this.#point(undefined);
    this.#step = -1;
    this.#card.hidden = true;
    remember("hints", SEEN);
  }

  #place() {
    const named = /** @type {HTMLElement | null} */ (document.querySelector(this.#hints[this.#step]?.at ?? ".over"));
    const at = named?.getClientRects().length ? named : document.querySelector(".over");
    const stop = document.querySelector(".stop");
    if (!at || !stop) return;
    const target = at.getBoundingClientRect();
    const now = document.querySelector(".now")?.getBoundingClientRect() ?? target; // status and notices
    if (!isNew(this, this.#step, target.left, target.top, target.width, now.top, innerWidth, innerHeight)) return;
    const inMap = at.classList.contains("over");
    const { width, height } = this.#card.getBoundingClientRect();
    const space = { width: innerWidth, height: innerHeight };
    const { left: from, right: to, bottom } = target;
    const free = { left: from, right: to, bottom, top: Math.min(target.top, now.top) };
    const rail = document.querySelector(".pages:not(.popover)")?.getBoundingClientRect();
    const deck = document.querySelector(".deck")?.getBoundingClientRect();
    const rather = [now, ...(rail?.height ? [rail] : []), ...(deck ? [deck] : [])];
    const beside = placed(free, { width, height }, space, stop.getBoundingClientRect(), rather);
    const over = document.querySelector(".over")?.getBoundingClientRect() ?? target;
    const points = apart({ ...beside, right: beside.left + width, bottom: beside.top + height }, target) < POINTS;
    const corner = { left: over.left + EDGE, top: now.top - height - EDGE, side: "" }; // of the map, where it is emptiest
    const inside = inMap
      ? { left: (target.left + target.right - width) / 2, top: target.top + EDGE, side: "" }
      : corner;
    const { left, top, side } = !inMap && (points || innerWidth < DESK_PX) ? beside : inside;
    this.#card.style.left = `${left}px`;
    this.#card.style.top = `${top}px`;
    const between = apart(this.#card.getBoundingClientRect(), target);
    this.#card.dataset["side"] = between > 0 && between < POINTS ? side : "";
    const along =
      side === "above" || side === "below"
        ? (target.left + target.right) / 2 - left
        : (target.top + target.bottom) / 2 - top;
    this.#card.style.setProperty("--tip", `${along}px`);
  }
}

customElements.define("coach-marks", CoachMarks);
