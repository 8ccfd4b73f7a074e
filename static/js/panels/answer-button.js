// Element <answer-button>: switch for spoken answers in this browser; off by default.

import { onlyWatched } from "../drive/permission.js";
import { icon, make, mark, redraw } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { SpeechOutput } from "../voice/speech-output.js";
import { accepted, answer, ended, refused, saidAtStops } from "../voice/spoken-answers.js";

/** @import { View } from "../net/session.js" */

const MOST_ENTRIES = 20; // commands of this page whose end is awaited

class AnswerButton extends Panel {
  #icon = icon("silent");
  #button = make("button.button.answers", { "aria-pressed": "false" }, this.#icon, t("answer-button.answers_aloud"));
  #speech = new SpeechOutput();
  #on = remembered("answers", "off") === "on";
  /** @type {number | null} newest row of the history; null until it was read, so that old rows are not answered */
  #known = null;
  /** @type {Set<number>} running commands of this page */
  #entries = new Set();
  #notice = Infinity; // id of the newest notice that was seen; the first ones are not said
  #pending_command = 0; // id of the newest pending command
  #confirmed = ""; // its words, spoken when it was understood and not again when it begins

  /** @override */
  build() {
    this.append(this.#button);
    this.#button.addEventListener("click", () => this.#turn(!this.#on));
    this.#speech.changed = (speaking) => {
      mark(this.#button, "data-state", speaking ? "on" : null);
      this.session.tell("speaking", speaking);
    };
    this.#speech.failed = (why) => {
      this.#turn(false);
      this.session.complain(why);
    };
    this.session.on("said", ({ answer: reply }) => {
      if (reply.ok) this.#await(reply.id);
      this.#say(reply.ok ? accepted(reply.detail ?? "") : refused(reply.detail ?? ""));
    });
    this.session.on("transcript", (transcript) => {
      if (transcript.accepted) this.#await(transcript.entry);
      if (typeof transcript.pending_command === "number") this.#confirmed = transcript.heard_as;
      this.#say(answer(transcript));
    });
    this.session.on("history", (rows) => {
      for (const row of rows.filter(({ id }) => this.#known !== null && id > this.#known)) this.#answerSpoken(row);
      this.#known = Math.max(this.#known ?? 0, rows[0]?.id ?? 0);
      for (const row of rows) if (row.state !== "running" && this.#entries.delete(row.id)) this.#say(ended(row));
    });
    this.session.on("interrupt", () => this.#speech.hush());
    this.session.on("stopped", () => this.#speech.hush());
    addEventListener("pointerdown", () => this.#on && this.#speech.wake(), true);
    addEventListener("keydown", () => this.#on && this.#speech.wake(), true);
    this.#draw();
  }

  /** @override @param {View} view */
  show({ hello, state }) {
    this.hidden = onlyWatched(hello) || hello?.you.role === "viewer";
    if (!state) return;
    for (const words of saidAtStops(state.notices, this.#notice)) this.#say(words);
    this.#notice = state.notices.at(-1)?.id ?? 0;
    const pending_command = state.pending_command;
    if (!pending_command || pending_command.id === this.#pending_command) return;
    this.#pending_command = pending_command.id;
    if (pending_command.source !== "ears") return; // the transcript of this microphone is answered already
    this.#confirmed = pending_command.heard_as;
    this.#say(accepted(pending_command.heard_as));
  }

  /** @param {boolean} on */
  #turn(on) {
    this.#on = on;
    remember("answers", on ? "on" : "off");
    if (on) {
      this.#speech.wake();
      this.#say("I answer aloud now.");
    } else this.#speech.hush();
    this.#draw();
  }

  /**
   * Answer a command of a voice in the room, or a pending command that has begun.
   * @param {import("../net/rest.js").HistoryRow} row
   */
  #answerSpoken({ id, source, state, heard_as, remark }) {
    if (!heard_as) return;
    const confirmed = heard_as === this.#confirmed && (source === "ears" || source === "voice");
    if (confirmed) this.#confirmed = "";
    if (!confirmed && source !== "ears") return;
    if (state === "refused") this.#say(refused(remark));
    else if (state !== "cancelled" && state !== "pre-empted") {
      this.#await(id);
      if (!confirmed) this.#say(accepted(heard_as));
    }
  }

  /** @param {number | null | undefined} entry */
  #await(entry) {
    if (typeof entry !== "number") return;
    this.#entries.add(entry);
    if (this.#entries.size > MOST_ENTRIES) this.#entries.delete(Math.min(...this.#entries));
  }

  /** @param {string} text */
  #say(text) {
    if (this.#on && !this.hidden) this.#speech.say(text);
  }

  #draw() {
    const says = this.#on
      ? t("answer-button.answers_aloud_on_press_to_silence")
      : t("answer-button.answers_aloud_off_press_to_hear");
    redraw(this.#icon, this.#on ? "aloud" : "silent");
    mark(this.#button, "aria-pressed", String(this.#on));
    this.#button.title = says;
  }
}

customElements.define("answer-button", AnswerButton);
