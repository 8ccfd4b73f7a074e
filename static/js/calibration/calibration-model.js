// Client model of the calibration page: the open step, its session, and requests to the server.

import { PageModel } from "../ui/page-model.js";
import { t } from "../ui/texts.js";
import * as api from "./api.js";
import { hashOf } from "./router.js";

/** @import { Place } from "./router.js" */
/** @import { Calibration, Verdict } from "./types.js" */
/** @import { SessionRow as Row } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */

const ASK_MS = 2000; // polling interval while the socket is silent

export class CalibrationModel extends PageModel {
  /** @type {Place} */
  place = { at: "home" };
  /** @type {Calibration | null} */
  calibration = null;
  /** @type {Row[] | null} null until they were read */
  rows = null;
  /** @type {Awaited<ReturnType<typeof api.inUse>> | null} */
  inUse = null;
  #heardAt = 0;

  /** @param {Session} session */
  constructor(session) {
    super(session);
    session.on("calibration", (calibration) => this.take(calibration));
    setInterval(() => void this.#ask(), ASK_MS);
  }

  /** True on the simulator, which has a simulated person. */
  get simulated() {
    return this.session.hello?.robot.capabilities.includes("simulate") === true;
  }

  /** True while the solution of this session is active. It may have been replaced, undone or solved again since. */
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
    this.tell();
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
    this.tell();
  }

  /** @param {Calibration} calibration */
  take(calibration) {
    if (!("id" in this.place) || this.place.id !== calibration.id) return;
    this.#heardAt = performance.now();
    this.calibration = calibration;
    this.tell();
  }

  /** @param {Verdict} verdict from the HTTP answer, which may arrive before the socket message */
  judge(verdict) {
    if (!this.calibration) return;
    if (verdict.number > (this.calibration.verdict?.number ?? -1)) this.calibration = { ...this.calibration, verdict };
    this.tell();
  }

  /**
   * Run a request; on a refusal, show the reason.
   * @template T
   * @param {() => Promise<T>} act
   * @param {(refusal: Error) => void} [otherwise]
   * @returns {Promise<T | null>}
   */
  async tried(act, otherwise) {
    try {
      return await act();
    } catch (error) {
      const refusal = error instanceof Error ? error : new Error(t("api.that_did_not_work"));
      this.session.complain(refusal.message);
      otherwise?.(refusal);
      return null;
    }
  }

  /**
   * Send a request about the open session; show the session when it is the answer.
   * @param {(id: string) => Promise<any>} act
   */
  async request(act) {
    const id = this.calibration?.id;
    if (id === undefined) return null;
    const answer = await this.tried(() => act(id));
    if (answer && typeof answer === "object" && "progress" in answer) this.take(answer);
    return answer;
  }

  /** Poll the session when the socket has been silent. */
  async #ask() {
    const id = this.calibration?.id;
    if (id === undefined || document.visibilityState === "hidden") return;
    if (performance.now() - this.#heardAt < ASK_MS) return;
    const session = await api.read(id).catch(() => null);
    if (session) this.take(session);
  }
}
