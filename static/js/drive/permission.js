// Decide whether this user may drive now, and give the reason if not. The server and the gate have the final say.

/** @typedef {import("../net/messages.js").HelloMessage} Hello */
/** @typedef {import("../net/messages.js").State} State */
/** @typedef {import("./drive.js").Permission} Permission */

/**
 * A recording or a sensor that takes no commands: nothing drives, and no camera looks for people.
 * @param {Hello | null} hello
 */
export const onlyWatched = (hello) => hello !== null && !hello.robot.drives && !hello.robot.dry_run;

/**
 * @param {{hello: Hello | null, state: State | null, up: boolean}} view
 * @returns {Permission}
 */
export function permission({ hello, state, up }) {
  /** @param {string} why @returns {Permission} */
  const no = (why) => ({ may: "no", why });
  if (!up || !hello || !state) return no("The link to the console is lost.");
  if (onlyWatched(hello)) return no("A recording cannot be driven.");
  if (hello.you.role === "viewer") return no("You are watching. Only an operator can drive.");
  if (state.gate.state === "halted") return no("Halted. Reset the halt first.");
  if (state.robot.link === "lost") return no("The robot does not answer.");
  if (state.robot.link === "connecting") return no("The robot is still starting up.");
  const mine = state.lease.holder_id === hello.you.id;
  if (mine && state.gate.state === "armed" && state.gate.epoch === state.lease.epoch) return { may: "yes", why: "" };
  if (mine || state.lease.holder === null) return { may: "ask", why: "" };
  return no(`${state.lease.holder} drives. Take over first.`);
}
