import assert from "node:assert/strict";
import { test } from "node:test";
import { exampleNumbers, filled, holes, Recall, readable, suggest } from "../../static/js/drive/suggest.js";

/** @import { Kind } from "../../static/js/drive/suggest.js" */

/** @param {string} name @param {string} says */
const metres = (name, says) => ({ name, says, unit: "m", low: -20, high: 20, default: null });

/** @type {Kind[]} */
const KINDS = [
  { name: "turn_left", words: ["turn left"], numbers: [], example: "turn left", summary: "Turns left." },
  { name: "turn_right", words: ["turn right"], numbers: [], example: "turn right", summary: "Turns right." },
  {
    name: "continue",
    words: ["continue {distance_m} meters"],
    numbers: [metres("distance_m", "x")],
    example: "continue 1.5 meters",
    summary: "Straight on.",
  },
  {
    name: "stop_at",
    words: ["stop at {x_m} and {y_m}", "go to {x_m} and {y_m}"],
    numbers: [metres("x_m", "x"), metres("y_m", "y")],
    example: "stop at 2 and 1",
    summary: "Goes there.",
  },
  { name: "stop_moving", words: ["stop moving", "stop"], numbers: [], example: "stop moving", summary: "Stops." },
];
/** @param {string} text */
const texts = (text) => suggest(text, KINDS).map((suggestion) => suggestion.text);

test("a beginning offers all that it could become, the first pattern of each command first", () => {
  assert.deepEqual(texts("t"), ["turn left", "turn right"]);
  assert.deepEqual(texts("st"), ["stop at ", "stop moving", "stop"]);
  assert.deepEqual(texts("TURN  r"), ["turn right"]);
});

test('people say "the" before a place', () => {
  const kitchen = { name: "go_to", words: ["go to kitchen"], numbers: [], example: "", summary: "" };
  assert.deepEqual(
    suggest("go to the k", [kitchen]).map(({ text }) => text),
    ["go to kitchen"],
  );
});

test("an empty box offers each command once", () => {
  assert.equal(texts("").length, KINDS.length);
});

test("words stop at the number that is missing, and go on behind the one that is there", () => {
  const [open] = suggest("cont", KINDS);
  assert.deepEqual([open?.text, open?.complete, open?.shows], ["continue ", false, "continue x meters"]);
  const [closed] = suggest("continue 1,5", KINDS);
  assert.deepEqual([closed?.text, closed?.complete], ["continue 1.5 meters", true]);
  assert.deepEqual(texts("go to −1 and 2"), ["go to -1 and 2"]);
});

test("a number beyond its bounds is told while it is typed", () => {
  const summary = (/** @type {string} */ text) => suggest(text, KINDS).find((one) => one.complete)?.summary;
  assert.equal(summary("stop at 2 and 3"), "Goes there.");
  for (const text of ["stop at 50 and 3", "stop at 2 and −21", "continue 20,5 meters"])
    assert.match(summary(text) ?? "", /-20.*20/, text);
});

test("what is no beginning of anything offers nothing", () => {
  for (const text of ["fly", "turn up", "continue much", "turn left now", "stop at and"])
    assert.deepEqual(texts(text), []);
});

test("every pattern filled with numbers is its own completion", () => {
  for (const kind of KINDS) {
    for (const pattern of kind.words) {
      const text = filled(pattern, { distance_m: 1.5, x_m: -2, y_m: 0.25 });
      assert.ok(texts(text).includes(text), text);
    }
  }
});

test("a form asks for the holes of its pattern and begins with the example's numbers", () => {
  const [, , forward, at] = KINDS;
  assert.ok(forward && at);
  assert.deepEqual(
    holes(at.words[0] ?? "", at).map(({ name }) => name),
    ["x_m", "y_m"],
  );
  assert.deepEqual(exampleNumbers(at), { x_m: 2, y_m: 1 });
  assert.deepEqual(exampleNumbers(forward), { distance_m: 1.5 });
  assert.equal(readable(at.words[0] ?? "", at), "stop at x and y");
});

test("recall walks back and forth and returns what was being typed", () => {
  const recall = new Recall();
  for (const text of ["turn left", "turn right", "turn left"]) recall.add(text);
  assert.equal(recall.older("con"), "turn left");
  assert.equal(recall.older("turn left"), "turn right");
  assert.equal(recall.older("turn right"), "turn right");
  assert.equal(recall.newer(), "turn left");
  assert.equal(recall.newer(), "con");
  assert.ok(!recall.walking);
});

test("recall of nothing leaves the box as it is", () => {
  const recall = new Recall();
  assert.equal(recall.older("abc"), "abc");
});
