// Who is known, and the lesson under way, as the page knows them; and every wish about them.

import { call, post } from "../api.js";

/** @typedef {import("../session.js").Session} Session */
/** @typedef {[number, number]} Pixel */
/**
 * @typedef {object} Judged a picture and what came of it
 * @property {number} number
 * @property {string} gesture "" for the background
 * @property {boolean} good
 * @property {string} words
 * @property {[number, number]} size
 * @property {Pixel[]} outline
 * @property {{name: string, box_px: [number, number, number, number]}[]} parts
 */
/**
 * @typedef {object} Enrolment
 * @property {string} id
 * @property {string} who is at it
 * @property {string} owner the same person, as the console tells people of one name apart
 * @property {boolean} background
 * @property {string} next gesture; "" when there is enough
 * @property {string} advice
 * @property {string[]} gestures
 * @property {Judged[]} pictures
 * @property {Judged | null} newest
 * @property {number} fewest
 * @property {boolean} ready
 * @property {boolean} showing
 * @property {string} trouble
 * @property {string} waits what for; "" for nothing
 */
/** @typedef {{id: string, name: string, learnt_s: number, by: string, pictures: number}} Known */
/**
 * @typedef {object} Told
 * @property {Known[]} people
 * @property {string | null} chosen
 * @property {Enrolment | null} enrolment
 * @property {boolean} camera
 * @property {boolean} simulated
 * @property {boolean} stands whether who showed everything is in the simulated room still
 */

const ROOT = "api/people";
const ASK_MS = 400;
const LOOK_MS = 3000; // between looks whether somebody else is still at it
const SITTER = "show me"; // what the simulated person is called in the room
const SPOKEN_MS = 2500; // until a call has been heard

/** @param {string} id @param {number} number */
export const pictureOf = (id, number) => `${ROOT}/${id}/pictures/${number}.jpg`;

export class Lessons {
  /** @type {Told | null} null until it was read */
  told = null;
  busy = false;
  outcome = ""; // of the newest call
  /** @type {Set<() => void>} */
  #listeners = new Set();
  #asked = 0; // questions so far
  #answered = 0; // the newest question whose answer is shown
  #askedAt = -Infinity;
  #open = 0; // questions without an answer

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    session.on("hello", () => void this.read());
    setInterval(() => this.#look(), ASK_MS);
    document.addEventListener("visibilitychange", () => this.#visible && void this.read()); // another tab was in front
  }

  /** @returns {Enrolment | null} */
  get enrolment() {
    return this.told?.enrolment ?? null;
  }

  /** Is it this person's own lesson? */
  get mine() {
    return this.enrolment !== null && this.enrolment.owner === this.session.hello?.you.id;
  }

  /** May this person do more than look? */
  get may() {
    return this.session.hello !== null && this.session.hello.you.role !== "viewer";
  }

  /** @param {() => void} listener */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  async read() {
    const question = ++this.#asked;
    this.#askedAt = performance.now();
    this.#open += 1;
    const told = await call(ROOT).catch(() => null);
    this.#open -= 1;
    if (!told || question < this.#answered) return;
    this.#answered = question;
    const before = this.enrolment;
    this.told = told;
    const { enrolment } = this;
    if (enrolment?.newest && enrolment.newest.number !== before?.newest?.number)
      this.session.announce(`${enrolment.newest.words} ${enrolment.advice}`);
    this.#tell();
  }

  get #visible() {
    return this.session.hello !== null && document.visibilityState === "visible";
  }

  /** Reads what changes without this page; never while an answer is on its way. */
  #look() {
    const { enrolment } = this;
    if (!enrolment || this.#open > 0 || !this.#visible) return;
    const soon = this.mine && (this.busy || enrolment.showing);
    const late = !this.mine && performance.now() - this.#askedAt > LOOK_MS;
    if (soon || late) void this.read();
  }

  begin() {
    return this.#tried(() => post(ROOT));
  }

  cancel() {
    return this.#tried(() => call(this.#path(), { method: "DELETE" }));
  }

  /**
   * @param {"background" | "picture"} what
   * @param {Blob | null} picture null: the robot's own camera takes it
   */
  take(what, picture) {
    if (!picture) return this.#tried(() => post(`${this.#path()}/capture`, { what }));
    const headers = { "content-type": picture.type };
    const where = what === "picture" ? "pictures" : what;
    return this.#tried(() => call(`${this.#path()}/${where}`, { method: "POST", body: picture, headers }));
  }

  /** @param {number} number */
  drop(number) {
    return this.#tried(() => post(`${this.#path()}/pictures/${number}/drop`));
  }

  /** @param {boolean} on */
  showMe(on) {
    return this.#tried(() => post(`${this.#path()}/show-me`, { on }));
  }

  /** @param {string} name @returns {Promise<boolean>} whether it was kept */
  finish(name) {
    return this.#tried(() => post(`${this.#path()}/finish`, { name }));
  }

  /** @param {string | null} id null: anybody */
  choose(id) {
    const headers = { "content-type": "application/json" };
    return this.#tried(() => call(`${ROOT}/chosen`, { method: "PUT", body: JSON.stringify({ id }), headers }));
  }

  /** @param {string} id @param {string} name */
  rename(id, name) {
    return this.#tried(() => post(`${ROOT}/${id}/rename`, { name }));
  }

  /** @param {string} id */
  forget(id) {
    return this.#tried(() => call(`${ROOT}/${id}`, { method: "DELETE" }));
  }

  /** In the simulated room: who showed everything leaves. */
  sendAway() {
    return this.#tried(() => call(`${ROOT}/assistant`, { method: "DELETE" }));
  }

  /** In the simulated room: who showed everything calls, and the robot is told to come. */
  call() {
    return this.#tried(async () => {
      await post("api/sim/say", { text: "come here", id: SITTER });
      await new Promise((resolve) => setTimeout(resolve, SPOKEN_MS));
      const deed = await post("api/commands", { text: "come here" });
      void this.#watch(deed.id);
    });
  }

  /** @param {number} id of a command: tells how it goes until it is over */
  async #watch(id) {
    for (let state = "running"; state === "running"; ) {
      const row = await call(`api/commands/${id}`).catch(() => null);
      if (!row) return;
      state = row.state;
      this.outcome = row.remark || (state === "running" ? "I turn to the voice and look who it is." : state);
      this.#tell();
      await new Promise((resolve) => setTimeout(resolve, ASK_MS));
    }
    this.session.announce(this.outcome);
  }

  #path() {
    return `${ROOT}/${this.enrolment?.id ?? ""}`;
  }

  /** @param {() => Promise<unknown>} act */
  async #tried(act) {
    this.busy = true;
    this.#tell();
    let done = true;
    try {
      await act();
    } catch (refusal) {
      done = false;
      this.session.complain(refusal instanceof Error ? refusal.message : "That did not work.");
    }
    this.busy = false;
    await this.read();
    return done;
  }

  #tell() {
    for (const listener of this.#listeners) listener();
  }
}
