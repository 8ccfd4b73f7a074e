// Element <playback-part>: a part of the recording that plays, to be taken away.

import { exportPart, filmOfPart } from "../net/playback-api.js";
import { askForPart } from "../recordings/part-form.js";
import { make, mark } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { showFinished } from "../ui/recorder.js";
import { t } from "../ui/texts.js";

class PlaybackPart extends Panel {
  #button = make("button.button.small", { onclick: () => this.#toggle() }, t("playback-part.export"));
  /** @type {HTMLFormElement | null} */
  #form = null;

  /** @override */
  build() {
    this.hidden = true;
    this.append(this.#button);
    this.session.on("hello", () => this.#close());
  }

  /**
   * @override
   * @param {import("../net/session.js").View} view
   */
  show({ state, hello }) {
    this.hidden = !state || !hello?.robot.capabilities.includes("replay");
    const whyNot = state?.playback ? null : t("playback-part.only_beckons_own");
    mark(this.#button, "aria-disabled", whyNot ? "true" : null);
    mark(this.#button, "title", whyNot);
  }

  #toggle() {
    if (this.#form) return this.#close();
    const session = this.session;
    if (!session.state?.playback) return session.complain(t("playback-part.only_beckons_own"));
    const seconds = session.hello?.robot.duration_s ?? 0;
    this.#form = make("form.row.map-question", { "aria-label": t("playback-part.export_a_part") });
    this.append(this.#form);
    mark(this.#button, "aria-pressed", "true");
    askForPart(this.#form, {
      seconds,
      may: session.hello?.you.role !== "viewer",
      film: filmOfPart,
      cut: (part) =>
        session.attempt(async () => showFinished(session, "recorder.kept_as_name", await exportPart(part))),
      leave: () => {
        this.#close();
        this.#button.focus();
      },
      here: () => (session.state?.robot.progress ?? 0) * seconds,
      changed: ({ from, to }) => {
        const bar = /** @type {HTMLElement | null} */ (this.closest("playback-bar"));
        for (const [name, at] of Object.entries({ "--from": from, "--to": to }))
          bar?.style.setProperty(name, String(Math.min(at / seconds, 1) || 0));
      },
    });
  }

  #close() {
    this.#form?.remove();
    this.#form = null;
    mark(this.#button, "aria-pressed", "false");
  }
}

customElements.define("playback-part", PlaybackPart);
