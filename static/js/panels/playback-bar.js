// Element <playback-bar>: play, pause, speed and position of a recording.
// Element <playback-ways>: a recording of Beckon's own as recorded, as computed now, or one over the other.
// Element <playback-part>: a part of the recording that plays, to be taken away.
// Element <first-play>: large Play button of a recording that waits at its beginning.

import { playsAtOnce } from "../connect/opening.js";
import { exportPart, filmOfPart, marks } from "../net/recordings-api.js";
import { askForPart } from "../recordings/part-form.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { degrees, duration, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { showFinished } from "../ui/recorder.js";
import { t } from "../ui/texts.js";
import { ruler, Timeline } from "../ui/timeline.js";

/** @import { ComparisonState as Comparison } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */

class PlaybackPart extends Panel {
  #button = make("button.button.small", { onclick: () => this.#toggle() }, t("playback-part.export"));
  /** @type {HTMLFormElement | null} */
  #form = null;

  /** @override */
  build() {
    this.hidden = true;
    this.append(this.#button);
    this.session.on("hello", () => this.#close());
  }

  /**
   * @override
   * @param {import("../net/session.js").View} view
   */
  show({ state, hello }) {
    this.hidden = !state || !hello?.robot.capabilities.includes("replay");
    const whyNot = state?.playback ? null : t("playback-part.only_beckons_own");
    mark(this.#button, "aria-disabled", whyNot ? "true" : null);
    mark(this.#button, "title", whyNot);
  }

  #toggle() {
    if (this.#form) return this.#close();
    const session = this.session;
    if (!session.state?.playback) return session.complain(t("playback-part.only_beckons_own"));
    const seconds = session.hello?.robot.duration_s ?? 0;
    this.#form = make("form.row.map-question", { "aria-label": t("playback-part.export_a_part") });
    this.append(this.#form);
    mark(this.#button, "aria-pressed", "true");
    askForPart(this.#form, {
      seconds,
      may: session.hello?.you.role !== "viewer",
      film: filmOfPart,
      cut: (part) =>
        session.attempt(async () => showFinished(session, "recorder.kept_as_name", await exportPart(part))),
      leave: () => {
        this.#close();
        this.#button.focus();
      },
      here: () => (session.state?.robot.progress ?? 0) * seconds,
      changed: ({ from, to }) => {
        const bar = /** @type {HTMLElement | null} */ (this.closest("playback-bar"));
        for (const [name, at] of Object.entries({ "--from": from, "--to": to }))
          bar?.style.setProperty(name, String(Math.min(at / seconds, 1) || 0));
      },
    });
  }

  #close() {
    this.#form?.remove();
    this.#form = null;
    mark(this.#button, "aria-pressed", "false");
  }
}

customElements.define("playback-part", PlaybackPart);

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

const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 20];
const STEPS = 10_000;
const ARROW_S = 5;
const STEERING = ":scope > button, .timeline > input, .mark, [data-speed]"; // what a viewer does not use
const TIMES = 6; // on the ruler
const SETTLE_MS = 600; // after a seek the slider waits for the recording to arrive there

class PlaybackBar extends Panel {
  #icon = icon("pause");
  #play = make("button.button.primary.play", { "aria-label": t("playback-bar.pause") }, this.#icon);
  #seek = make("input.seek", {
    type: "range",
    min: "0",
    max: String(STEPS),
    step: "1",
    value: "0",
    "aria-label": t("playback-bar.place_in_the_recording"),
  });
  #marks = make("div.marks");
  #ruler = make("div.ruler", { "aria-hidden": "true" });
  #line = make("div.timeline", this.#marks, this.#seek, this.#ruler);
  #timeline = new Timeline();
  #drawn = -1;
  #time = make("span.playback-time");
  #speeds = make(
    "div.presets",
    { role: "group", "aria-label": t("playback-bar.playback_speed") },
    ...SPEEDS.map((times) => make("button.preset", { "data-speed": String(times) }, `${times}×`)),
  );
  #movedAt = -Infinity;
  #length = 0;

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("playback-bar.playback"));
    const [ways, part] = ["playback-ways", "playback-part"].map((name) => document.createElement(name));
    this.append(
      this.#play,
      this.#line,
      this.#time,
      this.#speeds,
      /** @type {Node} */ (ways),
      /** @type {Node} */ (part),
    );
    this.session.on("hello", ({ robot }) => {
      this.hidden = !robot.capabilities.includes("replay");
      this.#length = robot.duration_s ?? 0;
      if (this.hidden || !this.#length) return;
      this.#timeline.begin(this.#length, robot.gaps_s);
      void marks().then(
        (found) => this.#timeline.add(found, this.#length),
        () => undefined, // without them it plays as well
      );
      const times = ruler(this.#length, TIMES).map((time) => {
        const label = make("span", duration(time));
        label.style.setProperty("--at", String(time / this.#length));
        return label;
      });
      this.#ruler.replaceChildren(...times);
    });
    this.#play.addEventListener("click", () => {
      void this.session.playback({ action: this.session.plays ? "pause" : "play" });
    });
    this.#seek.addEventListener("input", () => {
      this.#movedAt = performance.now();
      const place = Number(this.#seek.value) / STEPS;
      this.#tell(place);
      void this.session.scrub(place * this.#length); // the picture follows the finger
    });
    this.#seek.addEventListener("keydown", (event) => {
      const towards = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!towards) return;
      event.preventDefault();
      this.session.seekBy(towards * ARROW_S);
    });
    this.#seek.addEventListener("pointermove", ({ offsetX }) => {
      const place = Math.min(1, Math.max(0, offsetX / this.#seek.clientWidth));
      this.#seek.title = duration(place * this.#length);
    });
    for (const button of this.#speeds.querySelectorAll("button")) {
      button.addEventListener(
        "click",
        () => void this.session.playback({ action: "speed", speed: Number(button.dataset["speed"]) }),
      );
    }
  }

  /** @override @param {View} view */
  show({ state, up, hello }) {
    if (this.hidden || !state) return;
    this.#timeline.saw(state);
    if (this.#drawn !== this.#timeline.revision) this.#draw();
    const may = up && hello?.you.role !== "viewer";
    for (const control of this.querySelectorAll(STEERING)) mark(control, "disabled", !may);
    const { running, progress, speed } = state.robot;
    const ended = !running && progress !== null && progress >= 1;
    redraw(this.#icon, running ? "pause" : "play");
    mark(
      this.#play,
      "aria-label",
      running ? t("playback-bar.pause") : ended ? t("playback-bar.play_again") : t("playback-bar.play"),
    );
    for (const button of this.#speeds.querySelectorAll("button")) {
      mark(button, "aria-pressed", String(Number(button.dataset["speed"]) === speed));
    }
    if (performance.now() - this.#movedAt < SETTLE_MS) return;
    const place = progress ?? 0;
    this.#seek.value = String(Math.round(place * STEPS));
    this.#tell(place);
  }

  #draw() {
    this.#drawn = this.#timeline.revision;
    const marks = this.#timeline.marks.map(({ at, kind, words }) => {
      const says = `${duration(at * this.#length)}: ${words}`;
      const mark = make("button.mark", { "data-kind": kind, title: says, "aria-label": says });
      mark.style.setProperty("--at", String(at));
      mark.addEventListener("click", () => void this.session.scrub(at * this.#length));
      return mark;
    });
    this.#marks.replaceChildren(...marks);
  }

  /** @param {number} place 0..1 */
  #tell(place) {
    this.#seek.style.setProperty("--place", `${place * 100}%`);
    const text = t("playback-bar.duration_of_duration2", {
      duration: duration(place * this.#length),
      duration2: duration(this.#length),
    });
    write(this.#time, text);
    mark(this.#seek, "aria-valuetext", text);
  }
}

customElements.define("playback-bar", PlaybackBar);

const BEGUN = 0.02; // of the recording; some begin before their first scan

class FirstPlay extends Panel {
  #length = make("span.note");
  #button = make("button.button.primary.first-play", icon("play"), make("span", t("first-play.play_the_recording")));
  #watches = make("p", t("first-play.the_recording_waits_an_operator_can"));
  #played = false;

  /** @override */
  build() {
    this.append(this.#button, this.#watches, this.#length);
    this.#button.addEventListener("click", () => void this.session.playback({ action: "play" }));
    this.session.on("hello", ({ robot }) => (this.#length.textContent = duration(robot.duration_s ?? 0)));
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state || !hello) return;
    const { running, progress } = state.robot;
    this.#played ||= running || (progress ?? 0) > BEGUN;
    this.hidden = !hello.robot.capabilities.includes("replay") || this.#played || !up;
    const watches = hello.you.role === "viewer";
    this.#button.hidden = watches;
    this.#watches.hidden = !watches;
    if (!this.hidden && !watches && playsAtOnce(hello.robot.url)) void this.session.playback({ action: "play" });
  }
}

customElements.define("first-play", FirstPlay);
