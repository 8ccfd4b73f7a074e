// Element <clap-compass>: requested and measured clap directions around the robot, and the array’s orientation.

import { svg } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @import { MicrophonesState as MicrophoneCalibration } from "../net/rest.js" */

const RING = 78;
const HEARD = 60;

export class ClapCompass extends HTMLElement {
  #marks = svg("g", {});
  #array = svg("g", { class: "compass-array" });

  connectedCallback() {
    if (this.firstChild) return;
    const drawing = svg("svg", {
      viewBox: "-100 -100 200 200",
      role: "img",
      "aria-label": t("clap-compass.where_claps_are_asked_for_and"),
    });
    this.#array.append(
      svg("rect", { x: -17, y: -17, width: 34, height: 34, rx: 6 }),
      svg("path", { d: "M0 -9V-30M-5 -24L0 -30L5 -24" }),
    );
    drawing.append(
      svg("circle", { class: "compass-ring", cx: 0, cy: 0, r: RING }),
      svg("path", { class: "compass-ahead", d: "M0 -97l5 9h-10z" }),
      this.#array,
      this.#marks,
    );
    this.append(drawing);
  }

  /** @param {MicrophoneCalibration} calibration @param {number} next where the next clap is asked for [rad] */
  show({ asked_rad, claps, solution, active }, next) {
    const shown = solution ?? active;
    this.#array.setAttribute("transform", `rotate(${degrees(shown?.yaw_rad ?? 0)})`);
    this.#array.setAttribute("data-known", String(shown !== null));
    const places = [...new Set([...asked_rad, next])].map((angle) => {
      const place = svg("circle", { class: "compass-asked", cx: x(angle, RING), cy: y(angle, RING), r: 8 });
      const taken = claps.some(({ asked_rad: asked }) => asked === angle);
      place.setAttribute("data-state", angle === next ? "next" : taken ? "taken" : "open");
      return place;
    });
    const heard = solution
      ? claps.map(({ asked_rad: asked, gap_rad: gap }) => {
          const angle = asked - (gap ?? 0);
          return svg("path", { class: "compass-heard", d: `M0 0L${x(angle, HEARD)} ${y(angle, HEARD)}` });
        })
      : [];
    this.#marks.replaceChildren(...heard, ...places);
  }
}

/** @param {number} angle [rad] counter-clockwise from ahead */
const degrees = (angle) => ((-angle * 180) / Math.PI).toFixed(1);

/** @param {number} angle @param {number} radius */
const x = (angle, radius) => (-radius * Math.sin(angle)).toFixed(2);

/** @param {number} angle @param {number} radius */
const y = (angle, radius) => (-radius * Math.cos(angle)).toFixed(2);

customElements.define("clap-compass", ClapCompass);
