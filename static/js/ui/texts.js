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
/** What the console says in English alone (settings, experiments, advice), and how this language says it. @type {Readonly<Record<string, string>>} */
const uncoded = language === "en" ? {} : await catalogue(`${language}.console`);

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
  if (!message || !sentence || language === "en") return;
  Object.assign(message, { [name]: said(sentence, message.code, message.values) });
}

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

/** @type {Array<[RegExp, string]>} English sentences of the console and those of this language, once one was looked for */
const sentences = [];

/** A sentence of the console that came without its code, in this language if the catalogue has it. @param {string} sentence @returns {string} */
export function inLanguage(sentence) {
  const known = language === "en" ? sentence : uncoded[sentence];
  if (known !== undefined) return known;
  if (!sentences.length) {
    const coded = Object.entries(english).filter(([key]) => key.startsWith("console."));
    const both = [...Object.entries(uncoded), ...coded.map(([key, words]) => [words, texts[key] ?? words])];
    for (const [pattern = "", words = ""] of both) {
      const plain = pattern.replace(/[.*+?^$()|[\]\\]/g, "\\$&").replace(/\{(\w+)\}/g, "(?<$1>.+)");
      if (/\w{3}/.test(pattern.replace(/\{\w+\}/g, "")) && !/<(\w+)>.*<\1>/.test(plain))
        sentences.push([new RegExp(`^${plain}$`), words]);
    }
  }
  for (const [pattern, words] of sentences) {
    const found = pattern.exec(sentence);
    if (found) return filled(words, translated(found.groups ?? {}));
  }
  const parts = sentence.split(/(?<=[.!?]) (?=\S)/); // sentences that were put together
  return parts.length > 1 ? parts.map(inLanguage).join(" ") : sentence;
}

/** @param {string} pattern @param {Values} [values] */
const filled = (pattern, values) =>
  values ? pattern.replace(/\{(\w+)\}/g, (hole, name) => String(values[name] ?? hole)) : pattern;

/** @param {string} name */
function known(name) {
  return name in LANGUAGES ? name : "en";
}

/** @param {string} name of a language @returns {Promise<Record<string, string>>} */
async function catalogue(name) {
  return (await import(`../../i18n/${name}.json`, { with: { type: "json" } })).default;
}
