// Requests sent over the socket that have no answer yet.

import { t } from "../ui/texts.js";

/** @import { AnswerMessage as Answer } from "./messages.js" */

const ANSWER_MS = 5000;

export class Asking {
  /** @type {Map<number, (answer: Answer) => void>} */
  #waiting = new Map();
  #ref = 0;

  /** @param {(ref: number) => boolean} send returns true when it was sent @returns {Promise<Answer>} */
  ask(send) {
    this.#ref += 1;
    const ref = this.#ref;
    /** @param {string} detail @returns {Answer} */
    const none = (detail) => ({ kind: "answer", ref, ok: false, status: 0, detail });
    return new Promise((resolve) => {
      this.#waiting.set(ref, resolve);
      if (!send(ref)) {
        this.#waiting.delete(ref);
        resolve(none(t("pending-answers.the_link_is_lost_nothing_was")));
        return;
      }
      setTimeout(() => {
        if (this.#waiting.delete(ref)) resolve(none(t("pending-answers.no_answer_came_look_at_the")));
      }, ANSWER_MS);
    });
  }

  /** @param {Answer} answer */
  hear(answer) {
    this.#waiting.get(answer.ref)?.(answer);
    this.#waiting.delete(answer.ref);
  }

  lose() {
    for (const [ref, answer] of this.#waiting)
      answer({ kind: "answer", ref, ok: false, status: 0, detail: t("pending-answers.the_link_was_lost") });
    this.#waiting.clear();
  }
}
