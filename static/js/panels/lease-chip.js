// Element <lease-chip>: shows the operator in control, and takes or gives back control.

import { onlyWatched } from "../drive/permission.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";

/** @typedef {import("../net/session.js").View} View */
/** @typedef {"acquire" | "take" | "release"} LeaseAction */

class LeaseChip extends Panel {
  #icon = icon("wheel");
  #text = make("span", { class: "lease-text" });
  #button = make("button", { type: "button", class: "bar-chip" }, this.#icon, this.#text);
  #sentence = make("p", { class: "note" });
  #act = make("button", { type: "button", class: "button primary wide" });
  #panel = make(
    "div",
    { role: "group", "aria-label": "Control" },
    make("h2", { class: "card-title" }, "Control"),
    this.#sentence,
    this.#act,
  );
  /** @type {LeaseAction} */
  #action = "acquire";

  /** @override */
  build() {
    this.append(this.#button, this.#panel);
    const { close } = popover(this.#button, this.#panel, { opened: () => this.#act.focus() });
    this.#act.addEventListener("click", () => {
      void this.session.lease(this.#action);
      close();
    });
    this.hidden = true;
  }

  /**
   * @override
   * @param {View} view
   */
  show(view) {
    const { hello, state } = view;
    this.hidden = !state || !hello || onlyWatched(hello);
    if (!hello || !state || this.hidden) return;
    const { text, sentence, act, action } = describe(view, hello, state);
    write(this.#text, text);
    mark(this.#button, "aria-label", `Control: ${text}`);
    mark(this.#button, "data-mine", view.mine);
    redraw(this.#icon, hello.you.role === "viewer" ? "eye" : "wheel");
    write(this.#sentence, sentence);
    write(this.#act, act);
    this.#act.hidden = hello.you.role === "viewer";
    this.#act.disabled = !view.up;
    this.#action = action;
  }
}

/**
 * @param {View} view
 * @param {import("../net/messages.js").HelloMessage} hello
 * @param {import("../net/messages.js").State} state
 * @returns {{text: string, sentence: string, act: string, action: LeaseAction}}
 */
function describe({ mine }, hello, { lease }) {
  const watching = hello.you.role === "viewer";
  if (hello.robot.dry_run && !watching && (mine || lease.holder === null)) {
    const sentence = "Nothing here drives. COME HERE and FOLLOW ME show what a robot would do.";
    if (mine) return { text: "Dry run", sentence, act: "Give control back", action: "release" };
    return { text: "Dry run", sentence, act: "Take control", action: "acquire" };
  }
  if (mine) {
    const sentence = "Others watch and may stop the robot at any time. Giving control back stops it first.";
    return { text: "You drive", sentence, act: "Give control back", action: "release" };
  }
  if (lease.holder === null) {
    const sentence = watching
      ? "You are signed in as a viewer: you see everything and may stop the robot."
      : "The first command or key press takes control. This alone does not move the robot.";
    return { text: "Nobody drives", sentence, act: "Take control", action: "acquire" };
  }
  const sentence = watching
    ? `${lease.holder} drives. You see everything and may stop the robot.`
    : `${lease.holder} drives now. Taking over stops the robot first, and ${lease.holder} gets a notice.`;
  return { text: `${lease.holder} drives`, sentence, act: "Take over", action: "take" };
}

customElements.define("lease-chip", LeaseChip);
