// Element <lease-chip>: shows the operator in control, and takes or gives back control.

import { onlyWatched } from "../drive/permission.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";

/** @typedef {import("../net/session.js").View} View */
/** @typedef {"acquire" | "ask" | "release"} LeaseAction */

class LeaseChip extends Panel {
  #icon = icon("wheel");
  #text = make("span", { class: "lease-text" });
  #button = make("button", { type: "button", class: "bar-chip" }, this.#icon, this.#text);
  #sentence = make("p", { class: "note" });
  #act = make("button", { type: "button", class: "button primary wide" });
  #take = make("button", { type: "button", class: "button wide" }, "Take over");
  #panel = make(
    "div",
    { role: "group", "aria-label": "Control" },
    make("h2", { class: "card-title" }, "Control"),
    this.#sentence,
    this.#act,
    this.#take,
  );
  /** @type {LeaseAction} */
  #action = "acquire";
  #close = () => {};

  /** @override */
  build() {
    this.append(this.#button, this.#panel);
    const { close } = popover(this.#button, this.#panel, { opened: () => this.#act.focus() });
    this.#act.addEventListener("click", () => {
      void this.session.lease(this.#action);
      if (this.#action !== "ask") close();
    });
    this.#take.addEventListener("click", () => {
      void this.session.lease("take");
      close();
    });
    this.#close = close;
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
    const asked = action === "ask" && state.lease.asked_by !== null;
    this.#act.disabled = !view.up || asked;
    this.#take.hidden = action !== "ask" || this.#act.hidden;
    this.#take.disabled = !view.up;
    if (this.#action === "ask" && action !== "ask") this.#close(); // the answer came
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
  return { text: `${lease.holder} drives`, sentence, act: asking(lease, hello.you.id), action: "ask" };
}

/**
 * @param {import("../net/messages.js").LeaseState} lease
 * @param {string} me
 */
function asking({ asked_by, asked_by_id, answer_within_s }, me) {
  if (!asked_by) return "Ask for control";
  return asked_by_id === me ? `Asked: ${Math.ceil(answer_within_s ?? 0)} s to answer` : `${asked_by} asks already`;
}

customElements.define("lease-chip", LeaseChip);
