// Picture source: files, uploaded one after the other, with a verdict each.

import { t } from "../ui/texts.js";

/** @import { Frame } from "./picture-source.js" */
/** @import { Verdict } from "./types.js" */
/** @typedef {{name: string, kind: string, words: string}} Attempt */

const KINDS = new Set(["image/jpeg", "image/png"]);
const LARGEST = 20e6; // [bytes]

/**
 * Attempts of one result in one row, the newest first: fourteen equal sentences are read once.
 * @param {Attempt[]} attempts newest first
 * @returns {{names: string[], kind: string, words: string}[]}
 */
export function grouped(attempts) {
  /** @type {Map<string, {names: string[], kind: string, words: string}>} */
  const groups = new Map();
  for (const { name, kind, words } of attempts) {
    const key = kind === "counted" ? kind : `${kind} ${words}`; // counted views stand in one row, by name
    const group = groups.get(key) ?? { names: [], kind, words };
    group.names.push(name);
    groups.set(key, group);
  }
  return [...groups.values()];
}

export class Uploads {
  /** @type {Frame | null} */
  frame = null;
  /** @type {Attempt[]} newest first */
  attempts = [];
  /** @type {File[]} all that were chosen, for a session that begins again with another board */
  files = [];
  #closed = false;
  #waiting = 0;
  #count = 0;
  /** @type {Promise<void>} */
  #line = Promise.resolve();

  /** @param {(picture: Blob, name: string) => Promise<Verdict>} send */
  constructor(send) {
    this.send = send;
  }

  /** @returns {string} what to do while there is no picture; "" when there is one */
  get why() {
    return this.frame ? "" : t("uploads.drop_pictures_of_the_board_here");
  }

  /** Files that still wait. */
  get waiting() {
    return this.#waiting;
  }

  open() {}

  /** Those that still wait are not sent any more. */
  close() {
    this.#closed = true;
  }

  /** @returns {Promise<void>} when nothing is on its way */
  idle() {
    return this.#line;
  }

  /** @param {Iterable<File>} files */
  add(files) {
    for (const file of files) {
      this.files.push(file);
      this.#waiting += 1;
      this.#line = this.#line.then(() => this.#judge(file));
    }
    return this.#line;
  }

  /** @param {File} file */
  async #judge(file) {
    if (this.#closed) return;
    const attempt = await this.#attempt(file).catch((error) => ({
      name: file.name,
      kind: "refused",
      words: error instanceof Error ? error.message : t("uploads.that_did_not_work"),
    }));
    this.attempts = [attempt, ...this.attempts].slice(0, 200);
    this.#waiting -= 1;
  }

  /** @param {File} file @returns {Promise<Attempt>} */
  async #attempt(file) {
    if (!KINDS.has(file.type)) throw new Error("Not a JPEG or PNG picture.");
    if (file.size > LARGEST) throw new Error("Larger than 20 MB; export it smaller, at the size the camera uses.");
    const verdict = await this.send(file, file.name);
    const image = await createImageBitmap(file, { imageOrientation: "none" }).catch(() => null);
    if (image) {
      if (this.frame?.image instanceof ImageBitmap) this.frame.image.close();
      this.#count += 1;
      this.frame = { image, width: image.width, height: image.height, key: `file ${this.#count}`, stamp_s: null };
    }
    return { name: file.name, kind: verdict.kind, words: verdict.words };
  }
}
