// HTTP client for the map that is edited, and for maps and masks of Nav2.

import { learn, said, t } from "../ui/texts.js";
import { zipOf } from "../ui/zip.js";
import { address, call, post, Refusal } from "./api.js";

/** @typedef {"free" | "occupied" | "unknown" | "crop" | "turn"} EditKind */
/** @import { EditList } from "./rest.js" */
/** @typedef {{image: ImageBitmap, cell: number, left: number, bottom: number}} MapPicture cell and corner [m] */

const EDITS = "api/map/edits";

/** @returns {Promise<EditList>} */
export const edits = () => call(EDITS);

/** @param {{kind: EditKind, points_m?: Array<[number, number]>, width_m?: number, angle_rad?: number}} edit */
export const edit = (edit) => post(EDITS, edit);

/** @param {"undo" | "redo"} act @param {number | null} [id] @returns {Promise<EditList>} */
export const takeBack = (act, id = null) => post(`${EDITS}/${act}`, { id });

/** @param {number} version @returns {Promise<EditList>} */
export const backTo = (version) => post(`${EDITS}/back`, { version });

/** @returns {Promise<MapPicture>} every cell a picture element */
export async function picture() {
  const answer = await fetch(address("api/map.png"), { credentials: "same-origin", cache: "no-store" });
  if (!answer.ok) throw new Refusal(answer.status, t("api.that_did_not_work"));
  const [left, bottom] = (answer.headers.get("Map-Origin-M") ?? "0, 0").split(",").map(Number);
  const image = await createImageBitmap(await answer.blob());
  return { image, cell: Number(answer.headers.get("Map-Resolution-M")), left: left ?? 0, bottom: bottom ?? 0 };
}

/** @param {string} path @param {Blob} body a zip @returns {Promise<any>} */
export async function send(path, body) {
  const options = { method: "POST", body, headers: { "content-type": "application/zip" } };
  const answer = await fetch(address(path), { credentials: "same-origin", ...options });
  const content = await answer.json().catch(() => null);
  await learn(content);
  if (answer.ok) return content;
  throw new Refusal(answer.status, content ? said(content.detail, content.code, content.values) : "");
}

/** @param {FileList} files a zip, or YAML and picture @returns {Promise<Blob>} */
async function packed(files) {
  const [first] = files;
  if (files.length === 1 && first && /\.zip$/i.test(first.name)) return first;
  const members = await Promise.all(
    [...files].map(async (file) => ({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) })),
  );
  return zipOf(members);
}

/** @param {string} name @param {FileList} files @returns {Promise<{name: string, remark: string}>} */
export const takeInMap = async (name, files) =>
  send(`api/maps/import?name=${encodeURIComponent(name)}`, await packed(files));

/**
 * @param {string} name
 * @param {FileList} files
 * @param {{kind: "keep_out" | "slow", type: 1 | 2, base: number, multiplier: number}} reading
 * @returns {Promise<{zones: object[], left_out: string}>}
 */
export const takeInMask = async (name, files, { kind, type, base, multiplier }) =>
  send(
    `api/zones/masks?name=${encodeURIComponent(name)}&kind=${kind}&type=${type}&base=${base}&multiplier=${multiplier}`,
    await packed(files),
  );
