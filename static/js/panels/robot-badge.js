// Element <robot-badge>: name of the robot, and whether it is simulated, recorded or real, and whether the chapter's own forms run.

import { icon, make, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";

const KINDS = {
  SIM: { icon: "cube", says: "Simulated robot" },
  LOG: { icon: "tape", says: "Recording: nothing moves" },
  LIVE: { icon: "antenna", says: "Real robot" },
};

class RobotBadge extends Panel {
  #name = make("span", { class: "robot-name" });
  #icon = icon("cube");
  #word = make("span");
  #badge = make("span", { class: "badge" }, this.#icon, this.#word);
  #printed = make(
    "span",
    {
      class: "badge badge-words",
      title: "The chapter's own equations run in the place of Beckon's: [chapter] mode = \"printed\"",
    },
    make("span", { class: "badge-more" }, "AS\u00a0"),
    "PRINTED",
  );

  /** @override */
  build() {
    this.append(this.#badge, this.#printed, this.#name);
    this.hidden = true;
    this.session.on("hello", ({ robot, chapter }) => {
      this.hidden = false;
      const kind = KINDS[robot.kind];
      this.#badge.dataset["kind"] = robot.kind;
      this.#badge.title = kind.says;
      this.#printed.hidden = chapter !== "printed";
      redraw(this.#icon, kind.icon);
      write(this.#word, robot.kind);
      write(this.#name, robot.name);
      this.#name.title = robot.url;
    });
  }
}

customElements.define("robot-badge", RobotBadge);
