// The status line tells the newest fact and lets it go.

import assert from "node:assert/strict";
import { test } from "node:test";
import { wordsOf } from "../../static/js/net/api.js";
import { ASKS_MS, RESULT_MS, SLOW_MS, STAYS_MS, StatusLog } from "../../static/js/ui/status.js";
import { STATE, VIEW } from "./view.js";

/** @import { HistoryRow } from "../../static/js/net/rest.js" */
/** @import { View } from "../../static/js/net/session.js" */

/** @type {import("../../static/js/ui/status.js").StatusLine} */
const READY = { icon: "command", words: "Ready", remark: "Type.", state: "", suggestions: [] };
/** @type {import("../../static/js/net/messages.js").CommandState} */
const RUNNING = {
  ...{ id: 7, name: "turn_left", numbers: {}, heard_as: "turn left", source: "typed", who: "Ada" },
  state: "running",
  ...{ remark: "", progress: 0.1 },
};

/** @param {Partial<import("../../static/js/net/messages.js").State>} change @returns {View} */
const seen = (change) => ({ ...VIEW, state: { ...STATE, ...change } });
const IDLE = seen({});
const RUNS = seen({ command: RUNNING });
const HALTED = seen({ gate: { ...STATE.gate, state: "halted" } });
const BY_HAND = seen({ gate: { ...STATE.gate, source: "jog" }, velocity: { v_m_s: 0.18, w_rad_s: 0 } });
/** @type {View} */
const LOST = { ...IDLE, up: false, mine: false, link: { ...VIEW.link, is: "down" } };

/** @param {number} id @param {string} state @param {Partial<HistoryRow>} [more] @returns {HistoryRow} */
const row = (id, state, more = {}) => ({
  ...{ id, at_s: 0, duration_s: 1, source: "typed", words: "turn left", heard_as: "turn left", name: "turn_left" },
  ...{
    numbers: {},
    what: "",
    who: "Ada",
    role: "operator",
    state,
    remark: "",
    ended_s: null,
    code: null,
    values: null,
  },
  ...more,
});

/** @param {string} text @param {boolean} ok @param {number} at @param {object} [more] */
const said = (text, ok, at, more = {}) => ({
  text,
  source: /** @type {const} */ ("typed"),
  at,
  answer: { kind: /** @type {const} */ ("answer"), ref: 1, ok, status: ok ? 202 : 422, ...more },
});

/** @type {import("../../static/js/voice/audio-socket.js").Transcript} */
const REFUSED = {
  ...{ kind: "transcript", id: 1, words: "start", final: true, accepted: false, heard_as: "" },
  ...{ reason: "I am not sure.", suggestions: ["start"], seconds: 1, confidence: 0.9, delay_s: 0.1 },
  ...{ entry: null, pending_command: null, code: null, values: null },
};

/** A log that has seen an idle robot and an old history. */
function fresh() {
  const log = new StatusLog();
  log.saw(IDLE, 0);
  log.ended([row(1, "refused", { remark: "Old news." })], 0, 0);
  return log;
}

/** @param {StatusLog} log @param {View} view @param {number} now */
function shown(log, view, now) {
  log.saw(view, now);
  const { words, remark, suggestions } = log.line(view, now, READY);
  return [words, remark, ...suggestions].filter(Boolean).join(" | ");
}

test("with nothing to tell it is ready, and what was before the page opened is no news", () => {
  assert.equal(shown(fresh(), IDLE, 10), "Ready | Type.");
});

test("a command runs, is done, and fades", () => {
  const log = fresh();
  log.answered(said("turn left", true, 100, { id: 7, detail: "turn left" }), 120);
  assert.equal(shown(log, IDLE, 130), "turn left");
  assert.equal(shown(log, RUNS, 200), "turn left");
  log.saw(IDLE, 2000);
  log.ended([row(7, "done")], 2000, 2010);
  assert.equal(shown(log, IDLE, 2020), "turn left | done");
  assert.equal(shown(log, IDLE, 2010 + STAYS_MS + 1), "Ready | Type.");
});

test("the line of a command stays until its result came, or does not come", () => {
  const log = fresh();
  assert.equal(shown(log, RUNS, 200), "turn left");
  assert.equal(shown(log, IDLE, 2000), "turn left");
  log.ended([row(7, "done")], 3000, 3000);
  assert.equal(shown(log, IDLE, 3010), "turn left | done");
  assert.equal(shown(log, RUNS, 20_000), "turn left");
  assert.equal(shown(log, IDLE, 20_000 + RESULT_MS + 1), "Ready | Type.");
});

test("while the button is held it says what it hears, and its words have one verdict", () => {
  const log = fresh();
  log.listens("", 1000);
  assert.equal(shown(log, IDLE, 1100), "Listening…");
  log.listens("turn", 1500);
  assert.equal(shown(log, IDLE, 1600), "“turn …”");
  log.listens(null, 2000);
  log.reads(2000, "turn left");
  assert.match(shown(log, IDLE, 2100), /^Reading what you said… . “turn left …”/);
  log.heard({ ...REFUSED, accepted: true, heard_as: "turn left" }, 11_000);
  log.wasRead(11_500);
  assert.equal(shown(log, IDLE, 11_600), "Ready | Type.");
});

test("STOP overtakes every result, also one whose row comes late", () => {
  const log = fresh();
  log.saw(RUNS, 100);
  log.saw(IDLE, 1900);
  log.ended([row(7, "done")], 1900, 1910);
  log.stopped(true, 3000);
  assert.equal(shown(log, IDLE, 3010), "Stopped");
  const late = fresh();
  late.saw(RUNS, 100);
  late.stopped(true, 3000);
  late.ended([row(7, "done")], 3050, 3060);
  assert.equal(shown(late, IDLE, 3070), "Stopped");
  assert.equal(shown(late, IDLE, 3000 + STAYS_MS + 1), "Ready | Type.");
});

test("STOP says which command it cancelled, and a new command is newer than STOP", () => {
  const log = fresh();
  log.saw(RUNS, 100);
  log.stopped(true, 3000);
  log.ended([row(7, "cancelled", { remark: "Stopped by Ada." })], 3050, 3060);
  assert.equal(shown(log, IDLE, 3070), "Stopped | turn left: cancelled.");
  assert.equal(shown(log, seen({ command: { ...RUNNING, id: 8, heard_as: "turn right" } }), 3500), "turn right");
});

test("an answer to words that were sent before STOP does not overtake it", () => {
  const log = fresh();
  log.stopped(true, 1000);
  log.answered(said("turn lift", false, 990, { detail: "Unknown.", suggestions: ["turn left"] }), 1040);
  log.answered(said("turn left", true, 995, { id: 9, detail: "turn left" }), 1050);
  assert.equal(shown(log, IDLE, 1060), "Stopped");
});

test("a stop in words is a stop", () => {
  const log = fresh();
  log.answered(said("stop", true, 1000, { id: 9, detail: "stop moving" }), 1040);
  assert.equal(shown(log, IDLE, 1060), "Stopped");
  const heard = {
    name: "stop_moving",
    words: "Please stop",
    heard_as: "stop moving",
    remark: "The robot stands still.",
  };
  log.ended([row(9, "done", heard)], 1100, 1110);
  assert.equal(shown(log, IDLE, 1120), "Stopped | The robot stands still.");
});

test("what is refused after a stop in words is told, also when the row of the stop comes last", () => {
  const log = fresh();
  log.answered(said("stop", true, 1000, { id: 9, detail: "stop moving" }), 1040);
  log.answered(said("turn left", false, 1050, { detail: "Only an operator drives it." }), 1060);
  log.ended([row(9, "done", { name: "stop_moving", words: "stop", heard_as: "stop moving" })], 1100, 1110);
  assert.match(shown(log, IDLE, 1120), /operator/);
});

test("words that only stopped the robot are told with the reason", () => {
  const log = fresh();
  log.answered(said("stop at 50 and 3", true, 1000, { id: 9, detail: "stop moving" }), 1040);
  const why = "“stop at 50 and 3” was not carried out: x goes from -20 to 20 metres.";
  const heard = { name: "stop_moving", words: "stop at 50 and 3", heard_as: "stop moving", remark: why };
  log.ended([row(9, "done", heard)], 1100, 1110);
  assert.equal(shown(log, IDLE, 1120), `Stopped | ${why}`);
});

test("after the reset of a halt its refusals are gone", () => {
  const log = fresh();
  assert.equal(shown(log, HALTED, 1000), "Halted | Nothing moves until the halt is reset.");
  log.answered(said("turn left", false, 1500, { detail: "The robot is halted." }), 1520);
  log.ended([row(9, "refused", { remark: "The robot is halted." })], 1530, 1540);
  assert.equal(shown(log, HALTED, 1600), "turn left | refused. The robot is halted.");
  assert.equal(shown(log, IDLE, 2000), "Reset, ready | The reset moved nothing.");
  assert.equal(shown(log, IDLE, 2000 + STAYS_MS + 1), "Ready | Type.");
  assert.match(shown(log, HALTED, 20_000), /^Halted/);
});

test("driving by hand shows its speed and ends what was told before", () => {
  const log = fresh();
  log.ended([row(7, "done")], 900, 910);
  assert.equal(shown(log, BY_HAND, 1000), "Driving by hand | 0.18 m/s");
  assert.equal(shown(log, IDLE, 1500), "Ready | Type.");
  assert.equal(shown(log, { ...BY_HAND, mine: false }, 2000), "Ada drives by hand | 0.18 m/s");
  log.stopped(true, 2100);
  assert.equal(shown(log, BY_HAND, 2110), "Stopped"); // the wheels still turn: it is the newest all the same
});

test("a lost link is newer than a refusal, and STOP without a link does not claim to have stopped anything", () => {
  const log = fresh();
  log.answered(said("sing", false, 900, { detail: "Unknown." }), 910);
  assert.equal(shown(log, LOST, 1000), "No link | Commands are not sent until it is back.");
  log.stopped(false, 1500);
  assert.match(shown(log, LOST, 1510), /^No link \| STOP may not arrive/);
  log.stopped(true, 1550); // by HTTP
  assert.equal(shown(log, LOST, 1560), "Stopped");
  assert.equal(shown(log, IDLE, 1550 + STAYS_MS + 1), "Ready | Type.");
});

test("a refusal leaves the running command alone: told for a while, then what runs is told again", () => {
  const log = fresh();
  log.saw(RUNS, 100);
  log.answered(said("come here", false, 1000, { detail: "I heard nobody." }), 1010);
  log.ended([row(8, "refused", { words: "come here", heard_as: "" }), row(7, "running")], 1020, 1030);
  assert.equal(shown(log, RUNS, 1100), "come here | refused. I heard nobody.");
  assert.equal(shown(log, RUNS, 1030 + STAYS_MS + 1), "turn left");
  log.ended([row(8, "refused"), row(7, "failed", { remark: "Blocked." })], 12_000, 12_010); // it is not the newest row
  assert.equal(shown(log, IDLE, 12_020), "turn left | failed. Blocked.");
});

test("a refusal with suggestions stays longer, and a late row of an earlier refusal does not overtake it", () => {
  const log = fresh();
  log.answered(said("continue 99", false, 500, { detail: "Too far." }), 510);
  log.answered(said("turn lift", false, 900, { detail: "Unknown.", suggestions: ["turn left"] }), 910);
  log.ended([row(8, "refused", { words: "continue 99", heard_as: "", remark: "Too far." })], 950, 960);
  assert.equal(shown(log, IDLE, 970), "turn lift | refused. Unknown. | turn left");
  log.ended([row(9, "refused", { words: "turn lift", heard_as: "", remark: "Unknown." })], 980, 990);
  assert.equal(shown(log, IDLE, 990 + STAYS_MS + 1), "turn lift | refused. Unknown. | turn left");
  assert.equal(shown(log, IDLE, 990 + ASKS_MS + 1), "Ready | Type.");
});

test("a refusal keeps the code of its sentence, whether the answer, the words or the row bring it", () => {
  const code = "words.unknown_like";
  const log = fresh();
  log.answered(said("turn lift", false, 900, { detail: "Unknown.", code, suggestions: ["turn left"] }), 910);
  assert.equal(log.line(IDLE, 920, READY).code, code);
  log.heard({ ...REFUSED, code }, 1000);
  assert.equal(log.line(IDLE, 1010, READY).code, code);
  log.ended([row(9, "refused", { words: "turn rite", heard_as: "", code: "words.unknown" })], 1200, 1210);
  assert.equal(log.line(IDLE, 1220, READY).code, "words.unknown");
});

test("what was meant is offered, too, where the row of a refusal comes before its answer", () => {
  const log = fresh();
  log.ended([row(9, "refused", { words: "turn lift", heard_as: "", remark: "Unknown." })], 950, 960);
  assert.equal(shown(log, IDLE, 970), "turn lift | refused. Unknown.");
  log.answered(said("turn lift", false, 900, { detail: "Unknown.", suggestions: ["turn left"] }), 980);
  assert.equal(shown(log, IDLE, 990), "turn lift | refused. Unknown. | turn left");
  assert.equal(shown(log, IDLE, 980 + ASKS_MS + 1), "Ready | Type.");
});

test("nothing is offered after STOP, neither what was offered before nor what was said before it", () => {
  const log = fresh();
  log.heard(REFUSED, 1000);
  assert.match(shown(log, IDLE, 1010), /start$/);
  log.heard({ ...REFUSED, words: "stop", final: false, accepted: true, heard_as: "stop moving" }, 1500);
  log.heard({ ...REFUSED, suggestions: [], overtaken: true }, 1600);
  log.ended([row(9, "refused", { words: "start", heard_as: "", source: "voice" })], 1450, 1700);
  assert.equal(shown(log, IDLE, 1710), "Stopped");
});

test("who speaks again reads what is heard, not the verdict on the words before; a stop is shown at once", () => {
  const log = fresh();
  log.reads(1000);
  log.listens("", 2000);
  log.wasRead(2500);
  assert.equal(shown(log, IDLE, 2600), "Listening…");
  log.heard({ ...REFUSED, words: "come here often", reason: "That is no command." }, 2700);
  assert.equal(shown(log, IDLE, 2800), "Listening…");
  log.stopped(true, 3000);
  assert.equal(shown(log, IDLE, 3100), "Stopped");
});

test("between the spoken words and their result it says that it reads, that this is slow, and that nothing came", () => {
  const log = fresh();
  log.reads(1000);
  assert.match(shown(log, IDLE, 1500), /^Reading what you said… \| 0\.5 s/);
  assert.match(shown(log, IDLE, 1000 + SLOW_MS), /slow on this computer; type, or wait/);
  assert.match(shown(log, IDLE, 15_000), /^Reading what you said…/); // no verdict before all of it was read
  log.wasRead(15_100);
  assert.match(shown(log, IDLE, 15_110), /^Not understood/);
  log.reads(20_000);
  log.heard({ ...REFUSED, words: "", reason: "" }, 20_500);
  assert.match(shown(log, IDLE, 20_510), /^Not understood/);
  log.reads(40_000);
  log.heard({ ...REFUSED, accepted: true, heard_as: "turn left" }, 40_500);
  assert.equal(shown(log, IDLE, 40_510), "Ready | Type.");
});

test("what another operator was refused is not told here; what a voice in the room was is", () => {
  const log = new StatusLog();
  log.saw(IDLE, 0);
  log.ended([], 0, 0);
  log.ended([row(3, "refused", { who: "Ben", remark: "Ada drives now." })], 1000, 1010);
  assert.equal(shown(log, IDLE, 1020), "Ready | Type.");
  log.ended([row(5, "refused", { who: "Ada", remark: "A person is in the way." })], 1050, 1060);
  assert.equal(shown(log, IDLE, 1070), "turn left | refused. A person is in the way.");
  log.ended([row(4, "refused", { words: "come here", source: "ears", remark: "I see nobody." })], 1100, 1110);
  assert.equal(shown(log, IDLE, 1120), "turn left | refused. I see nobody.");
});

test("a stop of a route that was reached is not told while the robot drives to the next one", () => {
  const log = fresh();
  log.saw(RUNS, 1000);
  log.ended([row(7, "running"), row(6, "done", { words: "go to desk", heard_as: "go to desk" })], 1010, 1010);
  assert.equal(shown(log, RUNS, 1020), "turn left");
});

test("a press on the floor goes there: “stop” was said by nobody", () => {
  const row = { heard_as: "stop at 2.88 and -0.25", words: "stop at 2.88 and -0.25" };
  assert.equal(wordsOf({ ...row, source: "click" }), "go to 2.88 and −0.25");
  assert.equal(wordsOf({ ...row, source: "camera" }), "go to 2.88 and −0.25");
  assert.equal(wordsOf({ ...row, source: "typed" }), "stop at 2.88 and −0.25");
  assert.equal(wordsOf({ heard_as: "stop moving", source: "click" }), "stop moving");
});
