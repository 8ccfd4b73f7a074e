// What a robot of the fleet does and needs, in words.

import { age } from "../ui/format.js";
import { said, t } from "../ui/texts.js";

/** @import { FleetRow as Robot } from "../net/rest.js" */

/** @type {Readonly<Record<string, string>>} */
const NEEDS = {
  unanswered: t("fleet.need_unanswered"),
  gone: t("fleet.need_gone"),
  stale: t("fleet.need_stale"),
  robot: t("fleet.need_robot"),
  lost: t("fleet.need_lost"),
  halted: t("fleet.need_halted"),
  error: t("fleet.need_error"),
  blocked: t("fleet.need_blocked"),
  battery: t("fleet.need_battery"),
};

const MOVES_M_S = 0.01; // from which a robot is driven

/** @typedef {"help" | "working" | "idle" | "away"} Group */
/** @type {ReadonlyArray<readonly [Group, string]>} */
export const GROUPS = [
  ["help", t("fleet.group_help")],
  ["working", t("fleet.group_working")],
  ["idle", t("fleet.group_idle")],
  ["away", t("fleet.group_away")],
];

/** @param {Robot} robot @returns {Group} */
export function groupOf(robot) {
  if (robot.need) return "help";
  if (robot.age_s === null) return "away";
  return robot.command || robot.operator ? "working" : "idle";
}

/** True where nobody drives and nothing moves, as far as a fresh report says. @param {Robot} robot */
export const standsStill = ({ link, operator, command, speed_m_s: speed }) =>
  link === "live" && !operator && !command && speed <= MOVES_M_S;

/** True where its console can be opened. @param {Robot} robot */
export const isOpen = ({ age_s: age, link, role }) => age !== null && link !== "gone" && role !== null;

/** @param {Robot} robot */
export const needOf = (robot) => NEEDS[robot.need] ?? "";

/** @param {Robot} robot */
export function activityOf(robot) {
  if (robot.age_s === null) return t("fleet.never_joined");
  const still = robot.speed_m_s > MOVES_M_S ? t("fleet.is_driven") : t("fleet.stands");
  const what = robot.command?.heard_as ?? still;
  return robot.link === "live" ? what : t("fleet.last_heard", { what });
}

/** @param {Robot} robot */
export function linkOf(robot) {
  const since = age(robot.since_s);
  if (robot.link === "live") return t("fleet.live_age", { age: age(robot.age_s ?? 0) });
  if (robot.link === "stale") return t("fleet.stale_since", { age: age(robot.age_s ?? robot.since_s) });
  return robot.age_s === null ? t("fleet.not_joined") : t("fleet.gone_since", { age: since });
}

/** @param {Robot} robot */
export const noticeOf = ({ notice }) => (notice ? said(notice.text, notice.code, notice.values) : "");
