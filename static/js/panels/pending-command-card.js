// Element <pending-command-card>: preview of a spoken command during its confirmation delay.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { begun, certainty, countdown, facts, left, mayBegin, speaker, title } from "../ui/pending-command.js";
import { t } from "../ui/texts.js";

/** @import { PendingCommandState } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */

const SHOWN_MS = 2500; // for which a command that has begun is shown

class PendingCommandCard extends Panel {
  #icon = icon("command");
  #title = make("p.heading.pending-title");
  #facts = make("p.pending-facts");
  #when = make("span.pending-when", { role: "timer" });
  #ring = make("div.pending-ring", { "aria-hidden": "true" }, this.#icon);
  #go = make(
    "button.button.primary",
    { "aria-keyshortcuts": "Enter" },
    t("pending-command-card.go_now"),
    make("kbd", { "aria-hidden": "true" }, t("pending-command-card.enter")),
  );
  #cancel = make(
    "button.button",
    { "aria-label": t("pending-command-card.cancel_the_pending_command"), "aria-keyshortcuts": "Escape" },
    icon("close"),
    t("pending-command-card.cancel"),
    make("kbd", { "aria-hidden": "true" }, "Esc"),
  );
  #waiting = 0; // id of the pending command
  /** @type {number | null} id of the newest command that was begun; null before the first state */
  #begun = null;
  #until = 0; // [ms] that it is shown
  #heard = { heard_as: "", confidence: 0 }; // the newest transcript of this browser

  /** @override */
  build() {
    this.classList.add("card");
    this.hidden = true;
    mark(this, "role", "region");
    mark(this, "aria-label", t("pending-command-card.spoken_command"));
    this.append(
      this.#ring,
      make("div.pending-words", this.#title, this.#facts),
      make("div.inline.pending-ways", this.#when, this.#go, this.#cancel),
    );
    this.session.on("transcript", (heard) => (this.#heard = heard));
    this.#go.addEventListener("click", () =>
      this.#press(this.#go, this.session.pendingCommand("begin", this.#waiting)),
    );
    this.#cancel.addEventListener("click", () =>
      this.#press(this.#cancel, this.session.pendingCommand("drop", this.#waiting)),
    );
  }

  /** @override @param {View} view */
  show(view) {
    const { state, up } = view;
    const pending_command = (up && state?.pending_command) || null;
    const command = begun(view);
    if (state && command?.id !== this.#begun) {
      const fresh = command !== null && this.#begun !== null; // a command that ran before the page was opened is not new
      if (fresh) this.#until = performance.now() + SHOWN_MS;
      if (command || this.#begun === null) this.#begun = command?.id ?? 0;
    }
    if (pending_command && state) this.#wait(pending_command, view);
    else if (command && performance.now() < this.#until) {
      const sure = this.#heard.heard_as === command.heard_as ? `${certainty(this.#heard.confidence)} · ` : "";
      this.#draw(command.name, title(command), sure + speaker(command), "begun");
      write(this.#when, t("pending-command-card.begun"));
      this.#ring.style.setProperty("--left", "0");
    }
    this.hidden = !pending_command && !(command && performance.now() < this.#until);
    if (!pending_command) this.#waiting = 0;
  }

  /** @param {PendingCommandState} pending_command @param {View} view */
  #wait(pending_command, view) {
    const { state } = view;
    if (!state) return;
    const details = facts(pending_command, state.pose);
    this.#draw(
      pending_command.name,
      title(pending_command),
      details,
      pending_command.uncertain ? "uncertain" : "waiting",
    );
    write(this.#when, countdown(pending_command));
    this.#ring.style.setProperty("--left", left(pending_command).toFixed(3));
    this.#go.hidden = mayBegin(view) === null;
    if (pending_command.id === this.#waiting) return;
    this.#waiting = pending_command.id;
    this.#go.disabled = this.#cancel.disabled = false;
    const keys = this.#go.hidden
      ? t("pending-command-card.escape_cancels_it")
      : t("pending-command-card.enter_begins_it_now_escape_cancels");
    this.session.announce(`${title(pending_command)} ${countdown(pending_command)}. ${details}. ${keys}`);
  }

  /**
   * @param {string} name
   * @param {string} words
   * @param {string} facts
   * @param {"waiting" | "uncertain" | "begun"} state
   */
  #draw(name, words, facts, state) {
    redraw(this.#icon, name);
    write(this.#title, words);
    write(this.#facts, facts);
    mark(this, "data-state", state);
  }

  /**
   * Disable the button until its request is answered.
   * @param {HTMLButtonElement} button
   * @param {Promise<void>} answer
   */
  #press(button, answer) {
    button.disabled = true;
    void answer.finally(() => (button.disabled = false));
  }
}

customElements.define("pending-command-card", PendingCommandCard);
