// Element <hearing-card>: directions of voices, transcripts, and the microphone check.
// Drawing of voice directions around the robot: wedges of two standard deviations, the newest boldest.

import { onlyWatched } from "../drive/permission.js";
import * as api from "../net/api.js";
import { cardHead, icon, make, mark, svg, write } from "../ui/element.js";
import { degrees, inWords } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { certainty } from "../ui/pending-command.js";
import { PeopleNear } from "../ui/people-near.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { HearingState as Ears, VoiceHeard } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */
/** @import { Transcript } from "../voice/audio-socket.js" */

const RADIUS = 46;
const INNER = 13;
const MOST = 4; // voices
const KEPT_MS = 20000; // of former directions, drawn as dots on the rim
const NARROWEST = 0.035; // [rad] half of a wedge that can still be seen

export class SoundRose extends HTMLElement {
  #wedges = svg("g", { class: "rose-wedges" });
  #past = svg("g", { class: "rose-past" });
  #level = svg("circle", { class: "rose-level", cx: 0, cy: 0, r: INNER });
  /** @type {{at: number, azimuth: number}[]} directions in the world frame */
  #history = [];
  #drawn = "";
  #built = false;

  connectedCallback() {
    if (this.#built) return;
    this.#built = true;
    const drawing = svg("svg", {
      viewBox: "-60 -60 120 120",
      role: "img",
      "aria-label": t("sound-rose.directions_of_voices"),
    });
    drawing.append(
      svg("circle", { class: "rose-rim", cx: 0, cy: 0, r: RADIUS }),
      ...[0, 1, 2, 3].map((quarter) =>
        svg("path", { class: "rose-tick", d: "M0 -46V-40", transform: `rotate(${90 * quarter})` }),
      ),
      this.#past,
      this.#wedges,
      this.#level,
      svg("path", { class: "rose-robot", d: "M0 -8 5.500 6 0 3 -5.500 6Z" }),
    );
    this.append(drawing);
  }

  /** @param {Ears | null} ears */
  show(ears) {
    if (!ears) return;
    const now = performance.now();
    const voices = ears.voices.slice(0, MOST);
    const heading = voices[0] ? voices[0].azimuth_world_rad - voices[0].azimuth_rad : 0;
    for (const voice of voices)
      if (voice.age_s < 0.3) this.#history.push({ at: now, azimuth: voice.azimuth_world_rad });
    this.#history = this.#history.filter(({ at }) => now - at < KEPT_MS).slice(-200);
    mark(this, "data-speaking", ears.speaking);
    mark(this, "data-listening", ears.listening);
    const loud = Math.max(0, Math.min(1, 1 + (ears.level_dbfs ?? -60) / 60));
    this.#level.setAttribute("r", String(INNER + 6 * loud));
    const key = voices
      .map((voice) => [voice.id, voice.azimuth_rad, voice.sd_heard_rad, Math.round(voice.age_s)].join())
      .join();
    if (key === this.#drawn && voices.length === this.#wedges.childElementCount) return;
    this.#drawn = key;
    this.#wedges.replaceChildren(...voices.map((voice, index) => wedge(voice, index)));
    const step = Math.max(1, Math.floor(this.#history.length / 24));
    const dots = voices.length ? this.#history.filter((_, index) => index % step === 0) : [];
    this.#past.replaceChildren(...dots.map(({ azimuth, at }) => dot(azimuth - heading, (now - at) / KEPT_MS)));
  }
}

/** @param {VoiceHeard} voice @param {number} index 0: heard last */
function wedge(voice, index) {
  const half = Math.min(Math.PI, Math.max(NARROWEST, 2 * voice.sd_heard_rad));
  const [from, to] = [voice.azimuth_rad - half, voice.azimuth_rad + half];
  const large = half > Math.PI / 2 ? 1 : 0;
  const path = svg("path", {
    class: "rose-wedge",
    d: `M${at(from, INNER)}L${at(from, RADIUS)}A${RADIUS} ${RADIUS} 0 ${large} 0 ${at(to, RADIUS)}L${at(to, INNER)}Z`,
    opacity: Math.max(0.25, 1 - voice.age_s / 8).toFixed(2),
  });
  path.setAttribute("data-index", String(index));
  return path;
}

/** @param {number} azimuth @param {number} faded 0..1 */
function dot(azimuth, faded) {
  const [x, y] = at(azimuth, RADIUS + 6).split(" ");
  return svg("circle", {
    class: "rose-dot",
    cx: x ?? "0",
    cy: y ?? "0",
    r: 1.6,
    opacity: (0.7 * (1 - faded)).toFixed(2),
  });
}

/**
 * A place on the drawing: forward is up, left is left.
 * @param {number} azimuth [rad] counter-clockwise from forward
 * @param {number} radius
 */
const at = (azimuth, radius) =>
  `${(-radius * Math.sin(azimuth)).toFixed(2)} ${(-radius * Math.cos(azimuth)).toFixed(2)}`;

customElements.define("sound-rose", SoundRose);

const MOST_LINES = 6;
const TOUCH = matchMedia("(pointer: coarse)").matches;
const CHECK = t("hearing-card.check_the_microphones");

class HearingCard extends Panel {
  #rose = new SoundRose();
  #where = make("p.hearing-where");
  #ambiguity = make("p.note");
  #listen = make("button.toggle", { "aria-pressed": "false" }, t("hearing-card.listen"));
  #obey = make(
    "button.toggle",
    { "aria-pressed": "false", title: t("hearing-card.execute_commands_of_voices_in_the") },
    t("hearing-card.obey"),
  );
  #check = make("button", { onclick: () => void this.#examine() }, CHECK);
  #faults = make("ul.faults", { role: "status", hidden: true });
  #measure = make("a", { href: "hearing" }, t("hearing-card.how_well_does_it_hear_you"));
  #lines = make("ol.transcripts", { "aria-label": t("hearing-card.what_was_heard") });
  #checking = false;
  /** @type {PeopleNear | null} */
  #near = null;
  #none = make("p.note");

  /** @override */
  build() {
    this.#near = new PeopleNear(this.session);
    this.append(
      cardHead(t("hearing-card.what_it_hears"), this.#listen, this.#obey),
      this.#near,
      make("div.hearing", this.#rose, make("div.hearing-words", this.#where, this.#ambiguity, this.#none, this.#lines)),
      make("div.hearing-foot", this.#check, this.#measure),
      this.#faults,
    );
    /** @type {[HTMLElement, (on: boolean) => Promise<unknown>][]} */
    const switches = [
      [this.#obey, api.obeyVoices],
      [this.#listen, api.listen],
    ];
    for (const [button, set] of switches)
      button.addEventListener("click", () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        void this.session.attempt(() => set(on));
      });
    this.session.on("transcript", (transcript) => this.#add(transcript));
  }

  /** @override @param {View} view */
  show(view) {
    const { state, hello, up, permission } = view;
    this.#near?.show(view);
    const ears = state?.ears ?? null;
    this.hidden = onlyWatched(hello) || (ears === null && this.#lines.childElementCount === 0);
    if (this.hidden) return;
    this.classList.toggle("is-old", !up);
    mark(this.#rose, "hidden", ears === null);
    this.#listen.hidden = this.#obey.hidden = this.#check.hidden = ears === null;
    this.#measure.hidden = !hello?.robot.capabilities.includes("simulate");
    this.#check.disabled = !up || permission.may === "no" || this.#checking;
    this.#listen.disabled = this.#obey.disabled = !up || permission.may === "no";
    mark(this.#obey, "aria-pressed", String(ears?.voice_control ?? false));
    if (!ears?.muted) mark(this.#listen, "aria-pressed", String(ears?.listening ?? false));
    this.#rose.show(ears);
    const [voice] = ears?.voices ?? [];
    const on = this.#listen.getAttribute("aria-pressed") === "true";
    const quiet = on ? silence(ears) : "";
    write(this.#where, voice ? describe(voice) : quiet);
    this.#where.hidden = this.#where.textContent === "";
    write(this.#ambiguity, inLanguage(voice?.ambiguity ?? ""));
    this.#ambiguity.hidden = this.#ambiguity.textContent === "";
    const says = hint(on, ears?.voice_control ?? false);
    write(this.#none, TOUCH ? says.replace(" (V)", "") : says);
  }

  /** Check three seconds of sound for wiring faults. */
  async #examine() {
    if (!this.#faults.hidden) {
      this.#faults.hidden = true;
      write(this.#check, CHECK);
      return;
    }
    const simulated = this.session.hello?.robot.capabilities.includes("simulate") === true;
    this.#checking = true;
    write(
      this.#check,
      simulated ? t("hearing-card.the_simulated_person_speaks") : t("hearing-card.speak_for_three_seconds"),
    );
    await this.session.attempt(async () => {
      const { well, faults } = await api.checkArray(simulated);
      const rows = faults.map(({ sentence, serious }) => fault(inLanguage(sentence), serious ? "warning" : "info"));
      this.#faults.replaceChildren(
        ...(well ? [fault(t("hearing-card.every_channel_works_and_all_of"), "done")] : []),
        ...rows,
      );
      this.#faults.hidden = false;
    });
    this.#checking = false;
    write(this.#check, this.#faults.hidden ? CHECK : t("hearing-card.hide_the_result"));
  }

  /** @param {Transcript} transcript */
  #add({ words, accepted, heard_as, reason, final, confidence }) {
    this.#none.hidden = true;
    const said = accepted ? heard_as : words;
    const line = make(
      "li.transcript",
      { "data-state": accepted ? "accepted" : "refused" },
      icon(accepted ? "done" : "refused"),
      make(
        "span",
        make("span.transcript-words", said ? `“${said}”` : t("hearing-card.not_understood")),
        said && make("span.note", ` ${certainty(confidence)}`),
        reason && make("span.note", ` ${reason}`),
        !final && make("span.note", t("hearing-card.before_the_sentence_was_over")),
      ),
    );
    this.#lines.prepend(line);
    while (this.#lines.childElementCount > MOST_LINES) this.#lines.lastElementChild?.remove();
    this.session.announce(
      accepted
        ? t("hearing-card.heard_heardas", { heardas: heard_as })
        : t("hearing-card.heard_but_refused_reason", { reason }),
    );
  }
}

/** One finding of the self-check. @param {string} sentence @param {"warning" | "info" | "done"} kind */
const fault = (sentence, kind) => make("li.fault", { "data-kind": kind }, icon(kind), make("span", sentence));

/**
 * Sentence while the robot listens and hears no voice.
 * @param {import("../net/messages.js").HearingState | null} ears
 */
function silence(ears) {
  if (ears?.muted) return t("hearing-card.not_listening_while_the_robot_speaks");
  return ears?.starting
    ? t("hearing-card.hears_directions_of_voices_speech_recognition")
    : t("hearing-card.listening_no_voice");
}

/**
 * Hint before the first transcript.
 * @param {boolean} listening
 * @param {boolean} voice_control true when voices in the room give commands
 */
function hint(listening, voice_control) {
  if (!listening) return t("hearing-card.hold_the_microphone_v_and_speak");
  if (!voice_control) return t("hearing-card.hold_the_microphone_v_and_speak_2");
  return t("hearing-card.say_a_command_in_the_room");
}

/** Sentence about the direction of a voice. @param {import("../net/messages.js").VoiceHeard} voice */
function describe({ azimuth_rad, sd_heard_rad }) {
  return t("hearing-card.a_voice_inwords_degrees_value", {
    inwords: inWords(azimuth_rad),
    degrees: degrees(2 * sd_heard_rad, 0),
  });
}

customElements.define("hearing-card", HearingCard);
