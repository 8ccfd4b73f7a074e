// Who drives, and how to take or give back the wheel.

import { icon, make, mark, redraw, write } from "../element.js";
import { Panel } from "../panel.js";
import { popover } from "../popover.js";

/** @typedef {import("../session.js").View} View */
/** @typedef {"acquire" | "take" | "release"} Wish */

class LeaseChip extends Panel {
  #icon = icon("wheel");
  #text = make("span", { class: "lease-text" });
  #button = make("button", { type: "button", class: "bar-chip" }, this.#icon, this.#text);
  #sentence = make("p", { class: "note" });
  #act = make("button", { type: "button", class: "button primary wide" });
  #panel = make(
    "div",
    { role: "group", "aria-label": "Who drives" },
    make("h2", { class: "card-title" }, "Who drives"),
    this.#sentence,
    this.#act,
  );
  /** @type {Wish} */
  #wish = "acquire";

  /** @override */
  build() {
    this.append(this.#button, this.#panel);
    const { close } = popover(this.#button, this.#panel, { opened: () => this.#act.focus() });
    this.#act.addEventListener("click", () => {
      void this.session.lease(this.#wish);
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
    this.hidden = !state || !hello?.robot.drives;
    if (!hello || !state || this.hidden) return;
    const { text, sentence, act, wish } = told(view, hello, state);
    write(this.#text, text);
    mark(this.#button, "aria-label", `Who drives: ${text}`);
    mark(this.#button, "data-mine", view.mine);
    redraw(this.#icon, hello.you.role === "viewer" ? "eye" : "wheel");
    write(this.#sentence, sentence);
    write(this.#act, act);
    this.#act.hidden = hello.you.role === "viewer";
    this.#act.disabled = !view.up;
    this.#wish = wish;
  }
}

/**
 * @param {View} view
 * @param {import("../wire.js").Hello} hello
 * @param {import("../wire.js").State} state
 * @returns {{text: string, sentence: string, act: string, wish: Wish}}
 */
function told({ mine }, hello, { lease }) {
  const watching = hello.you.role === "viewer";
  if (mine) {
    const sentence = "Others watch and may stop the robot at any time. Giving the wheel back stops it first.";
    return { text: "You drive", sentence, act: "Give the wheel back", wish: "release" };
  }
  if (lease.holder === null) {
    const sentence = watching
      ? "You are signed in as a viewer: you see everything and may stop the robot."
      : "The first command or key press takes the wheel. Taking it does not move the robot.";
    return { text: "Nobody drives", sentence, act: "Take the wheel", wish: "acquire" };
  }
  const sentence = watching
    ? `${lease.holder} drives. You see everything and may stop the robot.`
    : `${lease.holder} drives now. Taking over stops the robot first, and ${lease.holder} is told.`;
  return { text: `${lease.holder} drives`, sentence, act: "Take over", wish: "take" };
}

customElements.define("lease-chip", LeaseChip);
