// The fleet as this page knows it: asked twice a second, drawn whenever it has answered.

import * as api from "../net/api.js";

/** @typedef {{name: string, heard_as: string, who: string, progress: number | null}} CommandUnderWay */
/** @typedef {{level: string, text: string, code: string | null, values: import("../ui/texts.js").Values | null}} Notice */
/** @import { FleetRow as Robot, FleetState as Fleet } from "../net/rest.js" */

const ASK_MS = 500;
const HIDDEN_ASK_MS = 3000;
const LOST_MS = 2000; // without an answer after which the fleet is said not to answer

export class FleetSession extends EventTarget {
  /** @type {Fleet | null} */
  fleet = null;
  /** @type {api.Me | null} */
  you = null;
  trouble = ""; // of the last thing that was asked for
  #answeredAt = performance.now();
  #timer = 0;

  /** True while the fleet answers. */
  get up() {
    return this.fleet !== null && performance.now() - this.#answeredAt < LOST_MS;
  }

  /** Seconds since the fleet answered last. */
  get silence() {
    return (performance.now() - this.#answeredAt) / 1000;
  }

  /** @param {string} name @param {(detail: any) => void} listener */
  on(name, listener) {
    this.addEventListener(name, (event) => listener(/** @type {CustomEvent} */ (event).detail));
  }

  async begin() {
    clearTimeout(this.#timer);
    try {
      this.you = await api.me();
      this.fleet = await api.call("api/fleet");
      this.#answeredAt = performance.now();
    } catch (trouble) {
      if (trouble instanceof api.Refusal && trouble.status === 401) {
        this.#tell("signed-out");
        return;
      }
    }
    this.#tell("changed");
    this.#timer = setTimeout(() => void this.begin(), document.hidden ? HIDDEN_ASK_MS : ASK_MS);
  }

  /** @param {"stop" | "halt" | "halt/reset"} what of all robots */
  async all(what) {
    this.trouble = "";
    try {
      const answer = await api.post(`api/fleet/${what}`);
      if (this.fleet && what !== "halt/reset") this.fleet.stop = answer;
      this.#tell("answered");
    } catch (refusal) {
      this.trouble = api.sentenceOf(refusal);
    }
    await this.begin();
  }

  /** @param {Robot} robot stands; its console answers through the fleet */
  async stop(robot) {
    try {
      await api.post(`robots/${encodeURIComponent(robot.name)}/api/stop`);
      this.trouble = "";
    } catch (refusal) {
      this.trouble = api.sentenceOf(refusal);
    }
    this.#tell("changed");
  }

  /** @param {string} words for a screen reader */
  announce(words) {
    const place = document.getElementById("announcements");
    if (place) place.textContent = words;
  }

  /** @param {string} name @param {unknown} [detail] */
  #tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}
