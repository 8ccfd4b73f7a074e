// Texts of the page by key: one catalogue for each language, static/i18n/<language>.json. English fills what another lacks.

import { remember, remembered } from "./local-storage.js";

/** @typedef {Record<string, string | number | null | undefined>} Values */

/** Languages that have a catalogue, by their own names. @type {Readonly<Record<string, string>>} */
export const LANGUAGES = { en: "English", de: "Deutsch" };

/** The language that was chosen in the menu; commands and documentation are English in every one. */
export const language = known(remembered("language", "en"));

/** @type {Readonly<Record<string, string>>} */
const english = await catalogue("en");
/** @type {Readonly<Record<string, string>>} */
const texts = language === "en" ? english : { ...english, ...(await catalogue(language)) };
/** What the console says in English alone (settings, experiments, advice), and how this language says it. @type {Record<string, string>} */
const uncoded = language === "en" ? {} : { ...(await catalogue(`${language}.console`)) };
/** The same of errors of files, drivers and services, while it is fetched: once a sentence comes that nothing else has. @type {Promise<unknown> | null} */
let errors = null;
let complete = language === "en"; // nothing is left to fetch

const HOLE = /\{(\w+)\}/g;
const SENTENCE = /^\S+ .*\S .*[.!?…]$/s; // of three words at least
const CLAUSE_KEYS = /^(detail|reason|refused|trouble|warnings|why)$/; // under which also less than a sentence stands
const FETCH_MS = 1000; // after which a sentence is shown in English
const MOST_KEPT = 500; // sentences whose translation is remembered

/**
 * A text of the catalogue, with values in the place of their names in braces.
 * @param {string} key
 * @param {Values} [values]
 */
export function t(key, values) {
  return filled(texts[key] ?? key, values);
}

/**
 * A sentence of the console: by its code in this language where the catalogue has it, else as it came.
 * @param {string} sentence
 * @param {string | null | undefined} code
 * @param {Values | null} [values]
 */
export function said(sentence, code, values) {
  if (!code) return inLanguage(sentence);
  const pattern = language === "en" ? undefined : texts[`console.${code}`];
  return pattern === undefined ? sentence : filled(pattern, translated(values ?? {}));
}

/**
 * Say what the console's messages hold in this language: the sentence under `name`, by its code or its words.
 * @template {string} Name
 * @template {{[name in Name]?: string | null} & {code?: string | null, values?: Values | null}} Message
 * @param {Message | null | undefined} message is changed
 * @param {Name} name
 */
export function translate(message, name) {
  const sentence = message?.[name];
  if (!message || !sentence) return;
  const words = language === "en" ? sentence : said(sentence, message.code, message.values);
  Object.assign(message, { [name]: withMinus(words) });
}

/** Numbers below zero with the sign that the page has for them. @param {string} words */
export const withMinus = (words) => words.replace(/(?<=^|\s)-(?=\d)/g, "−");

/** @param {string} chosen the page is loaded again in this language */
export function chooseLanguage(chosen) {
  remember("language", known(chosen));
  location.reload();
}

/**
 * Write the texts of a document: `data-t="key"` for what an element says, `data-t-title="key"` for its title, and so on.
 * @param {Document} page
 */
export function writeTexts(page) {
  page.documentElement.lang = language;
  for (const element of page.querySelectorAll("*"))
    for (const [name, key] of Object.entries(/** @type {HTMLElement} */ (element).dataset ?? {})) {
      if (!key || !/^t([A-Z]|$)/.test(name)) continue;
      if (name === "t") element.textContent = t(key);
      else
        element.setAttribute(
          name
            .slice(1)
            .replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)
            .slice(1),
          t(key),
        );
    }
}

/** Values that are sentences of the console themselves, in this language. @param {Values} values @returns {Values} */
const translated = (values) =>
  Object.fromEntries(
    Object.entries(values).map(([name, value]) => [name, typeof value === "string" ? inLanguage(value) : value]),
  );

/** A sentence with holes: the longest of its fixed pieces, all of them, and the words of this language. @typedef {{longest: string, pieces: string[], words: string, pattern?: RegExp}} Row */

/** Sentences with holes, those that say most first; null until one is looked for. @type {Row[] | null} */
let rows = null;
/** Translations of sentences that came lately. @type {Map<string, string>} */
const kept = new Map();

/** A sentence of the console that came without its code, in this language if the catalogue has it. @param {string} sentence @returns {string} */
export function inLanguage(sentence) {
  if (language === "en") return sentence;
  const before = kept.get(sentence);
  if (before !== undefined) return before;
  const words = lookedUp(sentence) ?? sentence;
  if (!complete && words === sentence && SENTENCE.test(sentence)) void fetchErrors();
  if (kept.size >= MOST_KEPT) kept.clear();
  kept.set(sentence, words);
  return words;
}

/**
 * See that what an answer says can be said in this language. Resolves after a second at most.
 * @param {unknown} content
 */
export const learn = async (content) => {
  if (!complete && hasUnknown("", content))
    await Promise.race([fetchErrors(), new Promise((resolve) => setTimeout(resolve, FETCH_MS))]);
};

/** @param {string} name @param {unknown} value of that name @returns {boolean} */
function hasUnknown(name, value) {
  if (typeof value === "string")
    return (SENTENCE.test(value) || (CLAUSE_KEYS.test(name) && / .* /.test(value))) && lookedUp(value) === null;
  if (Array.isArray(value)) return typeof value[0] !== "number" && value.some((one) => hasUnknown(name, one));
  return Object.entries(value ?? {}).some(([key, one]) => typeof one !== "number" && hasUnknown(key, one));
}

function fetchErrors() {
  errors ??= catalogue(`${language}.errors`).then(
    (more) => {
      Object.assign(uncoded, more);
      complete = true;
      rows = null;
      kept.clear();
    },
    () => (errors = null), // no link; the next sentence asks again
  );
  return errors;
}

/** @param {string} sentence @returns {string | null} */
function lookedUp(sentence) {
  rows ??= allRows();
  if (Object.hasOwn(uncoded, sentence)) return uncoded[sentence] ?? null;
  const counted = /^\d+ (?:×|because) /.test(sentence) ? together(sentence.split(/; (?=\d)/), "; ") : null; // reasons
  if (counted !== null) return counted;
  for (const row of rows) {
    if (!sentence.includes(row.longest)) continue;
    row.pattern ??= patternOf(row.pieces);
    const found = row.pattern.exec(sentence);
    if (found) return filled(row.words, translated(found.groups ?? {}));
  }
  return together(sentence.split(/(?<=[.!?]) (?=\S)/), " ") ?? ofParts(sentence);
}

/** @param {string[]} parts @param {string} mark between them @returns {string | null} */
function together(parts, mark) {
  const said = parts.length > 1 ? parts.map(lookedUp) : [];
  return said.some((one) => one !== null) ? said.map((one, n) => one ?? parts[n]).join(mark) : null;
}

/** A sentence that is put together: "walk.log: Why not.", or "Why not." where "why not" is known. @param {string} sentence @returns {string | null} */
function ofParts(sentence) {
  const [, about = "", what = ""] = /^(\S+: )(.+)$/s.exec(sentence) ?? [];
  if (what) {
    const words = lookedUp(what);
    return words === null ? null : about + words;
  }
  const [, first = "", rest = ""] = /^([A-Z])(.*)\.$/s.exec(sentence) ?? [];
  const words = first && lookedUp(first.toLowerCase() + rest);
  return words ? `${words.charAt(0).toUpperCase()}${words.slice(1)}.` : null;
}

/** @returns {Row[]} */
function allRows() {
  const coded = Object.entries(english).filter(([key]) => key.startsWith("console."));
  const both = [...Object.entries(uncoded), ...coded.map(([key, words]) => [words, texts[key] ?? words])];
  const found = [];
  for (const [text = "", words = ""] of both) {
    const pieces = text.split(HOLE); // fixed, name, fixed …
    const fixed = pieces.filter((_, n) => n % 2 === 0);
    const names = pieces.filter((_, n) => n % 2);
    if (!names.length) uncoded[text] ??= words;
    if (!names.length || new Set(names).size < names.length || !/\w{2}|×/.test(fixed.join(" "))) continue;
    const longest = fixed.reduce((one, other) => (other.length > one.length ? other : one));
    found.push({ longest, pieces, words, fixed: fixed.join("").length });
  }
  return found.sort((one, other) => other.fixed - one.fixed);
}

/**
 * Only a hole at either end takes more than one sentence; one in quotation marks ends with them.
 * @param {string[]} pieces fixed, name, fixed …
 */
function patternOf(pieces) {
  const plain = pieces.map((piece, n) => {
    if (n % 2 === 0) return piece.replace(/[.*+?^$()|[\]\\{}]/g, "\\$&");
    const [before = "", after = ""] = [pieces[n - 1], pieces[n + 1]];
    const ends = (n === pieces.length - 2 && after === "") || (n === 1 && before === "" && /^ [A-Z]/.test(after));
    const first = n === 1 && before === "" ? "|: " : ""; // what introduces a sentence is no part of it
    return `(?<${piece}>${before.endsWith("“") ? "[^“”]" : ends ? "." : `(?:(?![.!?] [“A-Z]${first}).)`}+)`;
  });
  return new RegExp(`^${plain.join("")}$`, "s");
}

/** @param {string} pattern @param {Values} [values] */
const filled = (pattern, values) =>
  values ? pattern.replace(HOLE, (hole, name) => String(values[name] ?? hole)) : pattern;

/** @param {string} name */
function known(name) {
  return name in LANGUAGES ? name : "en";
}

/** @param {string} name of a language @returns {Promise<Record<string, string>>} */
async function catalogue(name) {
  return (await import(`../../i18n/${name}.json`, { with: { type: "json" } })).default;
}
