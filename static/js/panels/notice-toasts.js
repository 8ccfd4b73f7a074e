// New notices pass over the map; errors stay until they are put away. All of them stay in the list of notices.

import { icon, make } from "../element.js";
import { Panel } from "../panel.js";

/** @typedef {import("../session.js").View} View */
/** @typedef {"info" | "warning" | "error"} Level */

const STAYS_MS = { info: 6000, warning: 15000, error: Infinity };
const MOST = 3;

class NoticeToasts extends Panel {
  #newest = -1;
  #first = true;

  /** @override */
  build() {
    this.session.on("trouble", (sentence) => this.#raise("warning", sentence));
    this.session.on("hello", () => {
      this.#first = true;
    });
  }

  /**
   * @override
   * @param {View} view
   */
  show({ state }) {
    if (!state) return;
    const fresh = state.notices.filter(({ id }) => id > this.#newest);
    this.#newest = state.notices.at(-1)?.id ?? -1;
    if (!this.#first) for (const { level, text } of fresh) this.#raise(level, text);
    this.#first = false;
  }

  /**
   * @param {Level} level
   * @param {string} text
   */
  #raise(level, text) {
    if (this.lastElementChild?.textContent === text) return;
    const away = make(
      "button",
      { type: "button", class: "icon-button small", "aria-label": "Put away" },
      icon("close"),
    );
    const toast = make(
      "div",
      { class: "toast", "data-level": level },
      icon(level === "info" ? "info" : "warning"),
      make("p", {}, text),
      away,
    );
    away.addEventListener("click", () => toast.remove());
    if (STAYS_MS[level] < Infinity) setTimeout(() => toast.remove(), STAYS_MS[level]);
    this.append(toast);
    while (this.children.length > MOST) this.firstElementChild?.remove();
    this.session.announce(text);
  }
}

customElements.define("notice-toasts", NoticeToasts);
