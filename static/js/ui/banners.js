// Banners of the page in order of severity. Pure functions from a view to sentences.

import { nameOf } from "../connect/opening.js";
import { age, metres, speed, whereabouts } from "./format.js";
import { t } from "./texts.js";

/** @import { View } from "../net/session.js" */
/**
 * @typedef {object} Banner
 * @property {string} id stays the same while the banner says the same thing
 * @property {"fault" | "stale" | "calm"} tone
 * @property {string} icon
 * @property {string} text
 * @property {"" | "reset" | "here" | "answer" | "regain" | "seen" | "load" | "begun"} offers its buttons
 */

const STALE_S = 0.8;

/** @param {View} view @returns {Banner[]} */
export function banners(view) {
  const { state, hello, link } = view;
  if (link.is === "opening" && !state) return [];
  if (link.is !== "up" && view.opening) {
    if (view.opening.startsWith("sim:"))
      return [calmly("opening", "calm", "cube", t("banners.opening_the_simulated_robot"))];
    return [calmly("opening", "calm", "tape", t("banners.opening_name", { name: nameOf(view.opening) }))];
  }
  if (link.is !== "up") return [lost(view)];
  if (!state || !hello) return [];
  /** @type {Array<Banner | null>} */
  const candidates = [
    link.age_s > STALE_S
      ? calmly("quiet", "stale", "unlinked", t("banners.no_news_from_the_console_for", { age: age(link.age_s) }))
      : null,
    robotLink(state),
    state.gate.state === "halted" ? halted(view) : null,
    request(view),
    restarted(view),
    lostControl(view),
    state.floor.lost ? localization(state.floor.lost, view) : null,
    hello.robot.drives && state.floor.slipping
      ? calmly("slips", "calm", "warning", t("banners.the_wheels_slip_the_robot_relies"))
      : null,
    hello.robot.drives ? (state.robot.contact ? contact() : guard(state)) : null,
    hello.robot.drives && state.slam.looking_around && !state.floor.lost
      ? calmly("looking", "calm", "eye", t("banners.looking_around_the_robot_stands_still"))
      : null,
    view.secure ? null : calmly("plain", "stale", "warning", t("banners.plain_http")),
  ];
  return candidates.filter((banner) => banner !== null);
}

/** @param {View} view @returns {Banner} */
function lost({ state, link }) {
  const again =
    link.again_s > 0.95
      ? t("banners.trying_again_in_ceil_s", { ceil: Math.ceil(link.again_s) })
      : t("banners.trying_again");
  const fact = state ? t("banners.link_lost_the_robot_stops_by") : t("banners.beckon_does_not_answer");
  const text = `${fact}${link.why && ` ${link.why}`}${again}`;
  return { id: "lost", tone: "stale", icon: "unlinked", text, offers: "" };
}

/** @param {import("../net/messages.js").State} state */
function robotLink({ robot }) {
  const since = robot.age_s === null ? "" : t("banners.for_age", { age: age(robot.age_s) });
  if (robot.link === "connecting") return calmly("starting", "calm", "antenna", t("banners.the_robot_is_starting_up"));
  if (robot.link === "stale")
    return calmly("robot", "stale", "unlinked", t("banners.the_robot_has_been_silentsince", { since }));
  if (robot.link === "lost")
    return calmly("robot", "stale", "unlinked", t("banners.the_robot_does_not_answersince_it", { since }));
  return null;
}

/** @param {View} view @returns {Banner} */
function halted({ hello, state }) {
  const may = hello?.you.role !== "viewer";
  const name = state?.notices.findLast(({ code }) => code === "stop.who_halted")?.values?.["name"];
  const byWhom = may
    ? t("banners.halted_by_name_until_the_halt", { name })
    : t("banners.halted_by_name_until_an_operator", { name });
  const somehow = may
    ? t("banners.halted_nothing_moves_until_the_halt")
    : t("banners.halted_nothing_moves_until_an_operator");
  return { id: "halted", tone: "fault", icon: "halt", text: name ? byWhom : somehow, offers: may ? "reset" : "" };
}

/** @param {View} view @returns {Banner | null} who asks this page for control */
function request({ state, mine }) {
  if (!mine || !state?.lease.asked_by) return null;
  const left = Math.ceil(state.lease.answer_within_s ?? 0);
  const text = t("banners.askedby_asks_for_control_left_s", { askedby: state.lease.asked_by, left });
  return { id: `asked ${state.lease.asked_by_id}`, tone: "stale", icon: "wheel", text, offers: "answer" };
}

/** @param {View} view @returns {Banner | null} */
function restarted({ restarted, hello, state }) {
  if (!restarted) return null;
  const text =
    state?.robot.kind === "SIM"
      ? t("banners.beckon_was_restarted_at_start")
      : t("banners.beckon_was_restarted_map_begins");
  const offers = hello?.you.role === "viewer" ? "begun" : "load";
  return { id: "restarted", tone: "calm", icon: "info", text, offers };
}

/** @param {View} view @returns {Banner | null} */
function lostControl({ lostControl, state }) {
  if (!lostControl) return null;
  const text = lostControl.to
    ? t("banners.to_took_control_from_you_the", { to: lostControl.to })
    : t("banners.you_lost_control_nothing_came_from");
  const offers = state?.lease.holder ? "regain" : "seen";
  return { id: "lost control", tone: "stale", icon: "wheel", text, offers };
}

/** @param {import("../net/messages.js").LocalizationState} lost @param {View} view @returns {Banner} */
function localization({ phase, words }, { hello }) {
  const may = hello?.robot.drives === true && hello.you.role !== "viewer";
  const tone = phase === "asking" ? "stale" : "calm";
  return { id: "localization", tone, icon: "here", text: words, offers: may ? "here" : "" };
}

const contact = () => calmly("contact", "stale", "warning", t("banners.the_robot_touches_something_drive_it"));

/** @param {import("../net/messages.js").State} state */
function guard({ gate, pose }) {
  if (gate.limit_v_m_s === null || gate.blocked_by === null) return null;
  const [east, north] = [gate.blocked_by.x_m - pose.x_m, gate.blocked_by.y_m - pose.y_m];
  const [cos, sin] = [Math.cos(pose.heading_rad), Math.sin(pose.heading_rad)];
  const [x, y] = [cos * east + sin * north, cos * north - sin * east]; // world → robot
  const where = `${metres(Math.hypot(x, y), 1)} ${whereabouts(x, y)}`;
  if (gate.limit_v_m_s < 0.005) return calmly("blocked", "stale", "warning", t("banners.blocked_at_where", { where }));
  return calmly(
    "slowed",
    "calm",
    "info",
    t("banners.slowed_to_speed_something_at_where", { speed: speed(gate.limit_v_m_s), where }),
  );
}

/**
 * @param {string} id
 * @param {"stale" | "calm"} tone
 * @param {string} icon
 * @param {string} text
 * @returns {Banner}
 */
function calmly(id, tone, icon, text) {
  return { id, tone, icon, text, offers: "" };
}
