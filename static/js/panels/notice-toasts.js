// Element <notice-toasts>: new notices over the map; errors stay until they are dismissed.
// Element <live-region>: announcements for screen readers, one sentence at a time, without repeats.

import { icon, iconButton, make, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { unlessPressed } from "../ui/press.js";
import { speedsOffer } from "../ui/speeds-offer.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */
/** @typedef {"info" | "warning" | "error"} Level */

const STAYS_MS = { info: 6000, warning: 15000, error: Infinity };
const WORD_MS = 300; // for each of its words
const OFFER_STAYS_MS = 20000;
const MOST = 3;
const GOES = ["driving", "waiting"]; // a route that does: why it stood is over
const STANDS = "paused"; // one that does: the status line says why
const SAID = ["command-status", "banner-stack"]; // where a sentence stands already

/** What became of this page's asking for control, by the notice's code. @type {Readonly<Record<string, string>>} */
const TO_ME = {
  "lease.no_answer": "notice-toasts.name_did_not_answer_you",
  "lease.keeps": "notice-toasts.name_keeps_control",
  "lease.gave_to": "notice-toasts.name_gave_you_control",
};

/** A notice as who is at this page reads it. @param {import("../net/messages.js").NoticeLine} notice @param {string} me */
function readBy({ text, code, values }, me) {
  const key = TO_ME[code ?? ""];
  return key && values?.["other"] === me ? t(key, values) : text;
}

class NoticeToasts extends Panel {
  #newest = -1;
  #first = true;
  /** @type {Map<number, HTMLElement>} of notices that are shown, by their number */
  #shown = new Map();

  /** @override */
  build() {
    this.session.on("trouble", (sentence) => this.#raise("warning", sentence));
    this.session.on("offer", (offer) => this.#offer(offer));
    this.session.on("hello", () => {
      this.#first = true;
    });
  }

  /** Show each notice once; update or remove it while it is still shown. @override @param {View} view */
  show({ hello, state, lostControl, mine }) {
    if (!state || !hello) return;
    const notices = state.notices.filter(({ cause }) => cause !== "route" || !GOES.includes(state.route?.state ?? ""));
    for (const notice of notices) {
      const { id, level, cause, code, values } = notice;
      const text = readBy(notice, hello.you.name);
      const halted = cause === "halt" && level === "warning"; // the banner says it for as long as it holds
      // Who took control over knows it, and who lost it has a banner.
      const changed = cause === "lease" && level === "warning" && (mine || lostControl !== null);
      const stands = cause === "route" && state.route?.state === STANDS;
      const fresh = id > this.#newest && !this.#first && !halted && !changed;
      if (fresh && stands) this.session.announce(text);
      else if (fresh) this.#shown.set(id, this.#raise(level, text, speedsOffer(this.session, { code, values })));
      else this.#change(id, level, text);
    }
    this.#newest = state.notices.at(-1)?.id ?? -1;
    this.#first = false;
    for (const [id, toast] of this.#shown) {
      if (!toast.isConnected) this.#shown.delete(id);
      else if (!notices.some((notice) => notice.id === id)) toast.remove(); // a newer one replaced it, or it is over
    }
    for (const toast of this.querySelectorAll(".toast:not(:has(.button))")) {
      const words = toast.textContent ?? "";
      if (SAID.some((one) => document.querySelector(one)?.textContent?.includes(words))) toast.remove();
    }
  }

  /** @param {number} id @param {Level} level @param {string} text */
  #change(id, level, text) {
    const toast = this.#shown.get(id);
    const words = toast?.querySelector("p");
    if (!toast || !words || words.textContent === text) return;
    write(words, text);
    if (toast.dataset["level"] === level) return;
    toast.dataset["level"] = level;
    redraw(toast.querySelector("svg"), drawing(level));
    leave(toast, level);
    this.session.announce(text);
  }

  /** @param {import("../net/session.js").Offer} offer */
  #offer({ text, words, event }) {
    const take = make("button.button", words);
    const toast = this.#put("info", text, take);
    take.addEventListener("click", () => {
      this.dispatchEvent(new CustomEvent(event, { bubbles: true }));
      toast.remove();
    });
    setTimeout(() => takeAway(toast), OFFER_STAYS_MS);
  }

  /**
   * @param {Level} level
   * @param {string} text
   * @param {HTMLElement | null} [offer] a button
   * @returns {HTMLElement}
   */
  #raise(level, text, offer) {
    const same = [...this.children].find((toast) => toast.textContent === text);
    if (same) return /** @type {HTMLElement} */ (same);
    const toast = this.#put(level, text, offer);
    leave(toast, level);
    return toast;
  }

  /**
   * @param {Level} level
   * @param {string} text
   * @param {HTMLElement | null} [offer] a button
   * @returns {HTMLElement}
   */
  #put(level, text, offer) {
    const away = iconButton("close", t("notice-toasts.dismiss"), () => toast.remove(), { look: "small" });
    const toast = make("div.toast", { "data-level": level }, icon(drawing(level)), make("p", text), offer, away);
    this.append(toast);
    while (this.children.length > MOST) this.firstElementChild?.remove();
    this.session.announce(text);
    return toast;
  }
}

/** @param {HTMLElement} toast leaves, though not from under a press */
const takeAway = (toast) => unlessPressed(toast, () => toast.remove());

/** @param {Level} level */
const drawing = (level) => (level === "info" ? "info" : "warning");

/** @param {HTMLElement} toast @param {Level} level */
function leave(toast, level) {
  if (STAYS_MS[level] < Infinity)
    setTimeout(
      () => toast.dataset["level"] === level && takeAway(toast),
      STAYS_MS[level] + WORD_MS * (toast.textContent ?? "").split(" ").length,
    );
}

customElements.define("notice-toasts", NoticeToasts);

const BREATH_MS = 150; // readers need a change after an empty moment to speak the same place again

class LiveRegion extends Panel {
  #place = make("div.visually-hidden", { role: "status", "aria-live": "polite" });
  /** @type {string[]} */
  #waiting = [];
  #timer = 0;

  /** @override */
  build() {
    this.append(this.#place);
    this.session.on("announcement", (sentence) => {
      if (this.#waiting.at(-1) === sentence) return;
      this.#waiting.push(sentence);
      this.#waiting.splice(0, this.#waiting.length - 4);
      this.#timer ||= setTimeout(() => {
        this.#place.textContent = this.#waiting.splice(0).join(" ");
        this.#timer = 0;
      }, BREATH_MS);
    });
  }
}

customElements.define("live-region", LiveRegion);
