// Drawing of voice directions around the robot: wedges of two standard deviations, the newest boldest.

import { mark, svg } from "./element.js";
import { t } from "./texts.js";

/** @import { HearingState as Ears, VoiceHeard } from "../net/messages.js" */

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
