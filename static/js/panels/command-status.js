// One line that says what is being obeyed, or how the last command ended, or why it was refused.

import { wordsOf } from "../api.js";
import { icon, make, mark, redraw, write } from "../element.js";
import { Panel } from "../panel.js";

/** @typedef {import("../session.js").View} View */
/** @typedef {import("../session.js").Said} Said */
/** @typedef {import("../api.js").HistoryRow} HistoryRow */
/** @typedef {import("../hear/talk.js").Transcript} Transcript */
/**
 * @typedef {object} Shown
 * @property {string} icon
 * @property {string} words
 * @property {string} remark
 * @property {string} state
 * @property {readonly string[]} meant
 * @property {boolean} [room] a voice in the room said it
 */

const POINT = matchMedia("(pointer: coarse)").matches ? "tap" : "click";
/** @type {Shown} */
const READY = {
  icon: "command",
  words: "Ready",
  remark: `Type, press a button below, or ${POINT} the floor.`,
  state: "",
  meant: [],
};

class CommandStatus extends Panel {
  #icon = icon("command");
  #words = make("span", { class: "status-words" });
  #remark = make("span", { class: "status-remark" });
  #meant = make("div", { class: "meant", role: "group", "aria-label": "Did you mean" });
  #bar = make("div", { class: "bar-fill" });
  #progress = make(
    "div",
    {
      class: "progress",
      role: "progressbar",
      "aria-label": "Progress",
      "aria-valuemin": "0",
      "aria-valuemax": "100",
    },
    this.#bar,
  );
  #cancel = make("button", { type: "button", class: "button" }, icon("close"), "Cancel");
  #running = 0;
  /** @type {number | null} the newest row when the page was opened: old news */
  #known = null;
  /** @type {Shown} */
  #last = READY;
  /** @type {Shown} the newest refusal that came as an answer: the history tells of it too, but not what was meant */
  #refusal = READY;

  /** @override */
  build() {
    this.append(
      this.#icon,
      make("p", { class: "status-text" }, this.#words, this.#remark),
      this.#meant,
      this.#progress,
      this.#cancel,
    );
    this.#cancel.addEventListener("click", () => this.session.stop());
    this.session.on("said", (said) => this.#answered(said));
    this.session.on("transcript", (transcript) => this.#heard(transcript));
    this.session.on("history", (rows) => this.#ended(rows));
  }

  /**
   * @override
   * @param {View} view
   */
  show({ state, up, permission }) {
    const command = state?.command?.state === "running" ? state.command : null;
    this.#cancel.hidden = !command;
    this.#progress.hidden = !command || command.progress === null;
    this.#cancel.disabled = !up;
    if (command) {
      this.#running = command.id;
      const { heard_as: words, remark } = command;
      this.#show({ icon: "running", words, remark, state: "running", meant: [] });
      const percent = Math.round((command.progress ?? 0) * 100);
      this.#bar.style.width = `${percent}%`;
      mark(this.#progress, "aria-valuenow", String(percent));
      return;
    }
    if (this.#running) {
      this.#running = 0;
      if (this.#last.state === "sent") this.#last = READY;
    }
    const idle =
      this.#last === READY && permission.may === "no" ? { ...READY, words: "", remark: permission.why } : this.#last;
    const offered = state?.ears?.meant;
    this.#show(idle.room && offered ? { ...idle, meant: [offered] } : idle);
  }

  /** @param {Transcript} transcript what our own microphone heard; if it was refused, what may have been meant */
  #heard({ final, accepted, words, reason, suggestions }) {
    if (!final || !words) return;
    if (accepted) this.#refusal = READY;
    else this.#refuse(words, reason, suggestions);
  }

  /** @param {Said} said */
  #answered({ text, answer }) {
    if (answer.ok) {
      this.#refusal = READY;
      this.#last = { icon: "running", words: text, remark: "", state: "sent", meant: [] };
      return;
    }
    const remark = answer.detail ?? "";
    this.#refuse(text, remark, answer.suggestions ?? []);
    this.session.announce(`${text}: refused. ${remark}`);
  }

  /**
   * @param {string} words
   * @param {string} remark why
   * @param {readonly string[]} meant what would have been understood
   */
  #refuse(words, remark, meant) {
    this.#last = this.#refusal = { icon: "refused", words, remark, state: "refused", meant };
  }

  /** @param {HistoryRow[]} rows newest first; they may come late, after the answer to what was said since */
  #ended([row]) {
    this.#known ??= row?.id ?? 0;
    if (!row || row.id <= this.#known || row.state === "running") return;
    const refused = row.state === "refused";
    const room = refused && row.source === "ears";
    const same = refused && !room && row.words === this.#refusal.words;
    const remark = row.remark || (same ? this.#refusal.remark : "");
    const meant = same ? this.#refusal.meant : [];
    this.#last = { icon: row.state, words: wordsOf(row), remark, state: row.state, meant, room };
    this.session.announce(`${wordsOf(row)}: ${row.state}. ${remark}`);
  }

  /** @param {Shown} shown */
  #show(shown) {
    redraw(this.#icon, shown.icon);
    write(this.#words, shown.words);
    const said =
      shown.state && shown.state !== "running" && shown.state !== "sent"
        ? `${shown.state}${shown.remark ? ". " : ""}`
        : "";
    write(this.#remark, said + shown.remark);
    mark(this, "data-state", shown.state || null);
    const meant = shown.meant.slice(0, 3);
    this.#meant.hidden = meant.length === 0;
    if (this.#meant.dataset["meant"] === meant.join("|")) return;
    this.#meant.dataset["meant"] = meant.join("|");
    this.#meant.replaceChildren(
      make("span", { class: "note" }, "Did you mean"),
      ...meant.map((text) => this.#offer(text)),
    );
  }

  /** @param {string} text */
  #offer(text) {
    const button = make("button", { type: "button", class: "chip" }, text);
    button.addEventListener("click", () => void this.session.say(text, "chip"));
    return button;
  }
}

customElements.define("command-status", CommandStatus);
