// HTTP client of the console: user, vocabulary, history, and STOP as a second channel.

import { inLanguage, language, learn, said, t, translate, withMinus } from "../ui/texts.js";

/** @import { Kind } from "../drive/suggest.js" */
/** @import { ArrayCheck, HistoryRow, PressedFloor, SpokenAnswer as Spoken } from "./rest.js" */
/** @typedef {{name: string, role: "viewer" | "operator" | "admin", id: string}} Me */

const BUSY_MS = 300; // polling interval
const HISTORY_ROWS = 60; // more than a person reads

/** Error of a request, with the sentence of the server. */
export class Refusal extends Error {
  /** @param {number} status 0: no answer at all @param {string} sentence */
  constructor(status, sentence) {
    super(sentence);
    this.status = status;
  }
}

/** @param {unknown} trouble what was thrown @param {string} [otherwise] */
export const sentenceOf = (trouble, otherwise = t("api.that_did_not_work")) =>
  trouble instanceof Error && !(trouble instanceof TypeError) ? trouble.message : otherwise; // an answer that is none is no sentence

/** @param {string} path relative to the page, so that the page works below any prefix of a proxy */
export const address = (path) => new URL(path, document.baseURI);

/** Path of a file with words, which are to be those of the page's language. @param {string} path */
export const wordedPath = (path) => `${path}?language=${language}`;

/** Address of a WebSocket on the same server. @param {string} path */
export function socketAddress(path) {
  const url = address(path);
  url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
  return url.href;
}

/** @param {string} path @param {RequestInit} [options] @returns {Promise<any>} */
export async function call(path, options = {}) {
  const answer = await fetch(address(path), { credentials: "same-origin", cache: "no-store", ...options }).catch(() => {
    throw new Refusal(0, t("api.no_answer"));
  });
  const content = await answer.json().catch(() => null);
  await learn(content);
  if (answer.ok) return content;
  const { detail, code, values } = content ?? {};
  throw new Refusal(answer.status, detail ? said(detail, code, values) : t("api.answered", { status: answer.status }));
}

/** @param {string} path @param {"POST" | "PATCH" | "PUT"} method @param {object} content @param {RequestInit} [more] */
export const send = (path, method, content, more) =>
  call(path, { method, body: JSON.stringify(content), headers: { "content-type": "application/json" }, ...more });

/** @param {string} path @param {object} [content] */
export const post = (path, content) =>
  content ? send(path, "POST", content, { keepalive: true }) : call(path, { method: "POST", keepalive: true });

/** @returns {Promise<Me>} 401 when no user is signed in */
export const me = () => call("api/me");

/** @param {string} token */
export const login = (token) => post("api/login", { token });

/** @param {boolean} on true: the robot's own microphones listen */
export const listen = (on) => post("api/hearing", { listen: on });

/** @param {boolean} on true: commands of voices in the room are executed; only the operator in control may ask for it */
export const obeyVoices = (on) => post("api/hearing", { listen: true, obey: on });

/**
 * Check the robot's microphones for faults.
 * @param {boolean} show let the simulated person speak meanwhile
 * @returns {Promise<ArrayCheck>} the result
 */
export async function checkArray(show) {
  await post("api/hearing/check", { show });
  return patiently(() => call("api/hearing/check"));
}

/**
 * Poll until a long task has ended. Throws a Refusal with the sentence of the server when it failed.
 * @template {{busy: boolean, trouble: string}} T
 * @param {() => Promise<T>} ask
 * @returns {Promise<T>}
 */
export async function patiently(ask) {
  for (;;) {
    await new Promise((resolve) => setTimeout(resolve, BUSY_MS));
    const status = await ask();
    if (status.trouble) throw new Refusal(503, inLanguage(status.trouble));
    if (!status.busy) return status;
  }
}

/**
 * What floor a pixel of the camera's picture shows.
 * @param {import("../ui/floor-view.js").Point} pixel @param {number} stamp [s] of the picture
 * @returns {Promise<PressedFloor>}
 */
export async function pressedFloor({ x, y }, stamp) {
  const pixel = { u_px: x.toFixed(1), v_px: y.toFixed(1), stamp_s: String(stamp) };
  const found = await call(`api/camera/floor?${new URLSearchParams(pixel)}`);
  translate(found, "why");
  return found;
}

/** @param {string} text @returns {Promise<Spoken>} speech of the robot; its hearing is muted from now on */
export const voice = (text) => post("api/voice", { text });

/** @param {number} id of an utterance that has ended */
export const hush = (id) => post("api/voice/hush", { id });

/** @returns {Promise<{summary: string}[]>} measurements of hearing, newest first */
export const qualityRuns = async () => (await call("api/speech-quality")).runs;

/** @param {"begin" | "drop"} does @param {number} id of the pending command */
export const pendingCommand = (does, id) => post(`api/pending-command/${does}`, { id });

/** @param {"viewer" | "operator"} role @param {string} name of whom it is for, or "" */
export const makeLink = (role, name) => post("api/links", { role, name });

/** Logins of browsers, and keys by which one may sign in. */
export const signIns = () => call("api/sessions");

/** @param {string} id of a login */
export const endSession = (id) => call(`api/sessions/${id}`, { method: "DELETE" });

/** @param {string} id of a key */
export const revokeKey = (id) => call(`api/keys/${id}`, { method: "DELETE" });

export const logout = () => post("api/logout");

/** @param {number} press number of this press of STOP, the same as over the socket */
export const stop = (press) => post(`api/stop?press=${press}`);

/** @param {number} press @returns {Promise<{latched: boolean, why?: string}>} once the halt is on disk */
export const halt = (press) => post(`api/halt?press=${press}`);

/** @returns {Promise<Kind[]>} */
export async function kinds() {
  const { commands } = await call("api/commands");
  for (const kind of commands) translate(kind, "summary");
  return commands;
}

/** @returns {Promise<HistoryRow[]>} newest first */
export async function history() {
  /** @type {HistoryRow[]} */
  const rows = (await call(`api/commands/history?limit=${HISTORY_ROWS}`)).commands;
  for (const row of rows) translate(row, "remark");
  return rows;
}

/** @param {string | undefined} source of a command: a place that was pressed on the map or in the camera's picture */
export const isPressed = (source) => source === "click" || source === "camera";

/** Words of a command: shown, and used to repeat it. @param {Pick<HistoryRow, "heard_as"> & Partial<HistoryRow>} row */
export function wordsOf({ heard_as, words, source }) {
  const said = withMinus(heard_as || words || "Speech");
  return isPressed(source) ? said.replace(/^stop at /, "go to ") : said; // nobody said “stop”, and the robot sets out
}

/** Which engine reads words, and the model with which people are understood better. */
export const recognizer = () => call("api/recognizer");

/** Fetch that model; it takes as long as the download. */
export const fetchModel = () => post("api/recognizer/model");

/** What looks for people in pictures, and the model with which real people are seen. */
export const looking = () => call("api/looking");

/** Fetch that model; it takes as long as the download. */
export const fetchLookingModel = () => post("api/looking/model");
