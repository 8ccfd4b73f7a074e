// Element <playback-ways>: a recording of Beckon's own as recorded, as computed now, or one over the other.

import { make, mark, write } from "../ui/element.js";
import { degrees, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { ComparisonState as Comparison } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */
/** @typedef {"recorded" | "computed"} Way */

/** @type {ReadonlyArray<readonly [Way, string, string]>} */
const WAYS = [
  ["recorded", t("playback-ways.as_recorded"), t("playback-ways.the_poses_directions_and_words_of")],
  ["computed", t("playback-ways.as_computed_now"), t("playback-ways.everything_estimated_again_from_the_raw")],
];
const SLOWER = 0.9; // of the speed that was asked for

class PlaybackWays extends Panel {
  #ways = WAYS.map(([way, name, title]) =>
    make("button.preset", { "data-way": way, title, onclick: () => this.#choose(way, this.#compares) }, name),
  );
  #group = make("div.presets", { role: "group", "aria-label": t("playback-ways.way_of_the_recording") }, ...this.#ways);
  #box = make("input", { type: "checkbox", onchange: () => this.#choose(this.#way, this.#box.checked) });
  #compare = make("label.compare", this.#box, t("playback-ways.compare"));
  #words = make("p.difference", { role: "status" });
  #compares = false;
  /** @type {Way} */
  #way = "recorded";

  /** @override */
  build() {
    this.hidden = true;
    this.append(this.#group, this.#compare, this.#words);
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    const playback = state?.playback ?? null;
    this.hidden = !playback;
    if (!playback) return;
    this.#way = /** @type {Way} */ (playback.way);
    this.#compares = playback.compare;
    const may = up && hello?.you.role !== "viewer";
    for (const button of this.#ways) {
      const way = button.dataset["way"] ?? "";
      mark(button, "aria-pressed", String(way === playback.way));
      mark(button, "disabled", !may || !playback.ways.includes(way));
    }
    this.#box.checked = playback.compare;
    mark(this.#box, "disabled", !may || playback.ways.length < 2);
    write(this.#words, this.#said(view(playback.comparison), playback, state?.robot.speed ?? 1));
  }

  /**
   * @param {string} difference
   * @param {NonNullable<import("../net/messages.js").State["playback"]>} playback
   * @param {number} speed
   */
  #said(difference, { computed_since_s: since, reached_speed: reached }, speed) {
    const from =
      since !== null && since > 0.5 ? t("playback-ways.computed_from_value_s_on", { value: fixed(since, 1) }) : "";
    const slow = reached !== null && since !== null && reached < SLOWER * speed;
    const pace = slow ? t("playback-ways.computing_reaches_value_times_real_time", { value: fixed(reached, 1) }) : "";
    return [difference, from, pace].filter(Boolean).join(" · ");
  }

  /** @param {Way} way @param {boolean} compare */
  #choose(way, compare) {
    void this.session.playback({ action: "way", way, compare });
  }
}

/** The difference in numbers. @param {Comparison | null} other */
function view(other) {
  if (!other) return "";
  if (other.same) return t("playback-ways.the_same_to_the_last_bit", { frames: other.frames });
  const { distance_m: distance, worst_m: worst, turn_rad: turn, direction_rad: direction } = other;
  const parts = [
    t("playback-ways.apart_now_at_most", {
      now: fixed(100 * distance, 1),
      most: fixed(100 * worst, 1),
      turn: degrees(turn, 1),
    }),
    t("playback-ways.corners_edges", {
      corners: `${other.recorded_landmarks} → ${other.computed_landmarks}`,
      edges: `${other.recorded_edges} → ${other.computed_edges}`,
    }),
  ];
  if (direction !== null) parts.push(t("playback-ways.voice_by_value", { value: degrees(direction, 1) }));
  return parts.join(" · ");
}

customElements.define("playback-ways", PlaybackWays);
