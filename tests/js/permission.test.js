import assert from "node:assert/strict";
import { test } from "node:test";
import { permission } from "../../static/js/drive/permission.js";
import { HELLO, STATE } from "./view.js";

/** @import { State } from "../../static/js/net/messages.js" */

/**
 * @param {{[K in keyof State]?: object}} change
 * @param {object} [you]
 */
function asked(change, you = {}) {
  const merged = Object.entries(change).map(([key, value]) => [key, { .../** @type {any} */ (STATE)[key], ...value }]);
  const state = /** @type {State} */ ({ ...STATE, ...Object.fromEntries(merged) });
  return permission({ hello: { ...HELLO, you: { ...HELLO.you, ...you } }, state, up: true });
}

test("whoever holds the lease of an armed gate may drive", () => {
  assert.equal(asked({}).may, "yes");
});

test("a free wheel is asked for", () => {
  assert.equal(asked({ lease: { holder: null, holder_id: null } }).may, "ask");
});

test("a gate that is not armed under this lease is asked for too", () => {
  assert.equal(asked({ gate: { state: "disarmed" } }).may, "ask");
  assert.equal(asked({ gate: { epoch: 0 } }).may, "ask");
});

test("who may not drive learns why", () => {
  const told = {
    "Bea drives": asked({ lease: { holder: "Bea", holder_id: "bea-1" } }),
    watching: asked({}, { role: "viewer" }),
    Halted: asked({ gate: { state: "halted" } }),
    "does not answer": asked({ robot: { link: "lost" } }),
    "starting up": asked({ robot: { link: "connecting" } }),
    "link to the console is lost": permission({ hello: HELLO, state: STATE, up: false }),
    "recording cannot be driven": permission({
      hello: { ...HELLO, robot: { ...HELLO.robot, drives: false } },
      state: STATE,
      up: true,
    }),
  };
  for (const [words, { may, why }] of Object.entries(told)) {
    assert.equal(may, "no", words);
    assert.ok(why.includes(words), why);
  }
});

test("a camera that cannot drive takes commands for a dry run", () => {
  const webcam = { ...HELLO, robot: { ...HELLO.robot, drives: false, dry_run: true, capabilities: [] } };
  assert.equal(permission({ hello: webcam, state: STATE, up: true }).may, asked({}).may);
});
