// WebSocket link to the console: reconnects, measures round trip and rate.
// Requests sent over the socket that have no answer yet.

import { inLanguage, t } from "../ui/texts.js";

/** @import { Down, Up, AnswerMessage as Answer } from "./messages.js" */

export const QUIET_MS = 3000; // without a message for that long the socket counts as dead
const PATIENCE_MS = 30_000; // with a console that was too slow to answer before; each attempt has twice as much
const CAMERA_HEADER_BYTES = 16; // u8 kind = 1, 3 bytes of padding, u32 sequence number, f64 stamp [s], little endian
const ECHO_MS = 1000;
const WATCH_MS = 200;
const WAITING_BYTES = 4096; // more than this unsent: a drive frame would only arrive too late

/**
 * Waiting time before the next attempt: doubles from 0.5 s to 8 s, spread by ±25 % so that many pages do not
 * reconnect at once.
 * @param {number} attempt 0 for the first
 * @param {number} chance 0..1
 * @returns {number} [ms]
 */
export function waitBefore(attempt, chance) {
  return Math.min(500 * 2 ** Math.min(attempt, 10), 8000) * (0.75 + 0.5 * chance);
}

/** Rate of the messages in the last two seconds. */
export class Rate {
  /** @type {number[]} */
  #times = [];

  /** @param {number} now [ms] */
  mark(now) {
    this.#times.push(now);
    this.#forget(now);
  }

  /** @param {number} now [ms] @returns {number} [Hz] */
  hertz(now) {
    this.#forget(now);
    const first = this.#times[0];
    if (first === undefined || this.#times.length < 2) return 0;
    return ((this.#times.length - 1) * 1000) / Math.max(now - first, 1);
  }

  /** @param {number} now */
  #forget(now) {
    while (this.#times.length && now - (this.#times[0] ?? 0) > 2000) this.#times.shift();
  }
}

/**
 * The binary message of the camera.
 * @param {ArrayBuffer} bytes
 * @returns {{seq: number, stamp: number, jpeg: Uint8Array<ArrayBuffer>} | null} null for other content
 */
export function pictureOf(bytes) {
  if (bytes.byteLength <= CAMERA_HEADER_BYTES) return null;
  const header = new DataView(bytes, 0, CAMERA_HEADER_BYTES);
  if (header.getUint8(0) !== 1) return null;
  return {
    seq: header.getUint32(4, true),
    stamp: header.getFloat64(8, true),
    jpeg: new Uint8Array(bytes, CAMERA_HEADER_BYTES),
  };
}

/**
 * @typedef {object} LinkHealth
 * @property {"opening" | "up" | "down"} is
 * @property {number} age_s since the newest state
 * @property {number | null} round_trip_ms
 * @property {number} rate_hz of states
 * @property {number} again_s until the next attempt, 0 while one is under way
 * @property {string} why reason that the console gave for closing, or ""
 */

export class Link {
  /** @type {WebSocket | null} */
  #socket = null;
  #attempt = 0;
  #hello = false;
  #heardAt = -Infinity;
  #stateAt = -Infinity;
  #echoAt = 0;
  #againAt = 0;
  /** @type {number | null} */
  #roundTrip = null;
  #rate = new Rate();
  #wanted = false;
  #watchedAt = 0;
  #why = "";

  /**
   * @param {object} world
   * @param {string} world.url
   * @param {(message: Exclude<Down, {kind: "echo"}>) => void} world.hear
   * @param {(picture: {seq: number, stamp: number, jpeg: Uint8Array<ArrayBuffer>}) => void} world.see
   * @param {() => void} world.lose called whenever a socket ends
   */
  constructor({ url, hear, see, lose }) {
    this.url = url;
    this.hear = hear;
    this.see = see;
    this.lose = lose;
    setInterval(() => this.#watch(), WATCH_MS);
  }

  open() {
    this.#wanted = true;
    if (this.#socket) return;
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    this.#socket = socket;
    this.#heardAt = performance.now();
    socket.addEventListener("message", (event) => this.#take(event.data));
    socket.addEventListener("close", (event) => this.#lost(socket, event.reason));
  }

  /** Close permanently, after signing out. */
  close() {
    this.#wanted = false;
    this.#socket?.close();
  }

  /** @param {Up} message @returns {boolean} true when it was sent */
  send(message) {
    const socket = this.#socket;
    if (!socket || socket.readyState !== WebSocket.OPEN) return false;
    if (message.kind === "drive" && (message.v || message.w) && socket.bufferedAmount > WAITING_BYTES) return false;
    socket.send(JSON.stringify(message));
    return true;
  }

  /** @returns {LinkHealth} */
  get health() {
    const now = performance.now();
    return {
      is: this.#hello ? "up" : this.#socket && this.#attempt === 0 ? "opening" : "down",
      age_s: (now - this.#stateAt) / 1000,
      round_trip_ms: this.#roundTrip,
      rate_hz: this.#rate.hertz(now),
      again_s: this.#socket ? 0 : Math.max(0, (this.#againAt - now) / 1000),
      why: this.#why,
    };
  }

  /** @param {string | ArrayBuffer} content */
  #take(content) {
    const now = performance.now();
    this.#heardAt = now;
    this.#echo(now); // here too: a hidden page's timers may come once a minute
    if (content instanceof ArrayBuffer) {
      const picture = pictureOf(content);
      if (picture) this.see(picture);
      return;
    }
    /** @type {Down} */
    const message = JSON.parse(content);
    if (message.kind === "echo") {
      this.#roundTrip = now - message.t;
      return;
    }
    if (message.kind === "hello") {
      this.#hello = true;
      this.#attempt = 0;
      this.#why = "";
    }
    if (message.kind === "state") {
      this.#stateAt = now;
      this.#rate.mark(now);
    }
    this.hear(message);
  }

  /** @param {WebSocket} socket @param {string} [why] */
  #lost(socket, why = "") {
    if (socket !== this.#socket) return;
    this.#why = (/^keepalive/.test(why) ? "" : inLanguage(why)) || this.#why; // the library's words say no more than that it is lost
    const wait = waitBefore(this.#attempt, Math.random());
    this.#socket = null;
    this.#hello = false;
    this.#roundTrip = null;
    this.#rate = new Rate();
    this.#attempt += 1;
    this.#againAt = performance.now() + wait;
    this.lose();
    if (this.#wanted) setTimeout(() => this.#wanted && this.open(), wait);
  }

  #watch() {
    const socket = this.#socket;
    const now = performance.now();
    const late = now - this.#watchedAt > 3 * WATCH_MS; // the page was busy: messages may be waiting
    this.#watchedAt = now;
    if (!socket || late) return;
    const patience = this.#hello ? QUIET_MS : Math.min(QUIET_MS * 2 ** this.#attempt, PATIENCE_MS);
    if (now - this.#heardAt > patience) {
      socket.close();
      this.#lost(socket); // a dead peer never answers the closing handshake
    } else this.#echo(now);
  }

  /**
   * Send the heartbeat: it measures the link and keeps the lease. It must come from this thread, which draws and
   * handles the input of the operator.
   * @param {number} now [ms]
   */
  #echo(now) {
    if (!this.#hello || now - this.#echoAt <= ECHO_MS) return;
    this.#echoAt = now;
    this.send({ kind: "echo", t: now });
  }
}

const ANSWER_MS = 5000;

export class Asking {
  /** @type {Map<number, (answer: Answer) => void>} */
  #waiting = new Map();
  #ref = 0;

  /** @param {(ref: number) => boolean} send returns true when it was sent @returns {Promise<Answer>} */
  ask(send) {
    this.#ref += 1;
    const ref = this.#ref;
    /** @param {string} detail @returns {Answer} */
    const none = (detail) => ({ kind: "answer", ref, ok: false, status: 0, detail });
    return new Promise((resolve) => {
      this.#waiting.set(ref, resolve);
      if (!send(ref)) {
        this.#waiting.delete(ref);
        resolve(none(t("pending-answers.the_link_is_lost_nothing_was")));
        return;
      }
      setTimeout(() => {
        if (this.#waiting.delete(ref)) resolve(none(t("pending-answers.no_answer_came_look_at_the")));
      }, ANSWER_MS);
    });
  }

  /** @param {Answer} answer */
  hear(answer) {
    this.#waiting.get(answer.ref)?.(answer);
    this.#waiting.delete(answer.ref);
  }

  lose() {
    for (const [ref, answer] of this.#waiting)
      answer({ kind: "answer", ref, ok: false, status: 0, detail: t("pending-answers.the_link_was_lost") });
    this.#waiting.clear();
  }
}
