// Session of one page: newest state, events, and all requests that act on the robot.

import { onlyWatched, permission } from "../drive/permission.js";
import { inLanguage, learn, t, translate } from "../ui/texts.js";
import { unlessStopped } from "../voice/spoken-answers.js";
import * as api from "./api.js";
import { Asking, Link } from "./link.js";

/** @import { Calibration } from "../calibration/types.js" */
/** @import { DriveFrame, Permission } from "../drive/drive.js" */
/** @import { Kind } from "../drive/suggest.js" */
/** @import { LinkHealth } from "./link.js" */
/** @import { AnswerMessage as Answer, HelloMessage as Hello, PlaybackMessage, State } from "./messages.js" */
/** @import { HistoryRow } from "./rest.js" */
/** @typedef {{text: string, answer: Answer, source: import("./messages.js").SayMessage["source"], at: number}} Said `at`: sent [ms] */
/** @typedef {{seq: number, stamp: number, jpeg: Uint8Array<ArrayBuffer>}} Picture */
/** @typedef {Partial<Omit<PlaybackMessage, "kind" | "ref">> & {action: "play" | "pause" | "seek" | "speed" | "way"}} PlaybackOrder */
/** @typedef {{to: string | null}} LostControl control of this page went to another operator, or to nobody (null) */
/**
 * @typedef {object} View snapshot for the panels
 * @property {Hello | null} hello
 * @property {State | null} state the newest, also after the link is lost
 * @property {LinkHealth} link
 * @property {boolean} up
 * @property {Permission} permission
 * @property {boolean} mine this page holds the lease
 * @property {LostControl | null} lostControl until it is dismissed or control is back
 * @property {string} opening URL of what is being opened instead of this robot; "": nothing is
 * @property {boolean} restarted the console began again while this page was open; until it is dismissed
 * @property {boolean} secure the connection is encrypted or local
 */

const STOPS = "stop moving";
const BACK_MS = 500; // after which a page that was left and is there again connects
const SETTLE_MS = 600; // after a seek the recording takes that long to arrive

/** @typedef {{words: string, level: number}} Hearing words so far, and how loud it is, 0..1 */
/** @typedef {{text: string, words: string, event: string}} Offer a sentence and a button that dispatches the event */

/**
 * Events of a session and their details.
 * @typedef {object} SessionEvents
 * @property {Hello} hello
 * @property {View} heard a new state; dispatched at once, even while the page is not drawn
 * @property {null} lost
 * @property {null} restarted the console began again, and knows nothing of what went before
 * @property {null} signed-out
 * @property {Picture} picture
 * @property {Calibration} calibration new state of the requested session
 * @property {Said} said
 * @property {HistoryRow[]} history
 * @property {Kind[]} kinds
 * @property {boolean} stopped STOP was pressed on this page; true when it was sent
 * @property {number} stop-answered [ms] until the console answered STOP
 * @property {string} trouble a sentence
 * @property {Offer} offer shown as a notice with a button
 * @property {import("../voice/audio-socket.js").Transcript} transcript transcript of the microphone of this browser
 * @property {string} reading the button was released; the transcript is pending, and these are the words so far
 * @property {string} so-far more words of what is pending
 * @property {null} read all that was said has been read: no words of it come any more
 * @property {Hearing | null} hearing while the talk button is held
 * @property {boolean} speaking true while this browser plays the robot's voice
 * @property {null} interrupt speech output has to stop: a person speaks
 * @property {string} announcement a sentence for screen readers
 */

const drawPress = () => Math.floor(Math.random() * 2 ** 53); // one press is sent over two channels and recorded once

export class Session {
  /** @type {Hello | null} */
  hello = null;
  /** @type {State | null} */
  state = null;
  /** @type {Kind[]} */
  kinds = [];
  /** @type {HistoryRow[]} */
  history = [];
  opening = ""; // URL of what is being opened instead of this robot
  historyAt = 0; // [ms] when the page learned of new rows
  #events = new EventTarget();
  #asking = new Asking();
  #revision = -1;
  /** @type {object | null} newest message of a calibration */
  #calibration = null;
  #sought = 0; // place in a recording that was sought last, 0..1
  #soughtAt = -Infinity; // [ms]
  /** @type {number | null} place [s] that a finger is at, and that is not yet shown */
  #scrubs = null;
  #drove = false; // this page held the lease in the newest state
  #gaveAway = false; // this page released the lease itself
  /** @type {LostControl | null} */
  #lostControl = null;
  #restarted = false;
  #steered = { plays: false, at: -Infinity }; // [ms] newest play or pause
  #stoppedAt = -Infinity; // [ms] newest STOP of this page
  #wantsCamera = true;
  /** @type {Set<object>} parts of the page that show the camera's picture */
  #watchers = new Set();
  /** @type {string | null} */
  #wantsCalibration = null;

  constructor() {
    this.link = new Link({
      url: api.socketAddress("ws"),
      hear: (message) => this.#hear(message),
      see: (picture) => this.tell("picture", picture),
      lose: () => this.#lose(),
    });
  }

  /**
   * Listen. A page that is opened later learns of the newest hello at once.
   * @template {keyof SessionEvents} K
   * @param {K} what
   * @param {(detail: SessionEvents[K]) => void} then
   * @param {AddEventListenerOptions} [options] with a signal that ends it
   */
  on(what, then, options) {
    if (what === "hello" && this.hello) then(/** @type {SessionEvents[K]} */ (this.hello));
    this.#events.addEventListener(what, (event) => then(/** @type {CustomEvent} */ (event).detail), options);
  }

  /** @returns {View} */
  get view() {
    const link = this.link.health;
    const { hello, state } = this;
    const up = link.is === "up" && state !== null;
    const mine = up && hello !== null && state.lease.holder_id === hello.you.id;
    const lostControl = this.#lostControl;
    return {
      hello,
      state,
      link,
      up,
      mine,
      lostControl,
      restarted: this.#restarted,
      opening: this.opening,
      permission: permission({ hello, state, up }),
      secure: isSecureContext,
    };
  }

  /** Number of the newest state: dates a command that the link delays. */
  get seen() {
    return this.state?.seq ?? 0;
  }

  /** Send a command in words. @param {string} text @param {Said["source"]} source */
  async say(text, source) {
    const at = performance.now();
    const answer = await this.#asking.ask((ref) =>
      this.link.send({ kind: "command", text, source, ref, seen: this.seen }),
    );
    if (answer.ok && answer.detail === STOPS) this.#stoppedAt = Math.max(this.#stoppedAt, at);
    this.tell("said", { text, answer, source, at });
    return answer;
  }

  /** Send STOP over both channels at once. */
  stop() {
    this.#stoppedAt = performance.now();
    const { robot, you } = this.hello ?? {};
    if (robot?.capabilities.includes("replay") && !this.state?.command) {
      if (you?.role !== "viewer" && this.plays) void this.playback({ action: "pause" });
      return; // there is nothing else to stop
    }
    const press = drawPress();
    const left = this.link.send({ kind: "stop", press });
    this.tell("stopped", left);
    const why = t("session.the_robot_stops_by_itself_when");
    api.stop(press).then(
      () => {
        this.tell("stop-answered", Math.round(performance.now() - this.#stoppedAt));
        if (!left) this.tell("stopped", true);
      },
      (refusal) =>
        left || this.complain(t("session.stop_could_not_be_sent_message", { message: refusal.message, why })),
    );
  }

  /** Send a latched stop over both channels. */
  halt() {
    const press = drawPress();
    const left = this.link.send({ kind: "halt", press });
    const why = t("session.the_robot_stops_by_itself_when_2");
    api.halt(press).then(
      (halted) =>
        left ||
        halted.latched ||
        this.complain(halted.why ? inLanguage(halted.why) : t("session.the_halt_is_not_saved")), // the socket says it
      (refusal) =>
        left || this.complain(t("session.halt_could_not_be_sent_message", { message: refusal.message, why })),
    );
  }

  resetHalt() {
    return this.#asked((ref) => this.link.send({ kind: "halt_reset", ref }));
  }

  /** @param {import("./messages.js").LeaseMessage["do"]} action */
  lease(action) {
    if (action === "release" || action === "give") this.#gaveAway = true;
    return this.#asked((ref) => this.link.send({ kind: "lease", do: action, ref }));
  }

  /** @param {PlaybackOrder} order */
  playback(order) {
    const { action } = order;
    if (action === "play" || action === "pause") this.#steered = { plays: action === "play", at: performance.now() };
    return this.#asked((ref) => this.link.send({ kind: "playback", ref, ...order }));
  }

  /** Seek to a time of the recording while a finger drags: the newest place counts, one at a time. @param {number} time [s] */
  async scrub(time) {
    const waits = this.#scrubs !== null;
    this.#scrubs = time;
    while (!waits && this.#scrubs !== null) {
      const wanted = /** @type {number} */ (this.#scrubs);
      await this.playback({ action: "seek", t_s: wanted });
      if (this.#scrubs === wanted) this.#scrubs = null;
    }
  }

  /** Whether the recording plays: what was just asked for counts before the state that shows it. */
  get plays() {
    const { plays, at } = this.#steered;
    return performance.now() - at < SETTLE_MS ? plays : this.state?.robot.running === true;
  }

  /** Move in a recording; presses in quick succession add up. @param {number} seconds */
  seekBy(seconds) {
    const duration = this.hello?.robot.duration_s ?? 0;
    if (!duration || this.hello?.you.role === "viewer") return;
    const now = performance.now();
    const from = now - this.#soughtAt < SETTLE_MS ? this.#sought : (this.state?.robot.progress ?? 0);
    this.#soughtAt = now;
    this.#sought = Math.min(1, Math.max(0, from + seconds / duration));
    void this.scrub(this.#sought * duration);
  }

  /** @param {"begin" | "drop"} does @param {number} id of the pending command */
  async pendingCommand(does, id) {
    await api.pendingCommand(does, id).catch((refusal) => this.complain(refusal.message));
  }

  /** @param {DriveFrame} frame */
  drive(frame) {
    this.link.send({ kind: "drive", ...frame });
  }

  /** @param {object} watcher a part of the page @param {boolean} camera true while it shows the camera's picture */
  want(watcher, camera) {
    if (camera) this.#watchers.add(watcher);
    else this.#watchers.delete(watcher);
    const wanted = this.#watchers.size > 0;
    if (wanted === this.#wantsCamera) return;
    this.#wantsCamera = wanted;
    this.link.send({ kind: "want", camera: wanted });
  }

  /** @param {string | null} id of the calibration session to subscribe to */
  wantCalibration(id) {
    if (id === this.#wantsCalibration) return;
    this.#wantsCalibration = id;
    this.link.send({ kind: "want", calibration: id });
  }

  /** @param {import("../voice/audio-socket.js").Transcript} transcript */
  transcribe(transcript) {
    const now = performance.now();
    if (transcript.accepted && transcript.heard_as === STOPS) this.#stoppedAt = now;
    this.tell("transcript", unlessStopped(transcript, now, this.#stoppedAt));
  }

  /** @param {string} sentence shown as a notice */
  complain(sentence) {
    this.tell("trouble", sentence);
  }

  /**
   * Do something that may be refused, and show the refusal as a notice.
   * @param {() => Promise<unknown>} act
   * @returns {Promise<boolean>} whether it was done
   */
  async attempt(act) {
    try {
      await act();
      return true;
    } catch (refusal) {
      this.complain(api.sentenceOf(refusal));
      return false;
    }
  }

  /** @param {string} sentence for screen readers */
  announce(sentence) {
    this.tell("announcement", sentence);
  }

  /** Start, or start again after a login. Dispatches "signed-out" when no user is signed in. */
  async begin() {
    try {
      await api.me();
      this.link.open();
    } catch (refusal) {
      if (refusal instanceof api.Refusal && refusal.status === 401) this.tell("signed-out", null);
      else this.link.open(); // the link keeps trying, and a banner shows it
    }
  }

  async leave() {
    await api.logout().catch(() => undefined);
    this.link.close();
    await this.begin();
  }

  /** @param {Exclude<import("./messages.js").Down, {kind: "echo"}>} message */
  async #hear(message) {
    if (message.kind === "answer") {
      if (!message.ok) await learn(message.detail);
      translate(message, "detail");
      if (message.ref === 0 && !message.ok) this.tell("trouble", message.detail ?? t("session.that_was_refused")); // a click in the scene
      this.#asking.hear(message);
    } else if (message.kind === "hello") {
      const before = this.hello;
      translate(message.robot, "name");
      this.hello = message;
      if (before && before.console !== message.console) this.#beginAgain(before);
      this.#revision = -1;
      if (!this.#wantsCamera) this.link.send({ kind: "want", camera: false });
      if (this.#wantsCalibration !== null) this.link.send({ kind: "want", calibration: this.#wantsCalibration });
      this.tell("hello", message);
      void this.#fetchKinds();
    } else if (message.kind === "calibration") {
      this.#calibration = message;
      await learn(message.session);
      if (this.#calibration === message) this.tell("calibration", /** @type {Calibration} */ (message.session));
    } else {
      this.state = message;
      for (const notice of message.notices) translate(notice, "text");
      translate(message.floor?.lost, "words");
      translate(message.gate, "reason");
      translate(message.route, "reason");
      translate(message.command, "remark");
      this.#watchLease(message.lease);
      this.tell("heard", this.view);
      if (message.history_revision !== this.#revision) void this.#fetchHistory(message.history_revision);
    }
  }

  /** @param {Hello} before of the console that has ended: nobody took control, and its map is gone */
  #beginAgain({ robot }) {
    this.#drove = false;
    this.#lostControl = null;
    this.#restarted = robot.url === this.hello?.robot.url && robot.drives;
    this.tell("restarted", null);
  }

  dismissRestart() {
    this.#restarted = false;
  }

  /** The page is left: others see it at once, and nobody waits for control that it does not use. It may come back. */
  suspend() {
    const { command, route } = this.state ?? {};
    const goesOn = command || route?.state === "driving" || route?.state === "waiting";
    if (this.view.mine && !goesOn) this.link.send({ kind: "lease", do: "leave", ref: 0 });
    this.link.close();
    setTimeout(() => void this.begin(), BACK_MS);
  }

  dismissLostControl() {
    this.#lostControl = null;
  }

  /** @param {import("./messages.js").LeaseState} lease */
  #watchLease({ holder, holder_id }) {
    const drives = this.hello !== null && holder_id === this.hello.you.id;
    if (this.#drove && !drives && !this.#gaveAway) this.#lostControl = { to: holder };
    if (drives || (this.#lostControl?.to && !holder)) this.#lostControl = null; // who took it has given it back
    if (!drives) this.#gaveAway = false;
    this.#drove = drives;
  }

  #lose() {
    this.#asking.lose();
    this.tell("lost", null);
    api.me().catch((refusal) => {
      if (refusal.status !== 401) return;
      this.link.close();
      this.tell("signed-out", null);
    });
  }

  async #fetchKinds() {
    if (onlyWatched(this.hello)) return;
    const kinds = await api.kinds().catch(() => null);
    if (!kinds) {
      if (this.view.up) setTimeout(() => void this.#fetchKinds(), BACK_MS);
      return;
    }
    const dry = this.hello?.robot.dry_run === true;
    this.kinds = dry ? kinds.filter(({ target, name }) => target === "person" || name === "stop_moving") : kinds;
    this.tell("kinds", this.kinds);
  }

  /** @param {number} revision */
  async #fetchHistory(revision) {
    const at = performance.now();
    this.#revision = revision;
    const rows = await api.history().catch(() => null);
    if (revision !== this.#revision) return;
    if (!rows) this.#revision = -1; // with the next state once more
    if (!rows) return;
    [this.history, this.historyAt] = [rows, at];
    this.tell("history", rows);
  }

  /** @param {(ref: number) => boolean} send */
  async #asked(send) {
    const answer = await this.#asking.ask(send);
    if (!answer.ok) this.tell("trouble", answer.detail ?? t("session.that_was_refused"));
    return answer;
  }

  /**
   * Dispatch an event.
   * @template {keyof SessionEvents} K
   * @param {K} what
   * @param {SessionEvents[K]} detail
   */
  tell(what, detail) {
    this.#events.dispatchEvent(new CustomEvent(what, { detail }));
  }
}
