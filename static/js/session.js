// One visit: what is known, and every door through which the page acts on the robot.

import * as api from "./api.js";
import { Asking } from "./asking.js";
import { unlessStopped } from "./hear/answers.js";
import { Link } from "./link.js";
import { permission } from "./permission.js";

/** @typedef {import("./wire.js").Hello} Hello */
/** @typedef {import("./wire.js").State} State */
/** @typedef {import("./wire.js").Answer} Answer */
/** @typedef {import("./link.js").LinkHealth} LinkHealth */
/** @typedef {import("./drive.js").Permission} Permission */
/** @typedef {import("./drive.js").DriveFrame} DriveFrame */
/** @typedef {{text: string, answer: Answer, source: "typed" | "chip" | "click", at: number}} Said `at`: sent [ms] */
/** @typedef {{seq: number, stamp: number, jpeg: Uint8Array<ArrayBuffer>}} Picture */
/** @typedef {import("./calibration/shape.js").Calibration} Calibration */
/**
 * @typedef {object} View everything a panel may show at one instant
 * @property {Hello | null} hello
 * @property {State | null} state the newest there was, even when the link is lost
 * @property {LinkHealth} link
 * @property {boolean} up
 * @property {Permission} permission
 * @property {boolean} mine we hold the lease
 * @property {boolean} secure nobody on the way can read along
 */

const STOPS = "stop moving";

/**
 * What happens once and is told to whoever listens.
 * @typedef {object} Happenings
 * @property {Hello} hello
 * @property {View} heard a new state; told at once, even when the page is not drawn
 * @property {null} lost
 * @property {null} signed-out
 * @property {Picture} picture
 * @property {Calibration} calibration the session that was asked for, anew
 * @property {Said} said
 * @property {api.HistoryRow[]} history
 * @property {api.Kind[]} kinds
 * @property {boolean} stopped STOP was pressed here, and whether it surely left
 * @property {string} trouble a sentence
 * @property {import("./hear/talk.js").Transcript} transcript what was heard in our own microphone
 * @property {null} reading what was said while the button was held is read now
 * @property {boolean} speaking whether the robot's voice is heard in this browser
 * @property {null} interrupt the robot is to fall silent: somebody speaks to it
 * @property {string} told a sentence for those who do not see the page
 */

const drawPress = () => Math.floor(Math.random() * 2 ** 53); // one press goes two ways and is recorded once

export class Session {
  /** @type {Hello | null} */
  hello = null;
  /** @type {State | null} */
  state = null;
  /** @type {api.Kind[]} */
  kinds = [];
  /** @type {api.HistoryRow[]} */
  history = [];
  historyAt = 0; // [ms] when the page learned that there was news in it
  #events = new EventTarget();
  #asking = new Asking();
  #revision = -1;
  #stoppedAt = -Infinity; // [ms] the newest STOP of this page, by whatever way
  #wantsCamera = true;
  /** @type {string | null} */
  #wantsCalibration = null;

  constructor() {
    this.link = new Link({
      url: api.socketAddress("ws"),
      hear: (message) => this.#hear(message),
      see: (picture) => this.#tell("picture", picture),
      lose: () => this.#lose(),
    });
  }

  /**
   * @template {keyof Happenings} K
   * @param {K} what
   * @param {(detail: Happenings[K]) => void} then
   */
  on(what, then) {
    this.#events.addEventListener(what, (event) => then(/** @type {CustomEvent} */ (event).detail));
  }

  /** @returns {View} */
  get view() {
    const link = this.link.health;
    const { hello, state } = this;
    const up = link.is === "up" && state !== null;
    const mine = up && hello !== null && state.lease.holder_id === hello.you.id;
    return { hello, state, link, up, mine, permission: permission({ hello, state, up }), secure: isSecureContext };
  }

  /** The newest state's number: it dates what we send, should the link hold it up. */
  get seen() {
    return this.state?.seq ?? 0;
  }

  /**
   * Words for the robot.
   * @param {string} text
   * @param {"typed" | "chip" | "click"} source
   */
  async say(text, source) {
    const at = performance.now();
    const answer = await this.#asking.ask((ref) =>
      this.link.send({ kind: "command", text, source, ref, seen: this.seen }),
    );
    if (answer.ok && answer.detail === STOPS) this.#stoppedAt = Math.max(this.#stoppedAt, at);
    this.#tell("said", { text, answer, source, at });
    return answer;
  }

  /** STOP, by both ways at once: whichever is quicker. */
  stop() {
    this.#stoppedAt = performance.now();
    const { robot, you } = this.hello ?? {};
    if (robot?.drives === false) {
      if (you?.role !== "viewer" && this.state?.robot.running) void this.playback("pause");
      return; // there is nothing else to stop
    }
    const press = drawPress();
    const left = this.link.send({ kind: "stop", press });
    this.#tell("stopped", left);
    const why = "The robot stops by itself when the link is gone.";
    api.stop(press).then(
      () => left || this.#tell("stopped", true),
      (refusal) => left || this.complain(`Stop could not be sent: ${refusal.message} ${why}`),
    );
  }

  /** A STOP that stays, by both ways, too. */
  halt() {
    const press = drawPress();
    const left = this.link.send({ kind: "halt", press });
    const why = "The robot stops by itself when the link is gone, but may be driven again after that.";
    api.halt(press).then(
      (halted) => left || halted.latched || this.complain(halted.why ?? "The halt is not saved."), // the socket says it
      (refusal) => left || this.complain(`Halt could not be sent: ${refusal.message} ${why}`),
    );
  }

  resetHalt() {
    return this.#asked((ref) => this.link.send({ kind: "halt_reset", ref }));
  }

  /** @param {"acquire" | "take" | "release"} wish */
  lease(wish) {
    return this.#asked((ref) => this.link.send({ kind: "lease", do: wish, ref }));
  }

  /**
   * @param {"play" | "pause" | "speed" | "seek"} wish
   * @param {number} [value] times real time, or the place 0..1
   */
  playback(wish, value) {
    return this.#asked((ref) => this.link.send({ kind: "playback", do: wish, ref, value: value ?? null }));
  }

  /** @param {number} id of the spoken order that waits: it begins now */
  async beginIntent(id) {
    await api.beginIntent(id).catch((refusal) => this.complain(refusal.message));
  }

  /** @param {number} id of the spoken order that waits: it does not begin */
  async dropIntent(id) {
    await api.dropIntent(id).catch((refusal) => this.complain(refusal.message));
  }

  /** @param {DriveFrame} frame */
  drive(frame) {
    this.link.send({ kind: "drive", ...frame });
  }

  /** @param {boolean} camera whether anybody looks at the picture */
  want(camera) {
    if (camera === this.#wantsCamera) return;
    this.#wantsCamera = camera;
    this.link.send({ kind: "want", camera });
  }

  /** @param {string | null} id of the calibration session whose every change is to be told */
  wantCalibration(id) {
    if (id === this.#wantsCalibration) return;
    this.#wantsCalibration = id;
    this.link.send({ kind: "want", calibration: id });
  }

  /** @param {import("./hear/talk.js").Transcript} transcript */
  transcribe(transcript) {
    const now = performance.now();
    if (transcript.accepted && transcript.heard_as === STOPS) this.#stoppedAt = now;
    this.#tell("transcript", unlessStopped(transcript, now, this.#stoppedAt));
  }

  /** The button to talk was let go: what was said is read now. */
  awaitWords() {
    this.#tell("reading", null);
  }

  /** @param {boolean} speaking whether the robot's voice is heard here now */
  speaks(speaking) {
    this.#tell("speaking", speaking);
  }

  /** Somebody is about to speak to the robot. */
  interrupt() {
    this.#tell("interrupt", null);
  }

  /** @param {string} sentence that passes over the page */
  complain(sentence) {
    this.#tell("trouble", sentence);
  }

  /** @param {string} sentence for those who hear the page rather than see it */
  announce(sentence) {
    this.#tell("told", sentence);
  }

  /** Starts, or starts again after a login. Tells "signed-out" when nobody is signed in. */
  async begin() {
    try {
      await api.me();
      this.link.open();
    } catch (refusal) {
      if (refusal instanceof api.Refusal && refusal.status === 401) this.#tell("signed-out", null);
      else this.link.open(); // it keeps trying, and the banner says so
    }
  }

  async leave() {
    await api.logout().catch(() => undefined);
    this.link.close();
    await this.begin();
  }

  /** @param {Exclude<import("./wire.js").Down, {kind: "echo"}>} message */
  #hear(message) {
    if (message.kind === "answer") {
      if (message.ref === 0 && !message.ok) this.#tell("trouble", message.detail ?? "That was refused."); // a click in the scene
      this.#asking.hear(message);
    } else if (message.kind === "hello") {
      this.hello = message;
      this.#revision = -1;
      if (!this.#wantsCamera) this.link.send({ kind: "want", camera: false });
      if (this.#wantsCalibration !== null) this.link.send({ kind: "want", calibration: this.#wantsCalibration });
      this.#tell("hello", message);
      void this.#fetchKinds();
    } else if (message.kind === "calibration") {
      this.#tell("calibration", /** @type {Calibration} */ (message.session));
    } else {
      this.state = message;
      this.#tell("heard", this.view);
      if (message.history_revision !== this.#revision) void this.#fetchHistory(message.history_revision);
    }
  }

  #lose() {
    this.#asking.lose();
    this.#tell("lost", null);
    api.me().catch((refusal) => {
      if (refusal.status !== 401) return;
      this.link.close();
      this.#tell("signed-out", null);
    });
  }

  async #fetchKinds() {
    if (!this.hello?.robot.drives) return;
    this.kinds = await api.kinds().catch(() => this.kinds);
    this.#tell("kinds", this.kinds);
  }

  /** @param {number} revision */
  async #fetchHistory(revision) {
    const at = performance.now();
    this.#revision = revision;
    const rows = await api.history().catch(() => null);
    if (!rows || revision !== this.#revision) return;
    [this.history, this.historyAt] = [rows, at];
    this.#tell("history", rows);
  }

  /** @param {(ref: number) => boolean} send */
  async #asked(send) {
    const answer = await this.#asking.ask(send);
    if (!answer.ok) this.#tell("trouble", answer.detail ?? "That was refused.");
    return answer;
  }

  /**
   * @template {keyof Happenings} K
   * @param {K} what
   * @param {Happenings[K]} detail
   */
  #tell(what, detail) {
    this.#events.dispatchEvent(new CustomEvent(what, { detail }));
  }
}
