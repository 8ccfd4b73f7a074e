import assert from "node:assert/strict";
import { test } from "node:test";
import { about, stateOf, urlOf } from "../../static/js/recordings/recordings-model.js";
import { size } from "../../static/js/ui/format.js";
import { recorderOf } from "../../static/js/ui/recorder.js";
import { HELLO, STATE, VIEW } from "./view.js";

/** @param {Partial<import("../../static/js/net/messages.js").RecorderState>} is */
const recorder = (is) => {
  const recording = { name: null, seconds: 0, bytes: 0, ring_s: 0, ring_limit_s: 120, revision: 0, ...is };
  return { ...VIEW, state: { ...STATE, recording } };
};
const WATCHING = { hello: { ...HELLO, you: { ...HELLO.you, role: /** @type {const} */ ("viewer") } } };

test("time and size are shown while a recording runs, to viewers, too", () => {
  const running = recorder({ name: "walk", seconds: 65.4, bytes: 12_300_000 });
  for (const view of [running, { ...running, ...WATCHING }]) {
    const { runs, time, size } = recorderOf(view);
    assert.deepEqual({ runs, time, size }, { runs: true, time: "1:05", size: "12.3 MB" });
  }
  const { runs, time, whyNot } = recorderOf(recorder({}));
  assert.deepEqual({ runs, time, whyNot }, { runs: false, time: "", whyNot: "" });
});

test("a viewer keeps what just happened, but neither starts nor stops a recording", () => {
  const { whyNot, whyNotKept, held } = recorderOf({ ...recorder({ ring_s: 80 }), ...WATCHING });
  assert.match(whyNot, /operator/);
  assert.deepEqual([whyNotKept, held], ["", "1:20"]);
});

test("what cannot be done says why, and what a setting switches off is not shown", () => {
  const replay = recorderOf({ ...VIEW, state: { ...STATE, recording: null } });
  assert.match(replay.whyNot, /recording already/);
  assert.equal(replay.whyNotKept, replay.whyNot);
  assert.equal(replay.holds, false);
  assert.match(recorderOf(recorder({})).whyNotKept, /just been started/);
  assert.equal(recorderOf(recorder({ ring_limit_s: 0 })).holds, false);
  assert.match(recorderOf({ ...recorder({ ring_s: 9 }), up: false }).whyNotKept, /link/);
});

const WHOLE = {
  name: "walk",
  seconds: 65,
  bytes: 5e6,
  started_s: 0,
  complete: true,
  note: "",
  cause: "",
  robot: "lab",
  messages: {},
};
const WALK = { ...WHOLE, code: null, values: null, file: "walk.mcap" };

test("a recording is whole, runs, is cut, or waits to be recovered", () => {
  assert.equal(stateOf(WALK, null), "whole");
  assert.equal(stateOf({ ...WALK, complete: false }, "walk"), "runs");
  assert.equal(stateOf({ ...WALK, complete: false, code: "recording.cut" }, "other"), "cut");
  assert.equal(stateOf({ ...WALK, complete: false, seconds: 0, code: "recording.recovering" }, null), "unfinished");
});

test("a recording is described by what is known of it", () => {
  assert.equal(about(WALK), "1:05 · 5.0 MB · lab");
  assert.equal(about({ ...WALK, seconds: 0, robot: "" }), "5.0 MB");
  assert.match(about({ ...WALK, started_s: Date.now() / 1000 }), /^today \d\d:\d\d · 1:05/);
  assert.equal(urlOf({ ...WALK, file: "a walk.log" }), "log:a walk.log");
  assert.deepEqual([999, 340_000, 1.25e6, 340e6, 3.4e9].map(size), ["1 kB", "340 kB", "1.3 MB", "340 MB", "3.4 GB"]);
});
