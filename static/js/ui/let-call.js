// Who was not heard in the simulated room calls: a button, for commands that go to a person.

import { icon, make } from "./element.js";
import { t } from "./texts.js";

/** @type {readonly import("../net/rest.js").PersonInRoom[] | null} null: there is no simulated room, or it was not read */
let people = null;
addEventListener("room-people", (event) => {
  people = /** @type {CustomEvent<import("../net/rest.js").PersonInRoom[]>} */ (event).detail;
});

/** @returns {string} who in the simulated room could call; "": nobody */
export const couldCall = () => people?.[0]?.id ?? "";

/** @returns {boolean} whether there is a simulated room, and nobody in it */
export const isEmptyRoom = () => people?.length === 0;

/**
 * @param {import("../net/session.js").Session} session
 * @param {string} said
 * @returns {boolean} whether these words are a command that goes to a person
 */
export const goesToPerson = (session, said) =>
  session.kinds.find(({ words }) => words.includes(said.toLowerCase()))?.target === "person";

/** @param {string} caller @param {string} words @returns {HTMLButtonElement} */
export function letCall(caller, words) {
  const button = make("button.chip", icon("voice"), t("let-call.let_caller_call", { caller }));
  button.addEventListener("click", () =>
    dispatchEvent(new CustomEvent("let-call", { detail: { words: words.toLowerCase() } })),
  );
  return button;
}
