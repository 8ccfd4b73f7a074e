import assert from "node:assert/strict";
import { test } from "node:test";
import { besideChapter, doingOf, figure, inSymbols, shortestFirst } from "../../static/js/experiments/runs-model.js";

/** @param {string} name @param {number} base_s @param {number} run_s @param {number} runs */
const one = (name, base_s, run_s, runs) => ({
  ...{ name, title: name, reproduces: "", counts: "runs", chapter: [] },
  ...{ base_s, run_s, runs },
});

test("what takes least stands first, and what nobody knows the time of stands last", () => {
  const given = [one("long", 5, 60, 40), one("unknown", 0, 0, 1), one("short", 30, 0.1, 40)];
  assert.deepEqual(
    shortestFirst(given)?.map(({ name }) => name),
    ["short", "long", "unknown"],
  );
  assert.equal(shortestFirst(null), null);
});

test("every figure of the chapter stands beside that of the newest run that has one", () => {
  const chapter = [{ name: "worst", unit: "m", value: 0.2, ours: "worst_m" }];
  const experiments = [one("without", 0, 1, 1), { ...one("figure", 0, 1, 1), chapter }];
  /** @param {number | null} ours @param {string} [experiment] */
  const run = (ours, experiment = "figure") =>
    /** @type {import("../../static/js/net/rest.js").ExperimentRunState} */ (
      /** @type {unknown} */ ({ experiment, compared: [{ name: "worst", unit: "m", chapter: 0.2, ours }] })
    );
  const rows = (/** @type {number | null} */ ours) => [{ name: "worst", unit: "m", chapter: 0.2, ours }];
  assert.deepEqual(besideChapter(experiments, []), [{ title: "figure", rows: rows(null) }]);
  const runs = [run(null), run(0.3, "without"), run(0.27), run(0.1)];
  assert.deepEqual(besideChapter(experiments, runs), [{ title: "figure", rows: rows(0.27) }]);
});

test("what a run does is told by its own count and its own estimate, and what is no count as it came", () => {
  assert.equal(doingOf("12 of 40 runs, 1.3 a second, 22 s to go"), "12 of 40 done, 22 s to go");
  assert.equal(doingOf("40 of 40 runs, 1.2 s each, 0 s to go"), "40 of 40 done");
  assert.equal(doingOf("Resumed: 3 of 40 runs were done."), "Resumed: 3 of 40 runs were done.");
});

test("the chapter's symbols are written as it prints them, other names as they are", () => {
  assert.deepEqual(["f_u (pixels)", "v_0 (pixels)", "k1(r)", "success_u"].map(inSymbols), [
    "fᵤ (pixels)",
    "v₀ (pixels)",
    "k1(r)",
    "success_u",
  ]);
});

test("a number and its unit stay in one line of a name", () => {
  assert.equal(inSymbols("Worst average error; laser to 5.6 m"), "Worst average error; laser to 5.6\u00a0m");
  assert.equal(inSymbols("40 minutes"), "40 minutes");
});

test("a figure has as many digits as it deserves and a true minus sign, and nought has none", () => {
  const figures = [
    figure(-7.014, "px"),
    figure(-0.0123, "m"),
    figure(-0.0001, "m"),
    figure(301.46, ""),
    figure(null, "m"),
  ];
  assert.deepEqual(figures, ["−7.01 px", "−0.012 m", "0.000 m", "301.5", "–"]);
});
