// Completion of typed commands from the vocabulary. The server alone interprets the grammar.

import { t } from "../ui/texts.js";

/** @import { ParameterRow as NumberRow } from "../net/rest.js" */
/** @typedef {{name: string, words: string[], numbers: NumberRow[], example: string, summary: string, icon?: string, target?: string}} Kind */
/**
 * @typedef {object} Suggestion
 * @property {string} text what goes into the box
 * @property {number} caret where the caret goes
 * @property {boolean} complete can be sent as it is
 * @property {string} shows the pattern as people write it: "continue x meters"
 * @property {string} summary
 */

const HOLE = /^\{(\w+)\}$/;
const AMOUNT = /^(?:[+\-−]?\d+(?:[.,]\d*)?|[+\-−]|[+\-−]?[.,]\d+)$/;

/** @param {string} amount as people write it: "−0,5" */
const plain = (amount) => amount.replace("−", "-").replace(",", ".");

/** @param {string} text */
const tokens = (text) => text.toLowerCase().trim().split(/\s+/).filter(Boolean);

/**
 * How a pattern reads with its holes named: "continue {distance_m} meters" → "continue x meters".
 * @param {string} pattern
 * @param {Kind} kind
 */
export function readable(pattern, kind) {
  return pattern.replace(/\{(\w+)\}/g, (_, name) => kind.numbers.find((number) => number.name === name)?.says ?? name);
}

/**
 * A pattern with its numbers filled in; the words are then understood as they stand.
 * @param {string} pattern
 * @param {Readonly<Record<string, number | string>>} numbers
 */
export function filled(pattern, numbers) {
  return pattern.replace(/\{(\w+)\}/g, (_, name) => String(numbers[name] ?? ""));
}

/**
 * Complete the words when they match the beginning of a pattern, as far as possible.
 * @param {string[]} said
 * @param {string} pattern
 */
function complete(said, pattern) {
  const wanted = pattern.split(" ");
  if (said.length > wanted.length) return null;
  /** @type {string[]} */
  const written = [];
  for (const [index, word] of wanted.entries()) {
    const heard = said[index];
    const hole = HOLE.test(word);
    if (heard === undefined && hole) return { text: `${written.join(" ")} `, complete: false };
    if (heard === undefined) written.push(word);
    else if (hole && AMOUNT.test(heard)) written.push(plain(heard));
    else if (!hole && (index === said.length - 1 ? word.startsWith(heard) : word === heard)) written.push(word);
    else return null;
  }
  return { text: written.join(" "), complete: true };
}

/**
 * @param {string[]} said
 * @param {string} pattern
 * @param {Kind} kind
 * @returns {string} what a number that is too small or too large may be; "" when all are within their bounds
 */
function outOfBounds(said, pattern, kind) {
  for (const [index, word] of pattern.split(" ").entries()) {
    const hole = HOLE.exec(word);
    const number = kind.numbers.find(({ name }) => name === hole?.[1]);
    const value = Number(plain(said[index] ?? ""));
    if (number && said[index] !== undefined && (value < number.low || value > number.high))
      return t("suggest.says_goes_from_low_to_high", {
        says: number.says,
        low: number.low,
        high: number.high,
        unit: number.unit,
      });
  }
  return "";
}

/**
 * At most `most` ways to go on, the first pattern of each command before its variants.
 * @param {string} text
 * @param {readonly Kind[]} kinds
 * @param {number} [most]
 * @returns {Suggestion[]}
 */
export function suggest(text, kinds, most = 5) {
  const said = tokens(text);
  const bare = said.filter((word) => word !== "the"); // "go to the kitchen"
  /** @type {Array<Suggestion & {rank: number}>} */
  const found = [];
  for (const [row, kind] of kinds.entries()) {
    for (const [variant, pattern] of kind.words.entries()) {
      if (said.length === 0 && variant > 0) continue;
      const match = complete(said, pattern) ?? complete(bare, pattern);
      if (!match || found.some((other) => other.text === match.text)) continue;
      const shows = readable(pattern, kind);
      const summary = outOfBounds(said, pattern, kind) || kind.summary;
      found.push({ ...match, caret: match.text.length, shows, summary, rank: variant * 100 + row });
    }
  }
  found.sort((a, b) => a.rank - b.rank);
  return found.slice(0, most).map(({ rank: _, ...suggestion }) => suggestion);
}

/** Recall of earlier commands with the arrow keys, like in a shell. */
export class Recall {
  /** @type {string[]} */
  #said = [];
  #at = 0;
  #draft = "";

  /** @param {string} text */
  add(text) {
    this.#said = this.#said
      .filter((other) => other !== text)
      .concat(text)
      .slice(-50);
    this.#at = this.#said.length;
    this.#draft = "";
  }

  get walking() {
    return this.#at < this.#said.length;
  }

  /** @param {string} present text in the box @returns {string} the one before it */
  older(present) {
    if (!this.walking) this.#draft = present;
    this.#at = Math.max(0, this.#at - 1);
    return this.#said[this.#at] ?? present;
  }

  /** @returns {string} the one after it, at last what was being typed */
  newer() {
    this.#at = Math.min(this.#said.length, this.#at + 1);
    return this.#said[this.#at] ?? this.#draft;
  }

  leave() {
    this.#at = this.#said.length;
    this.#draft = "";
  }
}

/**
 * The numbers that a pattern asks for, in its order.
 * @param {string} pattern
 * @param {Kind} kind
 * @returns {NumberRow[]}
 */
export function holes(pattern, kind) {
  return [...pattern.matchAll(/\{(\w+)\}/g)].flatMap(([, name]) =>
    kind.numbers.filter((number) => number.name === name),
  );
}

/**
 * The numbers of a command's own example: "continue 1.5 meters" → {distance_m: 1.5}. A first filling for its form.
 * @param {Kind} kind
 * @returns {Record<string, number>}
 */
export function exampleNumbers(kind) {
  const said = tokens(kind.example ?? "");
  for (const pattern of kind.words) {
    const wanted = pattern.split(" ");
    const fits =
      wanted.length === said.length && wanted.every((word, index) => HOLE.test(word) || word === said[index]);
    if (!fits) continue;
    return Object.fromEntries(
      wanted.flatMap((word, index) => {
        const name = HOLE.exec(word)?.[1];
        return name ? [[name, Number(said[index])]] : [];
      }),
    );
  }
  return {};
}
