// Element <lease-chip>: shows the operator in control, and takes or gives back control.

import { onlyWatched } from "../drive/permission.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */
/** @typedef {"acquire" | "ask" | "release"} LeaseAction */

class LeaseChip extends Panel {
  #icon = icon("wheel");
  #text = make("span.lease-text");
  #button = make("button.bar-chip", this.#icon, this.#text, make("span.bar-word", t("lease-chip.control")));
  #sentence = make("p.note");
  #act = make("button.button.primary.wide");
  #take = make("button.button.wide", t("lease-chip.take_over"));
  #panel = make(
    "div",
    { role: "group", "aria-label": t("lease-chip.control") },
    make("h2.card-title", t("lease-chip.control")),
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

  /** @override @param {View} view */
  show(view) {
    const { hello, state } = view;
    this.hidden = !state || !hello || onlyWatched(hello);
    if (!hello || !state || this.hidden) return;
    const { text, sentence, act, action } = describe(hello, state);
    write(this.#text, text);
    mark(this.#button, "aria-label", t("lease-chip.control_text", { text }));
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
 * @param {import("../net/messages.js").HelloMessage} hello
 * @param {import("../net/messages.js").State} state
 * @returns {{text: string, sentence: string, act: string, action: LeaseAction}}
 */
function describe(hello, { lease }) {
  const mine = lease.holder_id === hello.you.id; // without a link, too: the newest that is known
  const watching = hello.you.role === "viewer";
  if (hello.robot.dry_run && !watching && (mine || lease.holder === null)) {
    const sentence = t("lease-chip.nothing_here_drives_come_here_and");
    if (mine)
      return { text: t("lease-chip.dry_run"), sentence, act: t("lease-chip.give_control_back"), action: "release" };
    return { text: t("lease-chip.dry_run"), sentence, act: t("lease-chip.take_control"), action: "acquire" };
  }
  if (mine) {
    const sentence = t("lease-chip.others_watch_and_may_stop_the");
    return { text: t("lease-chip.you_drive"), sentence, act: t("lease-chip.give_control_back"), action: "release" };
  }
  if (lease.holder === null) {
    const sentence = watching ? t("lease-chip.you_are_signed_in_as_a") : t("lease-chip.the_first_command_or_key_press");
    return { text: t("lease-chip.nobody_drives"), sentence, act: t("lease-chip.take_control"), action: "acquire" };
  }
  const sentence = watching
    ? t("lease-chip.holder_drives_you_see_everything_and", { holder: lease.holder })
    : t("lease-chip.holder_drives_now_taking_over_stops", { holder: lease.holder, holder2: lease.holder });
  return {
    text: t("lease-chip.holder_drives", { holder: lease.holder }),
    sentence,
    act: asking(lease, hello.you.id),
    action: "ask",
  };
}

/** @param {import("../net/messages.js").LeaseState} lease @param {string} me */
export function asking({ asked_by, asked_by_id, answer_within_s }, me) {
  if (!asked_by) return t("lease-chip.ask_for_control");
  return asked_by_id === me
    ? t("lease-chip.asked_ceil_s_to_answer", { ceil: Math.ceil(answer_within_s ?? 0) })
    : t("lease-chip.askedby_asks_already", { askedby: asked_by });
}

customElements.define("lease-chip", LeaseChip);
