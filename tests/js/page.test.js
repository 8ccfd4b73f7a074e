// How pages start, and how a refusal reaches the operator.

import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { Refusal, sentenceOf } from "../../static/js/net/api.js";

Object.assign(globalThis, {
  addEventListener: () => {},
  document: { addEventListener: () => {}, baseURI: "http://robot/", visibilityState: "visible" },
  setInterval: () => 0,
});
const { Session } = await import("../../static/js/net/session.js");
const ROOT = new URL("../../static/", import.meta.url);

test("what is refused becomes a notice with the sentence of the server, and the caller learns of it", async () => {
  const session = new Session();
  /** @type {string[]} */
  const notices = [];
  session.on("trouble", (sentence) => notices.push(sentence));
  assert.equal(await session.attempt(async () => "done"), true);
  assert.equal(await session.attempt(() => Promise.reject(new Refusal(409, "Another operator has control."))), false);
  assert.equal(await session.attempt(() => Promise.reject("?")), false);
  assert.deepEqual(notices, ["Another operator has control.", "That did not work."]);
  assert.equal(sentenceOf(null, "The map could not be read."), "The map could not be read.");
});

test("every page starts through one module, which alone creates a session", () => {
  const pages = readdirSync(ROOT).filter((name) => name.endsWith(".html"));
  assert.ok(pages.length >= 4);
  for (const page of pages) {
    const entry = /<script type="module" src="static\/([^"]*)">/.exec(readFileSync(new URL(page, ROOT), "utf8"))?.[1];
    assert.ok(entry, page);
    assert.match(readFileSync(new URL(entry, ROOT), "utf8"), /^startPage\(/m, page);
  }
  const scripts = readdirSync(new URL("js/", ROOT), { recursive: true, encoding: "utf8" });
  const creators = scripts.filter(
    (name) => name.endsWith(".js") && readFileSync(new URL(`js/${name}`, ROOT), "utf8").includes("new Session("),
  );
  assert.deepEqual(creators, ["page.js"]);
});
