// The workbench as the page knows it: which place is open, the session on it, and every wish to the server.

import * as api from "./api.js";
import { hashOf, placeOf } from "./place.js";

/** @typedef {import("../session.js").Session} Session */
/** @typedef {import("./shape.js").Calibration} Calibration */
/** @typedef {import("./shape.js").Row} Row */
/** @typedef {import("./shape.js").Verdict} Verdict */
/** @typedef {import("./place.js").Place} Place */

const ASK_MS = 2000; // without a socket the session is asked for as often

export class Bench {
  /** @type {Place} */
  place = { at: "home" };
  /** @type {Calibration | null} */
  calibration = null;
  /** @type {Row[] | null} null until they were read */
  rows = null;
  /** @type {Awaited<ReturnType<typeof api.inUse>> | null} */
  inUse = null;
  /** @type {Set<() => void>} */
  #listeners = new Set();
  #heardAt = 0;

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    session.on("calibration", (calibration) => this.take(calibration));
    session.on("hello", () => void this.open(placeOf(location.hash)));
    addEventListener("hashchange", () => void this.open(placeOf(location.hash)));
    setInterval(() => void this.#ask(), ASK_MS);
  }

  /** @param {() => void} listener called whenever something here changed */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /** May this person do more than look? */
  get may() {
    return this.session.hello !== null && this.session.hello.you.role !== "viewer";
  }

  /** Is there a simulated world with an assistant in it? */
  get simulated() {
    return this.session.hello?.robot.kind === "SIM";
  }

  /** Is this session's solution the one in use? It may have been replaced, taken back, or solved anew since. */
  get used() {
    const { solution = null, kind = "camera", accepted_s: accepted = null } = this.calibration ?? {};
    const used = this.inUse?.[kind] ?? null;
    if (!solution || !used || typeof accepted !== "number") return false;
    const names = kind === "camera" ? ["fx", "fy", "cx", "cy", "k1"] : ["rotation", "translation_m"];
    return names.every((name) => JSON.stringify(solution[name]) === JSON.stringify(used[name]));
  }

  /** @param {Place} place */
  go(place) {
    const hash = hashOf(place);
    if (location.hash === hash || (hash === "#" && !location.hash)) void this.open(place);
    else location.hash = hash;
  }

  /** @param {Place} place */
  async open(place) {
    this.place = place;
    const id = "id" in place ? place.id : null;
    if (id !== this.calibration?.id) this.calibration = null;
    this.session.wantCalibration(id);
    this.#tell();
    if (place.at !== "capture") void this.readLists();
    if (id === null) return;
    await this.tried(
      async () => this.take(await api.read(id)),
      () => this.go({ at: "home" }),
    );
  }

  async readLists() {
    const [rows, inUse] = await Promise.all([api.list().catch(() => []), api.inUse().catch(() => null)]);
    [this.rows, this.inUse] = [rows, inUse];
    this.#tell();
  }

  /** @param {Calibration} calibration */
  take(calibration) {
    if (!("id" in this.place) || this.place.id !== calibration.id) return;
    this.#heardAt = performance.now();
    this.calibration = calibration;
    this.#tell();
  }

  /** @param {Verdict} verdict that came as an answer, perhaps before the socket told it */
  judge(verdict) {
    if (!this.calibration) return;
    if (verdict.number > (this.calibration.verdict?.number ?? -1)) this.calibration = { ...this.calibration, verdict };
    this.#tell();
  }

  /**
   * Try something; when it is refused, say why.
   * @template T
   * @param {() => Promise<T>} act
   * @param {(refusal: Error) => void} [otherwise]
   * @returns {Promise<T | null>}
   */
  async tried(act, otherwise) {
    try {
      return await act();
    } catch (error) {
      const refusal = error instanceof Error ? error : new Error("That did not work.");
      this.session.complain(refusal.message);
      otherwise?.(refusal);
      return null;
    }
  }

  /**
   * A wish about the open session; where the answer is the session, it is shown.
   * @param {(id: string) => Promise<any>} act
   */
  async wish(act) {
    const id = this.calibration?.id;
    if (id === undefined) return null;
    const told = await this.tried(() => act(id));
    if (told && typeof told === "object" && "progress" in told) this.take(told);
    return told;
  }

  /** The socket is the quick way; when it has been silent the session is asked for. */
  async #ask() {
    const id = this.calibration?.id;
    if (id === undefined || document.visibilityState === "hidden") return;
    if (performance.now() - this.#heardAt < ASK_MS) return;
    const told = await api.read(id).catch(() => null);
    if (told) this.take(told);
  }

  #tell() {
    for (const listener of this.#listeners) listener();
  }
}
