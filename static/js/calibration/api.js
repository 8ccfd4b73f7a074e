// HTTP client of the calibration sessions. A refusal carries the sentence of the server.

import { address, call, post } from "../net/api.js";

/** @import { Board, Calibration, Kind, Source, Verdict } from "./types.js" */
/** @import { SessionRow as Row } from "../net/rest.js" */
/** @typedef {{kind: Kind, board: Board, source: Source, height_m: number | null}} SessionRequest */

const ROOT = "api/calibration";

/** @param {string} id */
const within = (id) => `${ROOT}/sessions/${encodeURIComponent(id)}`;

/** @param {string} id @param {string} name */
const viewOf = (id, name) => `${within(id)}/views/${encodeURIComponent(name)}`;

/** @returns {Promise<Row[]>} */
export const list = async () => (await call(`${ROOT}/sessions`)).sessions;

/** @param {SessionRequest} request @returns {Promise<Calibration>} */
export const begin = (request) => post(`${ROOT}/sessions`, request);

/** @param {string} id @returns {Promise<Calibration>} */
export const read = (id) => call(within(id));

/** @param {string} id */
export const forget = (id) => call(within(id), { method: "DELETE" });

/** @param {string} id @param {boolean} on */
export const live = (id, on) => post(`${within(id)}/live`, { on });

/** @param {string} id @returns {Promise<Verdict>} the robot's newest picture, taken on purpose */
export const capture = (id) => post(`${within(id)}/capture`, {});

/**
 * A picture on purpose (`name`, and extreme `corners` marked by hand) or a frame of the browser's camera (`stamp_s`).
 * @param {string} id
 * @param {Blob} picture JPEG or PNG
 * @param {{name: string, corners?: import("./types.js").Pixel[]} | {stamp_s: number}} how
 * @returns {Promise<Verdict>}
 */
export function send(id, picture, how) {
  const query = new URLSearchParams(
    "name" in how ? { name: how.name } : { live: "1", stamp_s: how.stamp_s.toFixed(3) },
  );
  for (const pixel of ("name" in how && how.corners?.flat()) || []) query.append("corners", pixel.toFixed(2));
  const headers = { "content-type": picture.type };
  return call(`${within(id)}/pictures?${query}`, { method: "POST", body: picture, headers });
}

/** @param {string} id @param {string} name @param {"drop" | "restore"} action @returns {Promise<Calibration>} */
export const keep = (id, name, action) => post(`${viewOf(id, name)}/${action}`, {});

/** @param {string} id @returns {Promise<void>} */
export const solve = (id) => post(`${within(id)}/solve`, {});

/** @param {string} id @returns {Promise<void>} */
export const skip = (id) => post(`${within(id)}/skip`, {});

/** @param {string} id @returns {Promise<void>} */
export const background = (id) => post(`${within(id)}/background`, {});

/** @param {string} id @param {boolean} force overrule a refusal */
export const accept = (id, force) => post(`${within(id)}/accept`, { force });

/** @param {string} id @param {boolean} on @returns {Promise<void>} */
export const showDemo = (id, on) => post(`${ROOT}/demo`, { session: id, on });

/** @returns {Promise<{camera: Record<string, any> | null, laser: Record<string, any> | null}>} */
export const inUse = () => call(`${ROOT}/in-use`);

/** @param {Kind} kind */
export const undo = (kind) => post(`${ROOT}/in-use/undo`, { kind });

/** @param {string} text of a camera file */
export const bring = (text) =>
  call(`${ROOT}/import`, { method: "POST", body: text, headers: { "content-type": "text/plain" } });

/** @param {string} id @param {string} name @param {"" | "full" | "corrected"} how */
export const thumbnail = (id, name, how = "") =>
  address(`${viewOf(id, name)}.jpg${how && (how === "full" ? "?full=1" : "?full=1&corrected=1")}`).href;

/** @param {string} id @param {string} form */
export const exported = (id, form) => address(`${within(id)}/export/${form}`).href;

/** @param {Board} board @param {string} page */
export function printable({ columns, rows, square_m }, page) {
  const query = { columns: String(columns), rows: String(rows), square_m: String(square_m), page };
  return address(`${ROOT}/board.svg?${new URLSearchParams(query)}`).href;
}
