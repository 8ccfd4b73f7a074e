import assert from "node:assert/strict";
import { test } from "node:test";
import { HeldKeys, intentionOf, scrolls, takesText } from "../../static/js/drive/keys.js";

const plain = { ctrlKey: false, altKey: false, metaKey: false };
const idle = { typing: false, singleKeys: true };
const typing = { typing: true, singleKeys: true };

/** @param {string} code @param {string} [key] */
const press = (code, key = code) => ({ ...plain, code, key });

test("Escape stops everywhere, also while typing, with any modifier and with single keys switched off", () => {
  for (const where of [idle, typing, { typing: false, singleKeys: false }]) {
    assert.deepEqual(intentionOf(press("Escape"), where), { does: "stop" });
    assert.deepEqual(intentionOf({ ...press("Escape"), ctrlKey: true, metaKey: true, altKey: true }, where), {
      does: "stop",
    });
  }
});

test("Space stops outside text boxes and is a space inside", () => {
  assert.deepEqual(intentionOf(press("Space", " "), idle), { does: "stop" });
  assert.equal(intentionOf(press("Space", " "), typing), null);
});

test("no key drives while typing, with a modifier, or when single keys are off", () => {
  for (const code of ["KeyW", "ArrowUp", "KeyD", "Digit3"]) {
    assert.notEqual(intentionOf(press(code), idle), null);
    assert.equal(intentionOf(press(code), typing), null);
    assert.equal(intentionOf(press(code), { typing: false, singleKeys: false }), null);
    for (const modifier of ["ctrlKey", "altKey", "metaKey"])
      assert.equal(intentionOf({ ...press(code), [modifier]: true }, idle), null);
  }
});

test("in a recording the arrows to the sides go five seconds and leave a slider its own", () => {
  const recording = { ...idle, recording: true };
  assert.deepEqual(intentionOf(press("ArrowLeft"), recording), { does: "seek", seconds: -5 });
  assert.deepEqual(intentionOf(press("ArrowRight"), recording), { does: "seek", seconds: 5 });
  assert.equal(intentionOf(press("ArrowRight"), { ...recording, scrolling: true }), null);
  assert.equal(intentionOf(press("ArrowRight"), { ...typing, recording: true }), null);
  assert.deepEqual(intentionOf(press("ArrowRight"), idle), { does: "drive" });
});

test("digits 1 to 5 choose the speed, others nothing", () => {
  assert.deepEqual(intentionOf(press("Digit1", "1"), idle), { does: "preset", preset: 1 });
  assert.deepEqual(intentionOf(press("Numpad5", "5"), idle), { does: "preset", preset: 5 });
  assert.equal(intentionOf(press("Digit6", "6"), idle), null);
});

test("slash goes to the words, the question mark to the keys", () => {
  assert.deepEqual(intentionOf(press("Slash", "/"), idle), { does: "words" });
  assert.deepEqual(intentionOf(press("Slash", "?"), idle), { does: "help" });
});

test("opposite keys cancel, and what is let go is forgotten", () => {
  const held = new HeldKeys();
  held.press("KeyW");
  held.press("KeyA");
  assert.deepEqual(held.velocity, { v: 1, w: 1 });
  held.press("ArrowUp");
  assert.deepEqual(held.velocity, { v: 1, w: 1 });
  held.press("KeyS");
  held.press("ArrowDown");
  assert.equal(held.velocity.v, 0);
  held.release("KeyS");
  held.release("ArrowDown");
  held.press("KeyQ");
  assert.deepEqual(held.velocity, { v: 1, w: 1 });
  held.clear();
  assert.deepEqual(held.velocity, { v: 0, w: 0 });
});

test("letters go into text boxes and editable text, not into buttons and sliders", () => {
  /** @param {object} element */
  const takes = (element) => takesText(/** @type {any} */ (element));
  assert.ok(
    takes({ tagName: "INPUT", type: "text" }) &&
      takes({ tagName: "TEXTAREA" }) &&
      takes({ tagName: "DIV", isContentEditable: true }),
  );
  assert.ok(
    !takes({ tagName: "INPUT", type: "range" }) && !takes({ tagName: "BUTTON" }) && !takes({ tagName: "CANVAS" }),
  );
  assert.ok(!takesText(null));
});

test("arrows move a list or a slider that has the focus, letters still drive; under a sheet nothing drives, all stops", () => {
  const list = { ...idle, scrolling: true };
  assert.equal(intentionOf(press("ArrowDown"), list), null);
  assert.deepEqual(intentionOf(press("KeyS"), list), { does: "drive" });
  const sheet = { ...idle, reading: true };
  assert.equal(intentionOf(press("KeyW"), sheet), null);
  assert.deepEqual(intentionOf(press("Space", " "), sheet), { does: "stop" });
});

test("what scrolls is told by what it lies in", () => {
  const inside = { closest: (/** @type {string} */ where) => (where.includes(".scrolls") ? {} : null) };
  assert.equal(scrolls(/** @type {any} */ (inside)), true);
  assert.equal(scrolls(/** @type {any} */ ({ closest: () => null })), false);
  assert.equal(scrolls(null), false);
});
