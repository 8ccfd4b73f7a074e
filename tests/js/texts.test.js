// The page's texts: one catalogue for each language, and none beside them.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { LANGUAGES, said, t, translate } from "../../static/js/ui/texts.js";

const STATIC = fileURLToPath(new URL("../../static/", import.meta.url));
const DOCUMENTS = ["index.html", "fleet.html"];
const JS = readdirSync(`${STATIC}js`, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".js"));
const GENERATED = /^net\/messages|^ui\/texts\.js$/;
/** Texts that are no sentences of the page: commands, and what the robot says aloud in its English voice. */
const ENGLISH = new Set(["I did not understand that", "I answer aloud now.", "That did not work"]);
const FAMILIES = /^((state|command-chain|console|picture-quality-chip|report|setting)\.|connect-robot\.sample_)/; // keys that are put together

/** @param {string} language @returns {Record<string, string>} */
const catalogue = (language) => JSON.parse(readFileSync(`${STATIC}i18n/${language}.json`, "utf8"));
/** @param {string} pattern */
const holes = (pattern) => (pattern.match(/\{\w+\}/g) ?? []).sort().join();
const english = catalogue("en");
// speech-loop.js belongs to a command of the terminal, which speaks English.
const sources = JS.filter((name) => !GENERATED.test(name) && !name.endsWith("speech-loop.js")).map((name) => ({
  name,
  code: readFileSync(`${STATIC}js/${name}`, "utf8"),
}));

test("every language has the same keys, in order, and the same values in its texts", () => {
  for (const language of Object.keys(LANGUAGES)) {
    const texts = catalogue(language);
    assert.deepEqual(Object.keys(texts), Object.keys(english));
    assert.deepEqual(Object.keys(texts), Object.keys(texts).toSorted());
    for (const [key, pattern] of Object.entries(texts)) {
      assert.ok(pattern, `${language} ${key} is empty`);
      assert.equal(holes(pattern), holes(english[key] ?? ""), `${language} ${key}`);
    }
  }
});

test("every text that the pages ask for is in the catalogue, and each one is asked for", () => {
  const html = DOCUMENTS.map((name) => readFileSync(STATIC + name, "utf8")).join("");
  const asked = new Set([...html.matchAll(/\sdata-t(?:-[\w-]+)?="([^"]+)"/g)].map(([, key]) => key));
  for (const { code } of sources) for (const [, key] of code.matchAll(/"([a-z0-9-]+\.[a-z0-9_]+)"/g)) asked.add(key);
  const unasked = Object.keys(english).filter((key) => !asked.has(key) && !FAMILIES.test(key));
  assert.deepEqual(unasked, []);
  for (const { name, code } of sources)
    for (const [, key] of code.matchAll(/\bt\("([^"]+)"/g)) assert.ok(english[key ?? ""], `${name}: ${key}`);
  for (const [, key] of html.matchAll(/\sdata-t(?:-[\w-]+)?="([^"]+)"/g))
    assert.ok(english[key ?? ""], `a document: ${key}`);
});

test("what the documents say in English is what the catalogue says", () => {
  const html = DOCUMENTS.map((name) => readFileSync(STATIC + name, "utf8")).join("");
  for (const [, name, words, key] of html.matchAll(/([\w-]+)="([^"]*)" data-t-\1="([^"]+)"/g))
    assert.equal(words, english[key ?? ""], name ?? "");
  for (const [, key, words] of html.matchAll(/data-t="([^"]+)"[^>]*>([^<]*)</g))
    assert.equal(words, english[key ?? ""]);
  const named = [...html.matchAll(/\s(?:aria-label|title|data-name)="[^"]+"(?! data-t-)/g)].map(([text]) => text);
  assert.deepEqual(named, []);
});

test("no sentence stands in the code: it would stay English in every language", () => {
  /** @type {string[]} */
  const found = [];
  for (const { name, code } of sources) {
    const bare = code
      .replace(/\/\*[\s\S]*?\*\//g, "")
      .replace(/(^|[\s;])\/\/.*$/gm, "$1")
      .replace(/throw new Error\([\s\S]*?\);/g, "");
    for (const [, , text] of bare.matchAll(/(["`])((?:(?!\1)[^\\\n]|\\.)*)\1/g)) {
      const words = (text ?? "").replace(/\$\{[^}]*\}/g, "{}");
      const sentence =
        /^[ ,]?[“A-Z][a-z’']+ ([“a-z{][\w{}’'-]*[,;:]? ?){1,}.*[.!?…]?$/.test(words) && !/[<>=#[\]\\]/.test(words);
      if (sentence && !ENGLISH.has(words)) found.push(`${name}: “${words}”`);
    }
  }
  assert.deepEqual(found, []);
});

test("values stand in the place of their names; a sentence without a translation stays as it came", () => {
  assert.equal(t("command-chain.metres_to_go", { metres: "1.2 m" }), "1.2 m to go");
  assert.equal(said("The robot stands.", "no.such_code", {}), "The robot stands.");
});

test("a sentence without its code is known by its words, with what stands in them", async () => {
  globalThis.localStorage = /** @type {any} */ ({ getItem: () => "de" });
  const there = "../../static/js/ui/texts.js?german";
  const { inLanguage, said } = /** @type {typeof import("../../static/js/ui/texts.js")} */ (await import(there));
  const kept = "It stops by itself 0.35 s after the last command.";
  assert.equal(inLanguage(kept), "Er hält von selbst 0.35 s nach dem letzten Befehl.");
  assert.equal(inLanguage("2 more views at least."), "Noch mindestens 2 Ansichten.");
  assert.equal(said("This robot has no microphones.", null), "Dieser Roboter hat keine Mikrofone.");
  const flat = "The array is flat: the sound may as well come from 31° to the left.";
  assert.match(inLanguage(flat), /ebenso gut von anderswo kommen \(31° nach links\)/);
  const first = "6 more views at least; view 4 brings a first estimate.";
  assert.equal(inLanguage(first), "Noch mindestens 6 Ansichten; Ansicht 4 bringt eine erste Schätzung.");
  const advice =
    "Hold the board close up, fill the top left of the picture, tilt the left edge away by about 50 degrees.";
  const german =
    "Halten Sie die Tafel ganz nah, im Bild oben links, die Kante links um etwa 50 Grad nach hinten gekippt.";
  assert.equal(inLanguage(advice), german);
  assert.equal(inLanguage("Route “round”: Paused by Ann."), "Route „round“: Angehalten von Ann.");
  const both = "I come. I see only legs; the laser keeps you.";
  assert.equal(inLanguage(both), "Ich komme. Ich sehe nur Beine; der Laser behält Sie.");
  assert.equal(inLanguage("Counted as view 4."), "Gezählt als Ansicht 4.");
  assert.equal(inLanguage("Nobody wrote this sentence."), "Nobody wrote this sentence.");
});

test("errors of files and drivers are fetched when one comes, and looked up in no time", async () => {
  globalThis.localStorage = /** @type {any} */ ({ getItem: () => "de" });
  const there = "../../static/js/ui/texts.js?errors";
  const { inLanguage, learn } = /** @type {typeof import("../../static/js/ui/texts.js")} */ (await import(there));
  const trouble = "walk.log is empty.";
  assert.equal(inLanguage("Good."), "Gut.");
  assert.equal(inLanguage(trouble), trouble);
  await learn({ rows: [1, 2], found: [{ reason: "", detail: trouble }] });
  assert.equal(inLanguage(trouble), "walk.log ist leer.");
  const refused = "127.0.0.1:9 cannot be reached: Connection refused.";
  assert.equal(inLanguage(refused), "127.0.0.1:9 ist nicht zu erreichen: Verbindung abgewiesen.");
  assert.equal(inLanguage(`Solve it first. ${trouble}`), "Lösen Sie erst. walk.log ist leer.");
  const began = performance.now();
  for (let number = 0; number < 50; number += 1)
    inLanguage(`Nobody wrote sentence ${number} of the laser, the map {x}.`);
  assert.ok((performance.now() - began) / 50 < 10, `${(performance.now() - began) / 50} ms a sentence`);
});

test("a sentence of the console shows numbers below zero with a minus", () => {
  const row = { remark: "The nearest free place I know is -1.52 and -0.40, by a 9-by-6 board." };
  translate(row, "remark");
  assert.equal(row.remark, "The nearest free place I know is −1.52 and −0.40, by a 9-by-6 board.");
});
