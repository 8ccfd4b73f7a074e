import assert from "node:assert/strict";
import { mock, test } from "node:test";
import { inWords, standing, takenBack, takesBack } from "../../static/js/calibration/active-calibration.js";
import { hint } from "../../static/js/calibration/board-hint.js";
import { cameraRows, decimals, mountRows, poseRows } from "../../static/js/calibration/figures.js";
import { figures, heat, heatWords, known, share } from "../../static/js/calibration/progress.js";
import { hashOf, placeOf } from "../../static/js/calibration/router.js";
import { grouped } from "../../static/js/calibration/uploads.js";
import { webcamRefusal } from "../../static/js/calibration/webcam.js";
import { mirrored, Pace, quietWords } from "../../static/js/calibration/words.js";
import { sure } from "../../static/js/ui/row-question.js";

/** @import { Calibration, Pixel, Verdict } from "../../static/js/calibration/types.js" */

/** @param {Partial<Verdict>} told @returns {Verdict} */
const verdict = (told) => ({
  kind: "nothing",
  words: "I see no board.",
  name: "",
  number: 1,
  corners: null,
  laser: null,
  beams: null,
  stamp_s: null,
  ...told,
});

/** @param {number} u @param {number} v @param {number} step @returns {Pixel[]} a grid of 3 x 2 corners */
const grid = (u, v, step) =>
  [0, 1].flatMap((row) => [0, 1, 2].map((column) => /** @type {Pixel} */ ([u + column * step, v + row * step])));

/** @param {Partial<Calibration["progress"]>} progress @param {"camera" | "laser"} kind */
const session = (progress, kind = "camera") =>
  /** @type {Calibration} */ ({
    kind,
    progress: { views: 0, ready: false, words: "", p95_px: null, target_px: 0.5, precision: null, ...progress },
  });

test("an address leads back to the place it was made for", () => {
  for (const place of /** @type {const} */ ([
    { at: "home" },
    { at: "new", kind: "laser" },
    { at: "capture", id: "ab12" },
    { at: "review", id: "ab12" },
    { at: "microphones" },
  ]))
    assert.deepEqual(placeOf(hashOf(place)), place);
  assert.deepEqual(placeOf("#s=<script>"), { at: "home" });
  assert.deepEqual(placeOf("#new=toaster"), { at: "home" });
});

test("in a mirror left is right, in every word and nowhere else", () => {
  assert.equal(mirrored("Left edge away, fill the top right."), "Right edge away, fill the top left.");
  assert.equal(mirrored("nach links, näher"), "nach rechts, näher");
  assert.equal(mirrored("Leftover brightness"), "Leftover brightness");
});

test("while nothing is judged the page says why, or what to do", () => {
  const seeing = { paused: false, blind: "", simulated: true };
  const robot = { source: /** @type {const} */ ("robot"), verdict: null, demo: false };
  assert.match(quietWords(robot, seeing), /press Show me/);
  assert.match(quietWords(robot, { ...seeing, simulated: false }), /Show the board/);
  assert.match(quietWords({ ...robot, verdict: verdict({}) }, { ...seeing, paused: true }), /Paused/);
  assert.equal(
    quietWords({ ...robot, verdict: verdict({}) }, { ...seeing, blind: "No new pictures." }),
    "No new pictures.",
  );
  assert.equal(quietWords({ ...robot, verdict: verdict({}) }, seeing), "");
});

test("a judgement stays long enough to be read, a newer judgement replaces it", () => {
  const pace = new Pace();
  pace.show(verdict({ kind: "refused", words: "Blurred.", number: 1 }), 0, 0);
  assert.equal(pace.show(verdict({ kind: "moving", words: "Hold still", number: 2 }), 0, 300)?.words, "Blurred.");
  assert.equal(pace.show(verdict({ kind: "counted", words: "Counted.", number: 3 }), 1, 400)?.words, "Counted.");
  assert.equal(pace.show(verdict({ kind: "moving", words: "Hold still", number: 4 }), 1, 2500)?.words, "Hold still");
});

test("a view that was counted between two messages is told and counted all the same", () => {
  const pace = new Pace();
  pace.show(verdict({ number: 1 }), 4, 0);
  const told = pace.show(verdict({ kind: "same", words: "Same as view 5.", number: 9 }), 5, 100);
  assert.equal(told?.kind, "counted");
  assert.equal(pace.counted, 1);
});

test("aloud: judgements at once and each once, calm words when they last, counting along never", () => {
  const pace = new Pace();
  pace.show(verdict({ kind: "refused", words: "Blurred.", number: 1 }), 0, 0);
  assert.equal(pace.say(10), "Blurred.");
  assert.equal(pace.say(20), "");
  pace.show(verdict({ words: "I see no board.", number: 2 }), 0, 2000);
  assert.equal(pace.say(2100), "");
  assert.equal(pace.say(4000), "I see no board.");
  pace.show(verdict({ kind: "gathering", words: "3 of 20 scans", number: 3 }), 0, 4100);
  assert.equal(pace.say(9000), "");
});

test("the way to the wanted view: where to, how near, and when only the tilt is wrong", () => {
  const wanted = grid(200, 150, 40);
  assert.equal(hint(grid(200, 150, 40), wanted, 640)?.there, true);
  assert.equal(hint(grid(20, 150, 40), wanted, 640)?.words, "right");
  assert.match(hint(grid(230, 160, 20), wanted, 640)?.words ?? "", /closer/);
  assert.match(hint(grid(120, 110, 120), wanted, 640)?.words ?? "", /farther/);
  const tilted = grid(100, 100, 200).map(([u, v], i) => /** @type {Pixel} */ ([u, i < 3 ? v : v + (i - 4) * 190]));
  assert.equal(hint(grid(100, 100, 200), tilted, 640)?.words, "tilt it as drawn");
  assert.equal(hint([], wanted, 640), null);
});

test("the bar grows with every step and is full only when it is good enough", () => {
  const along = [
    session({}),
    session({ views: 3 }),
    session({ views: 4, p95_px: 6 }),
    session({ views: 6, p95_px: 1 }),
    session({ views: 7, p95_px: 0.5 }),
    session({ views: 8, p95_px: 0.4, ready: true }),
  ].map(share);
  assert.deepEqual(
    [...along].sort((a, b) => a - b),
    along,
  );
  assert.ok((along[4] ?? 1) < 1);
  assert.equal(along.at(-1), 1);
  assert.ok(share(session({ views: 30, precision: { yaw: 1 } }, "laser")) < 1);
});

test("values are printed with two digits of their doubt", () => {
  assert.deepEqual([decimals(0.41), decimals(0.0062), decimals(17), decimals(NaN)], [2, 4, 0, 4]);
  const solution = { fx: 533.092, k1: -0.28999, sd: { fx: 0.41, k1: 0.0021 } };
  const rows = cameraRows(solution, { fx: [533.092, 540.1] });
  assert.deepEqual(
    rows.map(({ value, sd }) => [value, sd]),
    [
      ["533.09", "± 0.41"],
      ["−0.2900", "± 0.0021"],
    ],
  );
  assert.equal(rows[0]?.other, "540.10");
  assert.equal(rows[0]?.change, "−7.01");
  assert.equal(rows[0]?.far, true);
});

test("a direction that is not known has no number", () => {
  const solution = {
    turn_deg: [0.1, -1.2, 0.4],
    translation_m: [0.0412, -0.01, 0.04],
    sd_rotation_deg: [0.2, 0.1, 0.1],
    sd_translation_m: [0.001, 0.002, 0.05],
    not_known: ["height"],
  };
  const rows = mountRows(solution, null);
  assert.equal(rows[5]?.value, "not known");
  assert.equal(rows[5]?.open, true, "in every language it is marked so");
  assert.equal(rows[5]?.sd, "");
  assert.equal(rows[3]?.value, "41.2 mm");
  assert.equal(rows[1]?.value, "−1.20°");
  assert.deepEqual([known(0.9), known(0.6), known(0.1)], ["known", "weak", "open"]);
  assert.deepEqual([known(0.75, 0.8), known(0.75, 0.7), known(0.75)], ["weak", "known", "known"]);
});

test("where the browser lends no camera, the page says why and what else can be done", () => {
  assert.match(webcamRefusal(), /http:\/\/127\.0\.0\.1.*https.*picture files/s);
});

test("the heat map gets warmer with doubt and says in words where it is least sure", () => {
  const [cold, warm] = [heat(0.1, 0.5), heat(3, 0.5)];
  assert.ok(warm[0] > cold[0]);
  assert.notDeepEqual(heat(null, 0.5), heat(0.1, 0.5));
  const map = {
    columns: 3,
    rows: 3,
    sd_px: [
      [0.2, 0.2, 2.5],
      [0.2, 0.1, 0.2],
      [0.6, 0.2, 0.2],
    ],
  };
  assert.match(heatWords(map, 0.5), /^78 % of the picture within the goal; least known: top right/);
});

test("a session in the list says whether its calibration is in use, or was", () => {
  /** @type {import("../../static/js/net/rest.js").SessionRow} */
  const row = {
    id: "a",
    kind: "camera",
    source: "robot",
    created_s: 1,
    views: 6,
    ready: true,
    accepted: true,
    accepted_s: 100,
  };
  assert.equal(standing(row, { accepted_s: 99.5 }), "in use");
  assert.equal(standing(row, { accepted_s: 99.5, not_used: "It is for other pictures." }), "accepted, not used");
  assert.match(standing(row, null), /^was in use/);
  assert.match(standing(row, { accepted_s: 400 }), /^was in use/); // another one since
  assert.match(standing({ ...row, accepted_s: 900 }, { accepted_s: 99.5 }), /^was in use/); // taken back to an older one
  assert.equal(standing({ ...row, accepted: false, accepted_s: null }, null), "good enough, not yet accepted");
});

test("what is not to happen by accident asks once more and forgets that it asked", () => {
  mock.timers.enable({ apis: ["setTimeout"] });
  const named = new Map([["aria-label", "Take it back: camera"]]);
  const button = /** @type {HTMLButtonElement} */ (
    /** @type {unknown} */ ({
      textContent: "Take it back",
      dataset: {},
      querySelector: () => null,
      getAttribute: (/** @type {string} */ name) => named.get(name) ?? null,
      setAttribute: (/** @type {string} */ name, /** @type {string} */ text) => named.set(name, text),
      removeAttribute: (/** @type {string} */ name) => named.delete(name),
    })
  );
  assert.equal(sure(button, "Press again"), false);
  assert.deepEqual([button.textContent, named.size], ["Press again", 0]);
  mock.timers.tick(7000);
  assert.deepEqual([button.textContent, named.get("aria-label")], ["Take it back", "Take it back: camera"]);
  assert.equal(sure(button, "Press again"), false);
  assert.equal(sure(button, "Press again"), true);
  assert.equal(button.textContent, "Take it back");
  const words = { textContent: "Cancel" };
  Object.assign(button, { querySelector: () => words }); // one with a drawing, which stays
  assert.equal(sure(button, "Press again"), false);
  assert.deepEqual([button.textContent, words.textContent], ["Take it back", "Press again"]);
  mock.timers.reset();
});

test("files that were judged alike stand in one row, in the order in which the newest came", () => {
  const attempts = ["d", "c", "b", "a"].map((name) => ({
    name,
    kind: name === "c" ? "counted" : "nothing",
    words: name === "c" ? "View 1 counted." : "I see no board.",
  }));
  assert.deepEqual(
    grouped(attempts).map(({ names }) => names),
    [["d", "b", "a"], ["c"]],
  );
  assert.deepEqual(grouped([]), []);
});

test("the poses of the board stand with their standard deviations, and only those of views that take part", () => {
  const pose = {
    rvec_rad: [0.1, 0, -0.2],
    tvec_m: [0.01, -0.02, 0.5],
    sd_rotation_rad: [0.001, 0.001, 0.002],
    sd_translation_m: [0.0001, 0.0002, 0.001],
  };
  const rows = poseRows([
    { image: "a", used: true, pose },
    { image: "b", used: false, pose },
  ]);
  const plain = rows.map((row) => row.map((words) => words.replaceAll("\u00a0", " "))); // they break between values alone
  assert.deepEqual(plain, [["a", "10.0 ± 0.10, −20.0 ± 0.20, 500.0 ± 1.00", "5.7 ± 0.06, 0.0 ± 0.06, −11.5 ± 0.11"]]);
});

test("before the first solution the views are counted once, against the number that is needed", () => {
  assert.deepEqual(figures(session({ views: 2 })), { figure: "2", goal: "of 6 views at least" });
});

test("a calibration that was accepted for another camera is not called in use", () => {
  assert.match(inWords("camera", { fx: 533.2, not_used: "" }), /^In use: focal length/);
  assert.equal(inWords("camera", { fx: 533.2, not_used: "It is not used." }), "It is not used.");
});

test("a former calibration is offered only where there is one; else the nominal values", () => {
  const first = { fx: 300, former: false };
  assert.deepEqual(
    [takesBack({ ...first, former: true }), takesBack(first)],
    ["Take the former one back", "Use the nominal values"],
  );
  assert.match(takenBack(first), /the former one is in use again/);
  assert.match(takenBack(null), /the nominal values are used now/);
});
