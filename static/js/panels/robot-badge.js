// Element <robot-badge>: name of the robot; whether it is simulated, recorded or real; the way back from a recording.

import { mapLeft, openInstead, robotBefore } from "../connect/opening.js";
import { icon, make, redraw, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

const KINDS = {
  SIM: { icon: "cube", says: t("robot-badge.simulated_robot") },
  LOG: { icon: "tape", says: t("robot-badge.recording_nothing_moves") },
  LIVE: { icon: "antenna", says: t("robot-badge.real_robot") },
};

class RobotBadge extends Panel {
  #name = make("span.robot-name");
  #icon = icon("cube");
  #word = make("span");
  #badge = make("span.badge", this.#icon, this.#word);
  #printed = make(
    "span.badge.badge-words",
    { title: t("robot-badge.the_chapter_s_own_equations_run") },
    make("span.badge-more", "AS\u00a0"),
    t("robot-badge.printed"),
  );

  #share = make("span");
  #pace = make(
    "span.badge.badge-words",
    { "data-tone": "stale", hidden: true },
    this.#share,
    make("span.badge-more", "\u00a0", t("robot-badge.real_time")),
  );

  #back = make(
    "button.bar-chip",
    { hidden: true, title: t("robot-badge.back_to_the_robot"), onclick: () => void this.#leave() },
    icon("undo"),
    make("span.badge-more", t("robot-badge.back_to_the_robot")),
    make("span.bar-word", t("robot-badge.back")),
  );

  /** @override */
  build() {
    this.append(this.#badge, this.#pace, this.#printed, this.#name, this.#back);
    this.hidden = true;
    this.session.on("hello", ({ robot, chapter, you }) => {
      this.#back.hidden = robot.kind !== "LOG" || robotBefore() === "" || you.role === "viewer";
      this.hidden = false;
      const kind = KINDS[robot.kind];
      this.#badge.dataset["kind"] = robot.kind;
      this.#badge.title = kind.says;
      this.#printed.hidden = chapter !== "printed";
      redraw(this.#icon, kind.icon);
      write(this.#word, robot.kind);
      write(this.#name, robot.name);
      this.#name.title = robot.url;
      const name = robot.kind === "LOG" || this.session.opening ? "" : mapLeft();
      const text = t("robot-badge.your_map_was_saved", { name });
      if (name) this.session.tell("offer", { text, words: t("recorder.show"), event: "show-maps" });
    });
  }

  async #leave() {
    this.#back.disabled = true;
    await openInstead(this.session, robotBefore()).catch((refusal) => this.session.complain(refusal.message));
    this.#back.disabled = false;
  }

  /** @override @param {View} view */
  show({ state }) {
    const pace = state?.robot.pace ?? 1;
    this.#pace.hidden = pace >= 1;
    if (pace >= 1) return;
    const share = fixed(pace, pace < 0.1 ? 2 : 1);
    const simulated = state?.robot.kind === "SIM";
    write(this.#share, `${share}\u00a0×`);
    this.#pace.title = t(
      simulated ? "robot-badge.the_simulator_runs_at" : "robot-badge.this_computer_is_busy_the_robot",
      { share },
    );
  }
}

customElements.define("robot-badge", RobotBadge);
