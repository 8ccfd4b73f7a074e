// Element <connect-timing>: ages of the sensors, time offsets of the lasers, clocks.

import { make, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { isRecording } from "./connection-model.js";

/** @import { ConnectionModel } from "./connection-model.js" */
/** @import { LaserTiming, MoveAgreementState, SensorLine } from "../net/messages.js" */
/** @import { ClockOffset as Clock } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */
/** @typedef {{name: string, value: string, note: string, tone: string | null}} Row */

const KINDS = {
  wheels: t("connect-timing.odometry"),
  laser: t("connect-timing.laser"),
  camera: t("connect-timing.camera"),
  microphones: t("connect-timing.microphones"),
};
const DAY_S = 86400;
const SURE_SDS = 2; // an offset below so many of its standard deviations counts as none

/** @extends {PagePanel<ConnectionModel>} */
class ConnectTiming extends PagePanel {
  #rows = make("dl.connect-times");

  /** @override */
  build() {
    this.append(
      make(
        "section.card.page-card",
        { "aria-label": t("connect-timing.times") },
        make("h2", t("connect-timing.times")),
        make("p.note", t("connect-timing.of_the_robot_that_this_console")),
        this.#rows,
      ),
    );
  }

  /** @override @param {View} view */
  show({ state }) {
    const model = this.model;
    this.hidden = !model?.found || !model.own || isRecording(model.found.url);
    if (this.hidden || !state || !model?.found) return;
    const { found } = model;
    const clocks = found.parts.flatMap((part) => part.findings.clocks);
    const rows = [
      ...state.robot.sensors.map(sensorRow),
      ...found.lasers.map((laser) => offsetRow(laser.name, state.robot.timings, found.odometry, found.lasers.length)),
      ...(found.odometry && found.lasers.length ? [agreementRow(state.robot.agreement)] : []),
      ...clocks.map(clockRow),
    ];
    this.#fill(rows);
  }

  /** @param {Row[]} rows */
  #fill(rows) {
    while (this.#rows.children.length > rows.length) this.#rows.lastElementChild?.remove();
    while (this.#rows.children.length < rows.length)
      this.#rows.append(make("div", make("dt"), make("dd"), make("dd.note")));
    for (const [index, row] of rows.entries()) {
      const line = /** @type {HTMLElement} */ (this.#rows.children[index]);
      const texts = [row.name, row.value, row.note];
      for (const [place, text] of texts.entries()) write(/** @type {Element} */ (line.children[place]), text);
      line.dataset["tone"] = row.tone ?? "";
    }
  }
}

/** @param {SensorLine} sensor @returns {Row} */
function sensorRow({ kind, name, state, age_s, rate_hz }) {
  const own = name && name !== kind && kind !== "microphones" ? ` ${name}` : "";
  const words = {
    live: t("connect-timing.arrives"),
    stale: t("connect-timing.is_late"),
    lost: t("connect-timing.is_lost"),
  };
  return {
    name: `${KINDS[kind]}${own}`,
    value: t("connect-timing.age_old", { age: age(age_s) }),
    note: t("connect-timing.words_fixed_hz_expected", { words: words[state], fixed: fixed(rate_hz, 0) }),
    tone: state === "live" ? null : "stale",
  };
}

/**
 * @param {string} laser
 * @param {LaserTiming[]} timings
 * @param {boolean} odometry
 * @param {number} count of lasers
 * @returns {Row}
 */
function offsetRow(laser, timings, odometry, count) {
  const name = count > 1 ? t("connect-timing.offset_of_laser", { laser }) : t("connect-timing.laser_to_odometry");
  const timing = timings.find((one) => one.laser === laser || (count === 1 && one.laser === ""));
  if (!odometry) return { name, value: "–", note: t("connect-timing.without_odometry_no_time_offset_is"), tone: null };
  if (!timing) return { name, value: "–", note: t("connect-timing.not_known_yet_turn_the_robot"), tone: null };
  const value = `${fixed(1000 * timing.offset_s, 0)} ± ${fixed(1000 * timing.sd_s, 1)} ms`;
  if (Math.abs(timing.offset_s) < SURE_SDS * timing.sd_s)
    return { name, value, note: t("connect-timing.in_step"), tone: null };
  const way = timing.offset_s > 0 ? t("connect-timing.early") : t("connect-timing.late");
  const corrected =
    timing.applied_s === 0 ? t("connect-timing.too_little_to_be_corrected") : t("connect-timing.corrected");
  return { name, value, note: t("connect-timing.the_laser_s_stamps_are_way", { way, corrected }), tone: null };
}

/** @param {number} value @param {number | null | undefined} sd @returns {string} */
function withSd(value, sd) {
  return `${fixed(value, 2)} ± ${fixed(sd ?? 0, 2)}`;
}

/** @param {MoveAgreementState | null} agreement @returns {Row} */
function agreementRow(agreement) {
  const name = t("connect-timing.wheels_over_scans");
  const { turn_scale: turn, turn_scale_sd: turnSd, way_scale: way, way_scale_sd: waySd, turns, ways } = agreement ?? {};
  const known = [
    ...(typeof turn === "number" ? [t("connect-timing.turns_scale", { scale: withSd(turn, turnSd) })] : []),
    ...(typeof way === "number" ? [t("connect-timing.ways_scale", { scale: withSd(way, waySd) })] : []),
  ];
  if (known.length) return { name, value: known.join(", "), note: t("connect-timing.compared_by_moves"), tone: null };
  const note = turns || ways ? t("connect-timing.has_hardly_moved") : t("connect-timing.has_not_moved");
  return { name, value: "–", note, tone: null };
}

/** @param {Clock} clock @returns {Row} */
function clockRow({ clock, ahead_s: ahead, offset_s: offset }) {
  const name = t("connect-timing.clock_of_clock", { clock });
  if (ahead === null)
    return {
      name,
      value: `${fixed(offset, 3)} s`,
      note: t("connect-timing.added_to_its_stamps_it_counts"),
      tone: null,
    };
  const way = ahead > 0 ? t("connect-timing.ahead_of") : t("connect-timing.behind");
  const size =
    Math.abs(ahead) < 10
      ? `${fixed(Math.abs(1000 * ahead), 0)} ms`
      : Math.abs(ahead) < DAY_S
        ? `${fixed(Math.abs(ahead), 0)} s`
        : t("connect-timing.count_days", { count: fixed(Math.abs(ahead) / DAY_S, 0) });
  return { name, value: size, note: t("connect-timing.way_this_computer_s_put_right", { way }), tone: null };
}

customElements.define("connect-timing", ConnectTiming);
