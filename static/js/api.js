// The few calls that go over HTTP: who am I, the vocabulary, the history, and STOP by a second way.

/** @typedef {import("./suggest.js").Kind} Kind */
/** @typedef {{name: string, role: "viewer" | "operator" | "admin", id: string}} Me */
/**
 * @typedef {object} HistoryRow how a command went
 * @property {number} id
 * @property {number} at_s Unix time
 * @property {number | null} duration_s null while it runs
 * @property {string} source typed, chip, click, voice, ears, rest
 * @property {string} words as they arrived
 * @property {string} heard_as as they were understood, "" when they were not
 * @property {string} name of the command, "" when the words were not understood
 * @property {Record<string, number>} numbers
 * @property {string} who
 * @property {string} state running, done, refused, cancelled, pre-empted, failed
 * @property {string} remark
 */

const BUSY_MS = 300; // between questions whether something is over
const HISTORY_ROWS = 60; // more than anybody reads

/** An answer that is no success, with the server's own sentence. */
export class Refusal extends Error {
  /**
   * @param {number} status 0: no answer at all
   * @param {string} sentence
   */
  constructor(status, sentence) {
    super(sentence);
    this.status = status;
  }
}

/** @param {string} path relative to the page, so that a proxy may put us below any prefix */
export const address = (path) => new URL(path, document.baseURI);

/**
 * The address of a socket beside the page.
 * @param {string} path
 */
export function socketAddress(path) {
  const url = address(path);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return url.href;
}

/**
 * @param {string} path
 * @param {RequestInit} [options]
 * @returns {Promise<any>}
 */
export async function call(path, options = {}) {
  const answer = await fetch(address(path), { credentials: "same-origin", cache: "no-store", ...options }).catch(() => {
    throw new Refusal(0, "Beckon does not answer. Is it still running, and is the network up?");
  });
  const told = await answer.json().catch(() => null);
  if (answer.ok) return told;
  throw new Refusal(answer.status, told?.detail ?? `Beckon answered ${answer.status}.`);
}

/**
 * @param {string} path
 * @param {object} [content]
 */
export function post(path, content) {
  const told = content ? { body: JSON.stringify(content), headers: { "content-type": "application/json" } } : {};
  return call(path, { method: "POST", keepalive: true, ...told });
}

/** @returns {Promise<Me>} refused with 401 when nobody is signed in */
export const me = () => call("api/me");

/** @param {string} token */
export const login = (token) => post("api/login", { token });

/** @param {boolean} on whether the robot's own microphones listen */
export const listen = (on) => post("api/hearing", { listen: on });

/** @param {boolean} on whether what voices in the room say is done; only who drives may ask for it */
export const obeyVoices = (on) => post("api/hearing", { listen: true, obey: on });

/** @typedef {{id: number, seconds: number, rate_hz: number, pcm: string}} Spoken 16-bit samples in base64 */

/** @typedef {{kind: string, channels: number[], sentence: string, serious: boolean}} ArrayFault */

/** @typedef {{busy: boolean, well: boolean | null, faults: ArrayFault[], trouble: string}} ArrayCheck */

/**
 * Looks for what is wrong with the robot's microphones.
 * @param {boolean} show somebody in the simulated room speaks meanwhile
 * @returns {Promise<ArrayCheck>} when it is over
 */
export async function checkArray(show) {
  await post("api/hearing/check", { show });
  return patiently(() => call("api/hearing/check"));
}

/**
 * Asks until something that takes a while is over. Refused with the server's sentence when nothing came of it.
 * @template {{busy: boolean, trouble: string}} T
 * @param {() => Promise<T>} ask
 * @returns {Promise<T>}
 */
export async function patiently(ask) {
  for (;;) {
    await new Promise((resolve) => setTimeout(resolve, BUSY_MS));
    const told = await ask();
    if (told.trouble) throw new Refusal(503, told.trouble);
    if (!told.busy) return told;
  }
}

/** @param {string} text @returns {Promise<Spoken>} how the robot says it; from now on nobody is listened to */
export const voice = (text) => post("api/voice", { text });

/** @param {number} id of an utterance that is over */
export const hush = (id) => post("api/voice/hush", { id });

/** @returns {Promise<{summary: string}[]>} measurements of hearing, newest first */
export const qualityRuns = async () => (await call("api/speech-quality")).runs;

/** @param {number} id of the spoken order that waits: begun now */
export const beginIntent = (id) => post("api/intent/begin", { id });

/** @param {number} id of the spoken order that waits: not begun */
export const dropIntent = (id) => post("api/intent/drop", { id });

export const logout = () => post("api/logout");

/** @param {number} press a number for this press of STOP, the same as over the socket */
export const stop = (press) => post(`api/stop?press=${press}`);

/** @param {number} press @returns {Promise<{latched: boolean, why?: string}>} once the halt is on disk */
export const halt = (press) => post(`api/halt?press=${press}`);

/** @returns {Promise<Kind[]>} */
export const kinds = async () => (await call("api/commands")).commands;

/** @returns {Promise<HistoryRow[]>} newest first */
export const history = async () => (await call(`api/commands/history?limit=${HISTORY_ROWS}`)).commands;

/**
 * What to show of a row, and to say again.
 * @param {HistoryRow} row
 */
export const wordsOf = (row) => row.heard_as || row.words || "Speech";
