// Whether the robot answers aloud in this browser: off until somebody wants it.

import { icon, make, mark, redraw } from "../element.js";
import { accepted, answer, ended, refused } from "../hear/answers.js";
import { Mouth } from "../hear/mouth.js";
import { remember, remembered } from "../memory.js";
import { Panel } from "../panel.js";

/** @typedef {import("../session.js").View} View */

const MOST_DEEDS = 20; // of ours whose end is waited for

class AnswerButton extends Panel {
  #icon = icon("silent");
  #button = make("button", { type: "button", class: "button answers", "aria-pressed": "false" }, this.#icon);
  #mouth = new Mouth();
  #on = remembered("answers", "off") === "on";
  /** @type {number | null} the newest row of the history; null before it was read: old news is not answered */
  #known = null;
  /** @type {Set<number>} deeds of this page that are under way */
  #deeds = new Set();
  #intent = 0; // the newest order that waited
  #foretold = ""; // its words, which were said when it was understood: they are not said again when it begins

  /** @override */
  build() {
    this.append(this.#button);
    this.#button.addEventListener("click", () => this.#turn(!this.#on));
    this.#mouth.changed = (speaking) => {
      mark(this.#button, "data-state", speaking ? "on" : null);
      this.session.speaks(speaking);
    };
    this.#mouth.failed = (why) => {
      this.#turn(false);
      this.session.complain(why);
    };
    this.session.on("said", ({ answer: told }) => {
      if (told.ok) this.#await(told.id);
      this.#say(told.ok ? accepted(told.detail ?? "") : refused(told.detail ?? ""));
    });
    this.session.on("transcript", (transcript) => {
      if (transcript.accepted) this.#await(transcript.deed);
      if (typeof transcript.intent === "number") this.#foretold = transcript.heard_as;
      this.#say(answer(transcript));
    });
    this.session.on("history", (rows) => {
      for (const row of rows.filter(({ id }) => this.#known !== null && id > this.#known)) this.#answerSpoken(row);
      this.#known = Math.max(this.#known ?? 0, rows[0]?.id ?? 0);
      for (const row of rows) if (row.state !== "running" && this.#deeds.delete(row.id)) this.#say(ended(row));
    });
    this.session.on("interrupt", () => this.#mouth.hush());
    this.session.on("stopped", () => this.#mouth.hush());
    addEventListener("pointerdown", () => this.#on && this.#mouth.wake(), true);
    addEventListener("keydown", () => this.#on && this.#mouth.wake(), true);
    this.#draw();
  }

  /**
   * @override
   * @param {View} view
   */
  show({ hello, state }) {
    this.hidden = hello?.robot.drives === false || hello?.you.role === "viewer";
    const intent = state?.intent;
    if (!intent || intent.id === this.#intent) return;
    this.#intent = intent.id;
    if (intent.source !== "ears") return; // our own microphone's transcript says it
    this.#foretold = intent.heard_as;
    this.#say(accepted(intent.heard_as));
  }

  /** @param {boolean} on */
  #turn(on) {
    this.#on = on;
    remember("answers", on ? "on" : "off");
    if (on) {
      this.#mouth.wake();
      this.#say("I answer aloud now.");
    } else this.#mouth.hush();
    this.#draw();
  }

  /**
   * A voice in the room that was understood, or an order that waited.
   * @param {import("../api.js").HistoryRow} row
   */
  #answerSpoken({ id, source, state, heard_as, remark }) {
    if (!heard_as) return;
    const foretold = heard_as === this.#foretold && (source === "ears" || source === "voice");
    if (foretold) this.#foretold = "";
    if (!foretold && source !== "ears") return;
    if (state === "refused") this.#say(refused(remark));
    else if (state !== "cancelled" && state !== "pre-empted") {
      this.#await(id);
      if (!foretold) this.#say(accepted(heard_as));
    }
  }

  /** @param {number | null | undefined} deed */
  #await(deed) {
    if (typeof deed !== "number") return;
    this.#deeds.add(deed);
    if (this.#deeds.size > MOST_DEEDS) this.#deeds.delete(Math.min(...this.#deeds));
  }

  /** @param {string} text */
  #say(text) {
    if (this.#on && !this.hidden) this.#mouth.say(text);
  }

  #draw() {
    const says = this.#on ? "Answers aloud: on. Press to silence it." : "Answers aloud: off. Press to hear the robot.";
    redraw(this.#icon, this.#on ? "aloud" : "silent");
    mark(this.#button, "aria-pressed", String(this.#on));
    mark(this.#button, "aria-label", "Answers aloud");
    this.#button.title = says;
  }
}

customElements.define("answer-button", AnswerButton);
