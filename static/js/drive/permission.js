// Decide whether this user may drive now, and give the reason if not. The server and the gate have the final say.

import { t } from "../ui/texts.js";

/** @import { Permission } from "./drive.js" */
/** @import { HelloMessage as Hello, State } from "../net/messages.js" */

/**
 * A recording or a sensor that takes no commands: nothing drives, and no camera looks for people.
 * @param {Hello | null} hello
 */
export const onlyWatched = (hello) => hello !== null && !hello.robot.drives && !hello.robot.dry_run;

/** @param {{hello: Hello | null, state: State | null, up: boolean}} view @returns {Permission} */
export function permission({ hello, state, up }) {
  /** @param {string} why @returns {Permission} */
  const no = (why) => ({ may: "no", why });
  if (!up || !hello || !state) return no(t("permission.the_link_to_the_console_is"));
  if (onlyWatched(hello)) return no(t("permission.a_recording_cannot_be_driven"));
  if (hello.you.role === "viewer") return no(t("permission.you_are_watching_only_an_operator"));
  if (state.gate.state === "halted") return no(t("permission.halted_reset_the_halt_first"));
  if (state.robot.link === "lost") return no(t("permission.the_robot_does_not_answer"));
  if (state.robot.link === "connecting") return no(t("permission.the_robot_is_still_starting_up"));
  const mine = state.lease.holder_id === hello.you.id;
  if (mine && state.gate.state === "armed" && state.gate.epoch === state.lease.epoch) return { may: "yes", why: "" };
  if (mine || state.lease.holder === null) return { may: "ask", why: "" };
  return { ...no(t("permission.holder_drives_take_over_first", { holder: state.lease.holder })), held: true };
}
