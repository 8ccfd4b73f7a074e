// HTTP client for maps: saved maps, relocalization, loop closures.

import { t } from "../ui/texts.js";
import { address, call, post, send } from "./api.js";

/** @import { ClosureRow } from "./messages.js" */
/** @import { MapMatchRow as MapMatch, SavedMapRow as SavedMap } from "./rest.js" */
/**
 * @typedef {object} Plan outline of the map in metres, and the extent of its walls
 * @property {Path2D} walls
 * @property {Path2D} floor
 * @property {import("../ui/floor-view.js").Extent} extent
 */

const ROOT = "api/maps";
const UNKNOWN_ROOM_CM = [-200, -200, 200, 200]; // shown while neither wall nor floor is known

/** @param {string} name */
const one = (name) => `${ROOT}/${encodeURIComponent(name)}`;

/** @returns {Promise<SavedMap[]>} newest first */
export const list = async () => (await call(ROOT)).maps;

const NAME = /^[\p{L}\p{N}_](?:[\p{L}\p{N}_ -]*[\p{L}\p{N}_])?$/u;

/** Return the problem of a map name, "" for none. The console decides. @param {string} name */
export const nameTrouble = (name) => (name.length <= 40 && NAME.test(name) ? "" : t("maps-api.a_map_s_name_has_1"));

/** @param {string} name @param {boolean} replace @returns {Promise<SavedMap>} 409 when the name is taken */
export const save = (name, replace) => post(ROOT, { name, replace });

/** @param {string} name */
export const load = (name) => post(`${one(name)}/load`);

/** @param {string} name @param {string} to @returns {Promise<SavedMap>} 409 when the name is taken */
export const rename = (name, to) => send(one(name), "PATCH", { name: to });

/** @param {string} name */
export const remove = (name) => call(one(name), { method: "DELETE" });

/** @param {string} older @param {string} newer names of saved maps @returns {Promise<MapMatch>} where it lies */
export const match = (older, newer) => post(`${ROOT}/match`, { older, newer });

/** @param {string} id of a match @param {string} name of the joined map @returns {Promise<SavedMap>} */
export const join = (id, name) => post(`${ROOT}/join`, { match: id, name });

/** @param {string} name */
export const zipOf = (name) => address(`${one(name)}.zip`).href;

/** @param {SavedMap} map */
export const previewOf = ({ name, saved_s: saved }) => address(`${one(name)}.png?of=${saved}`).href;

/** @param {number} id @param {"undo" | "redo"} action */
export const judge = (id, action) => post(`api/slam/closures/${id}/${action}`);

/** @returns {Promise<ClosureRow[]>} oldest first */
export const closures = async () => (await call("api/slam/closures")).closures;

/** @param {{x_m: number, y_m: number, heading_rad: number | null, force: boolean}} where */
export const here = (where) => post("api/slam/here", where);

/** @returns {Promise<{stamp_s: number, points_m: Array<[number, number]>}>} laser points in the robot frame [m] */
export const scan = () => call("api/scan");

/** @param {string} [root] of the console @returns {Promise<Plan>} */
export async function plan(root = "") {
  const { walls_cm: walls, floor_cm: floor } = await call(`${root}api/map/outline`);
  return {
    walls: pathOf(walls),
    floor: pathOf(floor),
    extent: extentOf([walls, floor, [UNKNOWN_ROOM_CM]].find((rings) => rings.length > 0) ?? []),
  };
}

/** @param {number[][]} rings x, y, x, y, … [cm] @returns {Path2D} */
function pathOf(rings) {
  const path = new Path2D();
  for (const ring of rings) {
    path.moveTo((ring[0] ?? 0) / 100, (ring[1] ?? 0) / 100);
    for (let at = 2; at < ring.length; at += 2) path.lineTo((ring[at] ?? 0) / 100, (ring[at + 1] ?? 0) / 100);
    path.closePath();
  }
  return path;
}

/** @param {number[][]} rings x, y, x, y, … [cm] @returns {import("../ui/floor-view.js").Extent} */
export function extentOf(rings) {
  const extent = { left: Infinity, bottom: Infinity, right: -Infinity, top: -Infinity };
  for (const ring of rings)
    for (let at = 0; at < ring.length; at += 2) {
      const [x, y] = [(ring[at] ?? 0) / 100, (ring[at + 1] ?? 0) / 100];
      extent.left = Math.min(extent.left, x);
      extent.right = Math.max(extent.right, x);
      extent.bottom = Math.min(extent.bottom, y);
      extent.top = Math.max(extent.top, y);
    }
  return extent;
}
