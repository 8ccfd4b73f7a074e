// Client model of the people page: known people, the running enrollment, and every request about them.

import { call, post, send } from "../net/api.js";
import * as room from "../net/room-api.js";
import { PageModel } from "../ui/page-model.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { EnrollmentState as Enrollment, PeopleState } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */
/** @typedef {[number, number]} Pixel */

const ROOT = "api/people";
const ASK_MS = 400;
const LOOK_MS = 3000; // between reads while another operator runs an enrollment
const ACTOR = "show me"; // id of the simulated person in the room
const SPOKEN_MS = 2500; // until a call has been transcribed

/** @param {string} id @param {number} number */
export const pictureOf = (id, number) => `${ROOT}/${id}/pictures/${number}.jpg`;

export class EnrollmentModel extends PageModel {
  /** @type {PeopleState | null} null until it was read */
  state = null;
  outcome = ""; // of the newest call
  /** @type {string[]} */
  inhabitants = []; // people in the simulated room who can show themselves
  #asked = 0; // requests so far
  #answered = 0; // the newest request whose answer is shown
  #askedAt = -Infinity;
  #open = 0; // open requests

  /** @param {Session} session */
  constructor(session) {
    super(session);
    session.on("hello", () => void this.read());
    session.on("hello", () => void this.#readInhabitants());
    this.poll(ASK_MS, () => this.#looks);
    document.addEventListener("visibilitychange", () => this.visible && void this.read()); // the tab was hidden
  }

  /** @returns {Enrollment | null} */
  get enrollment() {
    return this.state?.enrollment ?? null;
  }

  get mine() {
    return this.enrollment !== null && this.enrollment.owner === this.session.hello?.you.id;
  }

  /** @override */
  async read() {
    const request = ++this.#asked;
    this.#askedAt = performance.now();
    this.#open += 1;
    const state = await call(ROOT).catch(() => null);
    this.#open -= 1;
    if (!state || request < this.#answered) return;
    this.#answered = request;
    const before = this.enrollment;
    this.state = state;
    const { enrollment } = this;
    if (enrollment?.newest && enrollment.newest.number !== before?.newest?.number)
      this.session.announce(`${inLanguage(enrollment.newest.words)} ${inLanguage(enrollment.advice)}`);
    this.tell();
  }

  /** True where changes may be made elsewhere; never while a request is open. */
  get #looks() {
    const { enrollment } = this;
    if (!enrollment || this.#open > 0) return false;
    return this.mine ? this.busy !== "" || enrollment.demo : performance.now() - this.#askedAt > LOOK_MS;
  }

  begin() {
    return this.#tried(async () => {
      await post(ROOT);
      await this.#readInhabitants();
    });
  }

  async #readInhabitants() {
    if (this.session.hello?.robot.kind !== "SIM") return;
    this.inhabitants = (await room.people().catch(() => [])).map(({ id }) => id).filter((id) => id !== ACTOR);
  }

  cancel() {
    return this.#tried(() => call(this.#path(), { method: "DELETE" }));
  }

  /** @param {"background" | "picture"} what @param {Blob | null} picture null: the robot's own camera takes it */
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

  /** @param {boolean} on @param {string} inhabitant who shows themselves; "": someone who comes in for that */
  showMe(on, inhabitant) {
    return this.#tried(() => post(`${this.#path()}/demo`, { on, inhabitant }));
  }

  /** @param {string} name @returns {Promise<boolean>} true when the person was stored */
  finish(name) {
    return this.#tried(() => post(`${this.#path()}/finish`, { name }));
  }

  /** @param {string | null} id null: anybody */
  choose(id) {
    return this.#tried(() => send(`${ROOT}/chosen`, "PUT", { id }));
  }

  /** @param {string} id @param {string} name */
  rename(id, name) {
    return this.#tried(() => post(`${ROOT}/${id}/rename`, { name }));
  }

  /** @param {string} id */
  forget(id) {
    return this.#tried(() => call(`${ROOT}/${id}`, { method: "DELETE" }));
  }

  /** Remove the simulated person from the room. */
  sendAway() {
    return this.#tried(() => call(`${ROOT}/demo`, { method: "DELETE" }));
  }

  /** The simulated person calls, and the robot gets the command to come. */
  call() {
    return this.#tried(async () => {
      await post("api/sim/say", { text: "come here", id: ACTOR });
      await new Promise((resolve) => setTimeout(resolve, SPOKEN_MS));
      const entry = await post("api/commands", { text: "come here" });
      void this.#watch(entry.id);
    });
  }

  /** @param {number} id of a command: report its progress until it ends */
  async #watch(id) {
    for (let state = "running"; state === "running"; ) {
      const row = await call(`api/commands/${id}`).catch(() => null);
      if (!row) return;
      state = row.state;
      this.outcome = row.remark || (state === "running" ? t("enrollment-model.the_robot_turns_to_the_voice") : state);
      this.tell();
      await new Promise((resolve) => setTimeout(resolve, ASK_MS));
    }
    this.session.announce(this.outcome);
  }

  #path() {
    return `${ROOT}/${this.enrollment?.id ?? ""}`;
  }

  /** @param {() => Promise<unknown>} act */
  async #tried(act) {
    this.busy = t("people-enrollment.one_moment");
    this.tell();
    const done = await this.session.attempt(act);
    this.busy = "";
    await this.read();
    return done;
  }
}
