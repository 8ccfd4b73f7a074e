// Element <connect-timing>: ages of the sensors, time offsets of the lasers, clocks.

import { make, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";

/** @typedef {import("./connection-model.js").ConnectionModel} ConnectionModel */
/** @typedef {import("./connection-model.js").Clock} Clock */
/** @typedef {import("../net/messages.js").LaserTiming} LaserTiming */
/** @typedef {import("../net/messages.js").SensorLine} SensorLine */
/** @typedef {import("../net/session.js").View} View */
/** @typedef {{name: string, value: string, note: string, tone: string | null}} Row */

const KINDS = { wheels: "Odometry", laser: "Laser", camera: "Camera", microphones: "Microphones" };
const DAY_S = 86400;

class ConnectTiming extends Panel {
  /** @type {ConnectionModel | null} */
  #model = null;
  #rows = make("dl", { class: "connect-times" });

  /** @param {ConnectionModel} model */
  watch(model) {
    this.#model = model;
  }

  /** @override */
  build() {
    this.append(
      make(
        "section",
        { class: "card connect-card", "aria-label": "Times" },
        make("h2", {}, "Times"),
        make("p", { class: "note" }, "Of the robot that this console drives."),
        this.#rows,
      ),
    );
  }

  /**
   * @override
   * @param {View} view
   */
  show({ state }) {
    const model = this.#model;
    this.hidden = !model?.found || !model.own;
    if (this.hidden || !state || !model?.found) return;
    const { found } = model;
    const clocks = found.parts.flatMap((part) => part.findings.clocks);
    const rows = [
      ...state.robot.sensors.map(sensorRow),
      ...found.lasers.map((laser) => offsetRow(laser.name, state.robot.timings, found.odometry, found.lasers.length)),
      ...clocks.map(clockRow),
    ];
    this.#fill(rows);
  }

  /** @param {Row[]} rows */
  #fill(rows) {
    while (this.#rows.children.length > rows.length) this.#rows.lastElementChild?.remove();
    while (this.#rows.children.length < rows.length)
      this.#rows.append(make("div", {}, make("dt"), make("dd"), make("dd", { class: "note" })));
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
  const words = { live: "arrives", stale: "is late", lost: "is lost" };
  return {
    name: `${KINDS[kind]}${own}`,
    value: `${age(age_s)} old`,
    note: `${words[state]}; ${fixed(rate_hz, 0)} Hz expected`,
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
  const name = count > 1 ? `Offset of ${laser}` : "Laser to odometry";
  const timing = timings.find((one) => one.laser === laser || (count === 1 && one.laser === ""));
  if (!odometry) return { name, value: "–", note: "Without odometry no time offset is estimated.", tone: null };
  if (!timing) return { name, value: "–", note: "Not known yet; turn the robot on the spot.", tone: null };
  const way = timing.offset_s > 0 ? "early" : "late";
  const corrected = timing.applied_s === 0 ? "too little to be corrected" : "corrected";
  return {
    name,
    value: `${fixed(1000 * timing.offset_s, 0)} ± ${fixed(1000 * timing.sd_s, 1)} ms`,
    note: `The laser's stamps are ${way}; ${corrected}.`,
    tone: null,
  };
}

/** @param {Clock} clock @returns {Row} */
function clockRow({ clock, ahead_s: ahead, offset_s: offset }) {
  const name = `Clock of ${clock}`;
  if (ahead === null)
    return {
      name,
      value: `${fixed(offset, 3)} s`,
      note: "Added to its stamps; it counts from its own start.",
      tone: null,
    };
  const way = ahead > 0 ? "ahead of" : "behind";
  const size =
    Math.abs(ahead) < 10
      ? `${fixed(Math.abs(1000 * ahead), 0)} ms`
      : Math.abs(ahead) < DAY_S
        ? `${fixed(Math.abs(ahead), 0)} s`
        : `${fixed(Math.abs(ahead) / DAY_S, 0)} days`;
  return { name, value: size, note: `${way} this computer's; put right.`, tone: null };
}

customElements.define("connect-timing", ConnectTiming);
