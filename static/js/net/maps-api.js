// HTTP client for maps: saved maps, relocalization, loop closures.

import { t } from "../ui/texts.js";
import { address, call, post, Refusal } from "./api.js";

/** @typedef {import("./messages.js").ClosureRow} ClosureRow */
/**
 * @typedef {object} SavedMap
 * @property {string} name
 * @property {number} saved_s Unix time
 * @property {string} by
 * @property {string} robot
 * @property {number} width_m
 * @property {number} height_m
 * @property {number} submaps
 * @property {number} landmarks
 * @property {number} closures
 */
/**
 * @typedef {object} Plan picture of the map and its extent
 * @property {ImageBitmap} picture
 * @property {import("../ui/floor-view.js").Extent} extent
 */

const ROOT = "api/maps";

/** @param {string} name */
const one = (name) => `${ROOT}/${encodeURIComponent(name)}`;

/** @returns {Promise<SavedMap[]>} newest first */
export const list = async () => (await call(ROOT)).maps;

const NAME = /^[\p{L}\p{N}_](?:[\p{L}\p{N}_ -]*[\p{L}\p{N}_])?$/u;

/**
 * Return the problem of a map name, "" for none. The console decides.
 * @param {string} name
 */
export const nameTrouble = (name) => (name.length <= 40 && NAME.test(name) ? "" : t("maps-api.a_map_s_name_has_1"));

/** @param {string} name @param {boolean} replace @returns {Promise<SavedMap>} 409 when the name is taken */
export const save = (name, replace) => post(ROOT, { name, replace });

/** @param {string} name */
export const load = (name) => post(`${one(name)}/load`);

/** @param {string} name */
export const remove = (name) => call(one(name), { method: "DELETE" });

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

/** @returns {Promise<Array<[number, number]>>} laser points in the robot frame [m] */
export const scan = async () => (await call("api/scan")).points_m;

/** @returns {Promise<Plan>} */
export async function plan() {
  const answer = await fetch(address("api/map.png?style=page"), {
    credentials: "same-origin",
    cache: "no-store",
  }).catch(() => {
    throw new Refusal(0, t("api.no_answer"));
  });
  if (!answer.ok) {
    const content = await answer.json().catch(() => null);
    throw new Refusal(answer.status, content?.detail ?? t("api.answered", { status: answer.status }));
  }
  /** @param {string} name */
  const numbers = (name) => (answer.headers.get(name) ?? "").split(",").map(Number);
  const [cell = NaN] = numbers("map-resolution-m");
  const [left = NaN, bottom = NaN] = numbers("map-origin-m");
  const [columns = NaN, rows = NaN] = numbers("map-cells");
  const extent = { left, bottom, right: left + cell * columns, top: bottom + cell * rows };
  return { picture: await createImageBitmap(await answer.blob()), extent };
}
