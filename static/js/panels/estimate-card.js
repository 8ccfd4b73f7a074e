// Element <estimate-card>: estimated pose, its uncertainty, and the error of dead reckoning.
// Element <estimate-line>: the estimated pose in one line below the map; a press opens the estimate.

import { cardHead, make, mark, write } from "../ui/element.js";
import { degrees, fixed, headingBetween, metres, sigmas, spread, turnSpread } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

/** @type {Readonly<Record<string, string>>} */
const MODES = {
  invariant: t("estimate-card.ekf_invariant"),
  paper: t("estimate-card.ekf_as_in_the_paper"),
  dead_reckoning: t("estimate-card.wheels_alone"),
  recorded: t("playback-ways.as_recorded"),
};

class EstimateCard extends Panel {
  #mode = make("span.note");
  #figures = { x: figure("x"), y: figure("y"), heading: figure(t("estimate-card.heading")) };
  #facts = {
    landmarks: fact(t("estimate-card.landmarks"), t("estimate-card.corners_in_the_map_on_trial")),
    nis: fact(t("estimate-card.surprise_nis"), t("estimate-card.how_far_the_last_sightings_lay")),
    wheels: fact(t("estimate-card.wheels_alone_2"), t("estimate-card.how_far_dead_reckoning_lies_from")),
    laser: fact(t("estimate-card.laser_alone"), t("estimate-card.how_far_the_position_by_laser")),
    truth: fact(t("estimate-card.true_error"), t("estimate-card.simulator_only_the_distance_to_where")),
  };

  /** @override */
  build() {
    const { x, y, heading } = this.#figures;
    this.append(
      cardHead(t("estimate-card.where_it_believes_it_is"), this.#mode),
      make("dl.figures", x.row, y.row, heading.row),
      make("dl.facts", ...Object.values(this.#facts).map(({ row }) => row)),
    );
  }

  /** @override @param {View} view */
  show({ state, up }) {
    this.classList.toggle("is-old", !up);
    if (!state) return;
    const { pose, dead_reckoning: wheels, slam, truth, by_laser: laser } = state;
    const sigma = sigmas(pose.cov);
    const { x, y, heading } = this.#figures;
    const lost = state.floor.lost !== null; // then no spread holds
    const modeWords = lost
      ? t("estimate-card.lost")
      : slam.looking_around
        ? t("estimate-card.looking_around")
        : (MODES[slam.mode] ?? slam.mode);
    write(this.#mode, modeWords);
    say(x, metres(pose.x_m), lost ? "± ?" : spread(sigma.x));
    say(y, metres(pose.y_m), lost ? "± ?" : spread(sigma.y));
    say(heading, degrees(pose.heading_rad, 1), lost ? "± ?" : turnSpread(sigma.heading));
    const trial = slam.tentative ? t("estimate-card.tentative_on_trial", { tentative: slam.tentative }) : "";
    write(this.#facts.landmarks.value, `${state.landmarks.length}${trial}`);
    write(this.#facts.nis.value, slam.nis === null ? "–" : fixed(slam.nis, 1));
    write(this.#facts.wheels.value, apart(wheels, pose));
    mark(this.#facts.laser.row, "hidden", laser === null);
    if (laser) write(this.#facts.laser.value, apart(laser.pose, pose));
    mark(this.#facts.truth.row, "hidden", truth === null);
    if (truth) write(this.#facts.truth.value, apart(truth, pose));
  }
}

/**
 * How far two poses lie apart: "0.14 m, 3.2°".
 * @param {{x_m: number, y_m: number, heading_rad: number}} a
 * @param {{x_m: number, y_m: number, heading_rad: number}} b
 */
function apart(a, b) {
  const turned = Math.abs(headingBetween(a.heading_rad, b.heading_rad));
  return `${metres(Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m))}, ${degrees(turned, 1)}`;
}

/** @param {string} name */
function figure(name) {
  const value = make("span.figure-value", "–");
  const sigma = make("span.figure-sigma", "± –");
  return { row: make("div.figure", make("dt.note", name), make("dd", value, sigma)), value, sigma };
}

/** @param {{value: Element, sigma: Element}} row @param {string} value @param {string} sigma */
function say(row, value, sigma) {
  write(row.value, value);
  write(row.sigma, sigma);
}

/** @param {string} name @param {string} says */
function fact(name, says) {
  const value = make("dd", "–");
  return { row: make("div.fact", { title: says }, make("dt.note", name), value), value };
}

customElements.define("estimate-card", EstimateCard);

class EstimateLine extends Panel {
  #values = [0, 1, 2].map(() => ({ value: make("span.where-value", "–"), sigma: make("span.figure-sigma") }));
  #lost = make("span.where-lost", { hidden: true }, t("estimate-line.lost"));
  #button = make("button.row.where", { title: t("estimate-line.where_the_robot_believes_it_is") }, this.#lost);

  /** @override */
  build() {
    for (const [index, { value, sigma }] of this.#values.entries()) {
      const name = ["x ", "y ", t("estimate-line.heading")][index];
      this.#button.append(make("span.where-part", make("span.where-name", name), value, " ", sigma));
    }
    this.#button.addEventListener("click", () => dispatchEvent(new CustomEvent("open-view", { detail: "estimate" })));
    this.append(this.#button);
  }

  /** @override @param {View} view */
  show({ state, up }) {
    this.classList.toggle("is-old", !up);
    if (!state) return;
    const { x_m, y_m, heading_rad, cov } = state.pose;
    const lost = state.floor.lost !== null; // then no spread holds
    this.#lost.hidden = !lost;
    const sigma = sigmas(cov);
    /** @type {Array<[string, string]>} */
    const said = [
      [metres(x_m), spread(sigma.x)],
      [metres(y_m), spread(sigma.y)],
      [degrees(heading_rad, 1), turnSpread(sigma.heading)],
    ];
    for (const [index, part] of this.#values.entries()) {
      const [value, spreads] = said[index] ?? ["", ""];
      write(part.value, value);
      write(part.sigma, lost ? "± ?" : spreads);
    }
  }
}

customElements.define("estimate-line", EstimateLine);
