// Element <link-chip>: quality of the link: round trip, rate, age; details on a press.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";

/** @typedef {import("../net/session.js").View} View */

const WORDS = { connecting: "starting up", live: "live", stale: "silent", lost: "lost" };

const SENSORS = { wheels: "Odometry", laser: "Laser", camera: "Camera", microphones: "Microphones" };
const STATES = { live: "delivers", stale: "late", lost: "lost" };

/**
 * @param {import("../net/messages.js").SensorLine} sensor
 * @returns {[string, string]}
 */
function sensorRow({ kind, name, state, age_s, rate_hz }) {
  const own = name && name !== kind && kind !== "microphones" ? ` ${name}` : "";
  return [`${SENSORS[kind]}${own}`, `${STATES[state]}, ${age(age_s)} old (${fixed(rate_hz, 0)} Hz)`];
}

class LinkChip extends Panel {
  #icon = icon("link");
  #text = make("span", { class: "link-text" });
  #viewers = make("span", { class: "viewers" });
  #button = make("button", { type: "button", class: "bar-chip", "aria-label": "Link" }, this.#icon, this.#text);
  #rows = make("dl", { class: "pairs" });
  #panel = make(
    "div",
    { role: "group", "aria-label": "Link in detail" },
    make("h2", { class: "card-title" }, "Link"),
    this.#rows,
  );

  /** @override */
  build() {
    this.append(this.#button, this.#panel, this.#viewers);
    popover(this.#button, this.#panel);
  }

  /**
   * @override
   * @param {View} view
   */
  show(view) {
    const { link, state } = view;
    const old = link.is === "up" && link.age_s > 0.5;
    const trip = link.round_trip_ms === null ? "" : `${fixed(link.round_trip_ms, 0)} ms · `;
    const text = link.is !== "up" ? "no link" : old ? `${age(link.age_s)} old` : `${trip}${fixed(link.rate_hz, 0)} Hz`;
    write(this.#text, text);
    redraw(this.#icon, link.is === "up" ? "link" : "unlinked");
    mark(this.#button, "data-tone", link.is !== "up" || old ? "stale" : null);
    mark(this.#button, "aria-label", `Link: ${text}`);
    const others = (state?.viewers ?? 1) - 1;
    this.#viewers.hidden = !view.up || others < 1;
    write(this.#viewers, `${others} watching`);
    if (!this.#panel.hidden) this.#detail(view);
  }

  /** @param {View} view */
  #detail({ link, state, hello }) {
    /** @type {Array<[string, string]>} */
    const rows = [
      ["Page to console and back", link.round_trip_ms === null ? "–" : `${fixed(link.round_trip_ms, 0)} ms`],
      ["State", `${fixed(link.rate_hz, 1)} Hz, ${age(link.age_s)} old`],
      ["Robot", state ? `${WORDS[state.robot.link]}, ${fixed(state.robot.rate_hz, 0)} frames/s` : "–"],
      .../** @type {Array<[string, string]>} */ ((state?.robot.sensors ?? []).map(sensorRow)),
      ...(state?.robot.battery == null
        ? []
        : [/** @type {[string, string]} */ (["Battery", `${fixed(100 * state.robot.battery, 0)} %`])]),
      ["Without a word", hello?.robot.failsafe || "–"],
      ...(hello?.robot.lock
        ? [/** @type {[string, string]} */ (["STOP", `also closes the robot's lock ${hello.robot.lock}`])]
        : []),
      ["Gate", state ? `${state.gate.state}${state.gate.reason ? ` (${state.gate.reason})` : ""}` : "–"],
      ["Pages open", String(state?.viewers ?? "–")],
      ["Beckon", hello?.version ?? "–"],
    ];
    while (this.#rows.children.length > rows.length * 2) this.#rows.lastElementChild?.remove();
    while (this.#rows.children.length < rows.length * 2) this.#rows.append(make("dt"), make("dd"));
    for (const [index, text] of rows.flat().entries()) write(/** @type {Element} */ (this.#rows.children[index]), text);
  }
}

customElements.define("link-chip", LinkChip);
