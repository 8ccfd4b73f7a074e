// Why there is no microphone, in words.

import assert from "node:assert/strict";
import { test } from "node:test";
import { inWords, whyNot } from "../../static/js/voice/microphone.js";

/** @param {string} name @param {unknown} value of the browser's global of that name */
const browserHas = (name, value) =>
  Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });

test("a page by http is told that browsers want https", () => {
  browserHas("isSecureContext", false);
  assert.match(whyNot(), /by https, or on this computer by 127\.0\.0\.1/);
});

test("a browser without microphones or without sound worklets is told so", () => {
  browserHas("isSecureContext", true);
  browserHas("navigator", {});
  assert.match(whyNot(), /no access to microphones/);
  browserHas("navigator", { mediaDevices: { getUserMedia: () => undefined } });
  assert.match(whyNot(), /newer one/);
  browserHas("AudioWorkletNode", class {});
  assert.equal(whyNot(), "");
});

test("every refusal of the browser has its own sentence", () => {
  const said = ["NotAllowedError", "NotFoundError", "NotReadableError", "AbortError"].map((name) =>
    inWords(new DOMException("", name)),
  );
  assert.match(said[0] ?? "", /was refused\. Allow it/);
  assert.match(said[1] ?? "", /There is no microphone/);
  assert.match(said[2] ?? "", /Another program holds/);
  assert.match(said[3] ?? "", /does not work here/);
  assert.equal(new Set(said).size, 4);
  assert.match(inWords("nonsense"), /does not work here/);
});
