// Element <slam-card>: SLAM figures over the last two minutes, rooms, closures and landmarks.

import { icon, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { inLanguage, t } from "../ui/texts.js";
import { ClosureList } from "./closure-list.js";
import { LandmarkTable } from "./landmark-table.js";
import { LivePlot } from "./live-plot.js";

/** @import { View } from "../net/session.js" */

/** @param {number} high [m] */
const length = (high) => (high < 1 ? { unit: " cm", times: 100 } : { unit: " m", times: 1 });
const plain = () => ({ unit: "", times: 1 });

class SlamCard extends Panel {
  #plots = {
    error: new LivePlot({
      name: t("slam-card.true_error"),
      says: t("slam-card.simulator_only_how_far_the_estimate"),
      claim: t("slam-card.dashed_2_of_its_own"),
      unit: length,
      least: 0.02,
    }),
    nis: new LivePlot({
      name: t("slam-card.surprise_nis"),
      says: t("slam-card.how_far_sightings_lay_from_what"),
      claim: t("slam-card.band_95"),
      unit: plain,
      least: 1.5,
    }),
    match: new LivePlot({
      name: t("slam-card.scan_on_the_map"),
      says: t("slam-card.how_much_of_the_newest_sweep"),
      unit: plain,
      least: 1,
    }),
    update: new LivePlot({
      name: t("slam-card.time_of_an_update"),
      says: t("slam-card.how_long_it_takes_to_see"),
      unit: () => ({ unit: " ms", times: 1 }),
      least: 5,
    }),
  };
  #facts = make("p.note.slam-facts");
  #here = make("button.button.small", icon("here"), make("span", t("slam-card.it_is_here")));
  #closures = new ClosureList();
  #landmarks = new LandmarkTable();
  #seq = -1;

  /** @override */
  build() {
    this.append(
      make("div.inline.slam-top", this.#facts, make("span.spring"), this.#here),
      ...Object.values(this.#plots),
      this.#closures,
      make("div.inline.slam-head", make("h3", t("slam-card.landmarks"))),
      this.#landmarks,
    );
    this.#closures.join(this.session);
    this.#here.addEventListener("click", () => this.dispatchEvent(new CustomEvent("place-robot", { bubbles: true })));
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state) return;
    const { slam, floor } = state;
    if (state.seq !== this.#seq) this.#remember(state);
    this.#seq = state.seq;
    const operates = up && hello?.you.role !== "viewer";
    this.#here.hidden = hello?.robot.drives !== true || hello.you.role === "viewer";
    this.#here.disabled = !operates;
    mark(this.#plots.error, "hidden", slam.error_m === null);
    mark(this.#plots.match, "hidden", floor.match_score === null);
    const { error, nis, match, update } = this.#plots;
    nis.show(slam.nis_band);
    error.note(slam.nees === null ? "" : `NEES ${fixed(slam.nees, 1)}`);
    for (const plot of [error, match, update]) plot.show();
    const rooms = floor.submaps.length;
    const facts = [
      rooms ? `${rooms} ${rooms === 1 ? t("slam-card.room") : t("slam-card.rooms")}` : "",
      `${inLanguage(`${state.landmarks.length} landmarks`)}${slam.tentative ? t("slam-card.tentative_on_trial", { tentative: slam.tentative }) : ""}`,
    ];
    write(this.#facts, facts.filter(Boolean).join(" · "));
    this.#closures.show(floor, state.stamp_s, operates);
    this.#landmarks.show(state.landmarks);
  }

  /** @param {import("../net/messages.js").State} state */
  #remember({ stamp_s: now, slam, floor, pose }) {
    const claim = 2 * Math.sqrt(Math.max(0, (pose.cov[0]?.[0] ?? 0) + (pose.cov[1]?.[1] ?? 0)));
    this.#plots.error.add(now, slam.error_m, slam.error_m === null ? null : claim);
    this.#plots.nis.add(now, slam.nis);
    this.#plots.match.add(now, floor.match_score);
    this.#plots.update.add(now, slam.update_ms);
  }
}

customElements.define("slam-card", SlamCard);
