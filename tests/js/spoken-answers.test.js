// What the robot says aloud.

import assert from "node:assert/strict";
import { test } from "node:test";
import { accepted, answer, ended, saidAtStops, sentence, unlessStopped } from "../../static/js/voice/spoken-answers.js";

const unset = { code: null, values: null };
const row = {
  ...{ id: 1, what: "", at_s: 0, ended_s: null, duration_s: 1, source: "typed", words: "", heard_as: "", numbers: {} },
  ...{ who: "me", role: "operator", ...unset },
};
const heard = {
  ...{ kind: /** @type {const} */ ("transcript"), id: 1, suggestions: [], seconds: 1, confidence: 0.9, delay_s: 0 },
  ...{ entry: null, pending_command: null, ...unset },
};

test("words become a sentence", () => {
  assert.equal(sentence(" continue 2.5  meters "), "Continue 2.5 meters.");
  assert.equal(sentence("Who? “turn left”"), "Who? turn left.");
  assert.equal(sentence("stop at −1 and 2"), "Stop at minus 1 and 2.");
  assert.equal(sentence(" "), "");
  assert.ok(sentence("word ".repeat(100)).length <= 281);
});

test("an order is echoed, and a stop told", () => {
  assert.equal(accepted("turn left"), "Turn left.");
  assert.equal(accepted("stop moving"), "Stopping.");
});

test("the end is told once it is worth telling", () => {
  assert.equal(ended({ ...row, state: "done", name: "turn_left", remark: "" }), "Done.");
  assert.equal(ended({ ...row, state: "done", name: "stop_moving", remark: "" }), "");
  assert.equal(
    ended({ ...row, state: "failed", name: "continue", remark: "A wall is in the way." }),
    "A wall is in the way.",
  );
  assert.equal(ended({ ...row, state: "pre-empted", name: "continue", remark: "“x” came after it." }), "");
});

test("a route's words at a stop are said once", () => {
  const notices = [1, 2, 3].map((id) => ({ id, text: `Words ${id}`, cause: id === 2 ? "" : `say ${id}.00` }));
  assert.deepEqual(saidAtStops(notices, 0), ["Words 1", "Words 3"]);
  assert.deepEqual(saidAtStops(notices, 2), ["Words 3"]);
  assert.deepEqual(saidAtStops(notices, 3), []);
});

test("speech that is not a command is not answered, a held button is", () => {
  const nothing = { ...heard, words: "", final: true, accepted: false, heard_as: "", reason: "No command." };
  assert.equal(answer({ ...nothing, held: false }), "");
  assert.equal(answer({ ...nothing, held: true }), "No command.");
  assert.equal(answer({ ...nothing, words: "turn", held: false }), "No command.");
  assert.equal(
    answer({ ...nothing, words: "stop", accepted: true, final: false, heard_as: "stop moving" }),
    "Stopping.",
  );
});

test("the rest of a sentence that said stop offers nothing and is not answered", () => {
  const rest = { ...heard, words: "start", final: true, accepted: false, heard_as: "", reason: "Not sure." };
  const told = { ...rest, suggestions: ["start"] }; // begun 1 s before it came
  assert.deepEqual(unlessStopped(told, 5000, 4500), { ...told, suggestions: [], overtaken: true });
  assert.equal(answer({ ...unlessStopped(told, 5000, 4500), held: true }), "");
  assert.deepEqual(unlessStopped(told, 5000, 3500), told); // said after the stop
  const order = { ...told, accepted: true, heard_as: "turn left" };
  assert.deepEqual(unlessStopped(order, 5000, 4500), order); // an accepted command stays
});
