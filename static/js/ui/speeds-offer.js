// The button that switches the type of a robot's speeds, where that was guessed and the robot did not move.

import { post, sentenceOf } from "../net/api.js";
import { make } from "./element.js";
import { t } from "./texts.js";

const GUESSED = "speeds.type_guessed";

/** @typedef {{code?: string | null | undefined, values?: Object<string, string> | null | undefined}} Said */

/** The type that a notice or a fault offers; "" for one of another kind. @param {Said} said */
export const offeredType = ({ code, values }) => (code === GUESSED ? (values?.["other"] ?? "") : "");

/**
 * A button that switches to the type that is offered; null where none is, or for who may not.
 * @param {import("../net/session.js").Session} session
 * @param {Said} said
 */
export function speedsOffer(session, said) {
  const type = offeredType(said);
  if (!type || session.hello?.you.role === "viewer") return null;
  const button = make("button.button", t("speeds-offer.send", { type }));
  button.addEventListener("click", () => {
    button.disabled = true;
    post("api/robot/speeds_type", { type }).then(
      () => session.announce(t("speeds-offer.sent", { type })),
      (trouble) => {
        button.disabled = false;
        session.complain(sentenceOf(trouble));
      },
    );
  });
  return button;
}
