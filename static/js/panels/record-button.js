// Element <record-button>: records the drive, and keeps what just happened. In the bar of every page, and on that of recordings.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { keep, recorderOf, toggle } from "../ui/recorder.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

class RecordButton extends Panel {
  #icon = icon("recorder");
  #words = make("span.recorder-words");
  #time = make("span.recorder-time");
  #size = make("span.recorder-size");
  #record = make("button.bar-chip.recorder", this.#icon, this.#words, this.#time, this.#size);
  #keepWords = make("span.recorder-words", t("record-button.keep"));
  #keep = make("button.bar-chip.recorder-keep", icon("keep"), this.#keepWords);
  #busy = false;

  /** @override */
  build() {
    this.append(this.#record, this.#keep);
    this.#record.addEventListener("click", () => void this.#during(() => toggle(this.session)));
    this.#keep.addEventListener("click", () => void this.#during(() => keep(this.session)));
  }

  /** @param {() => Promise<unknown>} act */
  async #during(act) {
    if (this.#busy) return;
    this.#busy = true;
    this.show(this.session.view);
    await act();
    this.#busy = false;
  }

  /** @override @param {View} view */
  show(view) {
    const { runs, time, size, whyNot, holds, held, whyNotKept } = recorderOf(view);
    this.hidden = view.state === null;
    redraw(this.#icon, runs ? "recording" : "recorder");
    mark(this.#record, "data-runs", runs);
    const end = this.closest(".bar") ? t("record-button.end") : t("record-button.end_recording");
    write(this.#words, runs ? end : t("record-button.record"));
    write(this.#time, time);
    write(this.#size, size);
    const does = runs ? t("record-button.stop_recording", { time, size }) : t("record-button.record_the_drive");
    say(this.#record, does, whyNot, this.#busy);
    this.#keep.hidden = !holds;
    const keeps = held ? t("record-button.keep_the_last", { time: held }) : t("record-button.keep_what_just_happened");
    say(this.#keep, keeps, whyNotKept, this.#busy);
  }
}

/**
 * A button that cannot be pressed now says why when it is pressed all the same.
 * @param {HTMLElement} button
 * @param {string} does
 * @param {string} whyNot
 * @param {boolean} busy
 */
function say(button, does, whyNot, busy) {
  const words = whyNot ? `${does}. ${whyNot}` : does;
  mark(button, "aria-label", words);
  mark(button, "title", words);
  mark(button, "aria-disabled", whyNot || busy ? "true" : null);
}

customElements.define("record-button", RecordButton);
