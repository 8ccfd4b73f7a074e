import assert from "node:assert/strict";
import { test } from "node:test";
import { line, Series, SPAN_S, ticks } from "../../static/js/ui/series.js";

test("two minutes are remembered and no more", () => {
  const series = new Series();
  for (let time = 0; time <= 400; time += 0.05) series.add(time, time);
  const [first] = series.samples;
  assert.ok(first && first[0] >= 400 - SPAN_S - 0.3);
  assert.ok(series.samples.length < (SPAN_S / 0.2) * 1.35, `${series.samples.length} samples`);
  assert.ok(Math.abs((series.newest?.[0] ?? 0) - 400) < 0.06);
});

test("a clock that goes back begins anew, and the newest value always stands at the end", () => {
  const series = new Series();
  for (const time of [1, 2, 3]) series.add(time, time);
  series.add(0.5, 9);
  assert.deepEqual(series.samples, [[0.5, 9]]);
  series.add(0.55, 8);
  series.add(0.6, 7);
  assert.deepEqual(series.newest, [0.6, 7]);
});

test("what is not known leaves a gap in the line", () => {
  const series = new Series();
  series.add(0, 1);
  series.add(1, null);
  series.add(2, 3);
  const path = line(
    series.samples,
    1,
    (x) => x,
    (y) => y,
  );
  assert.equal(path, "M0.0 1.0M2.0 3.0");
  assert.equal(series.highest, 3);
  assert.ok(Number.isNaN(new Series().highest));
});

test("an axis has few round values and reaches what it must show", () => {
  for (const high of [0.0004, 0.02, 0.11, 0.9, 1, 1.4, 3, 7.7, 12, 99, 1234]) {
    const marks = ticks(high);
    assert.ok(marks.length >= 2 && marks.length <= 5, `${high}: ${marks}`);
    assert.equal(marks[0], 0);
    assert.ok((marks.at(-1) ?? 0) >= high * 0.999 && (marks.at(-1) ?? 0) <= 2.5 * high, `${high}: ${marks}`);
  }
  assert.deepEqual(ticks(3), [0, 1, 2, 3]);
  assert.deepEqual(ticks(NaN), [0, 1]);
});
