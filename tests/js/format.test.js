import assert from "node:assert/strict";
import { test } from "node:test";
import * as format from "../../static/js/ui/format.js";

test("a number never reads minus zero and carries a true minus sign", () => {
  assert.equal(format.fixed(-0.001, 2), "0.00");
  assert.equal(format.fixed(-1.5, 2), "−1.50");
  assert.equal(format.fixed(NaN, 2), "–");
});

test("what is not a number reads as a dash, whatever its unit", () => {
  const nothing = /** @type {any} */ (null);
  for (const say of [format.metres, format.degrees, format.speed, format.turnRate]) assert.match(say(nothing), /^–/);
  for (const say of [format.age, format.duration, format.timeOfDay]) assert.equal(say(NaN), "–");
});

test("degrees exist only here, and left is positive", () => {
  assert.equal(format.degrees(Math.PI / 2), "90°");
  assert.equal(format.turn(Math.PI / 2), "90° left");
  assert.equal(format.turn(-Math.PI / 4), "45° right");
  assert.equal(format.turn(0.001), "0°");
});

test("an age grows from tenths of seconds to hours", () => {
  assert.deepEqual([0.04, 0.84, 12.4, 185, 9000].map(format.age), ["0.0 s", "0.8 s", "12 s", "3 min", "3 h"]);
});

test("a place in a recording reads like a clock", () => {
  assert.deepEqual([5, 65, 3723].map(format.duration), ["0:05", "1:05", "1:02:03"]);
});

test("a number's key says its unit", () => {
  assert.equal(format.quantity("distance_m", 1.5), "1.50 m");
  assert.equal(format.quantity("angle_rad", Math.PI / 2), "90°");
  assert.equal(format.quantity("v_m_s", 0.1), "0.10 m/s");
  assert.equal(format.quantity("w_rad_s", Math.PI), "180°/s");
  assert.equal(format.quantities({ distance_m: 1.5 }), "1.50 m");
  assert.equal(format.quantities({ x_m: 2, y_m: -1 }), "x 2.00 m, y −1.00 m");
  assert.equal(format.quantities({}), "");
});

test("a direction in words is mirrored left to right", () => {
  assert.equal(format.whereabouts(1, 0), "ahead");
  assert.equal(format.whereabouts(-1, 0), "behind");
  for (const [x, y] of [
    [1, 1],
    [0, 1],
    [-1, 1],
  ]) {
    const [left, right] = [format.whereabouts(x ?? 0, y ?? 0), format.whereabouts(x ?? 0, -(y ?? 0))];
    assert.match(left, /left$/);
    assert.equal(right, left.replace("left", "right"));
  }
});

test("a bearing in words says its side, ahead and behind", () => {
  assert.equal(format.inWords(-0.541), "31° to the right");
  assert.equal(format.inWords(0.541), "31° to the left");
  assert.equal(format.inWords(0.1), "straight ahead");
  assert.equal(format.inWords(-3.1), "behind");
});

test("sigmas are the roots of the diagonal and never imaginary", () => {
  const sigma = format.sigmas([
    [4, 0, 0],
    [0, 9, 0],
    [0, 0, -1e-12],
  ]);
  assert.deepEqual(sigma, { x: 2, y: 3, heading: 0 });
});

test("an ellipse's longer half axis does not depend on how it is turned", () => {
  for (const turned of [0, 0.4, 1.2]) {
    const [c, s] = [Math.cos(turned), Math.sin(turned)];
    const covariance = [
      [9 * c * c + s * s, 8 * c * s],
      [8 * c * s, 9 * s * s + c * c],
    ];
    assert.ok(Math.abs(format.largestSigma(covariance) - 3) < 1e-12);
  }
});

test("uncertainty is told in the unit that a person can picture", () => {
  assert.deepEqual([0.003, 0.012, 0.35].map(format.spread), ["± 3 mm", "± 1.2 cm", "± 0.35 m"]);
  assert.deepEqual([0, 0.0004, NaN].map(format.spread), ["± 0 mm", "± < 1 mm", "± –"]);
  assert.deepEqual([0, 0.0004, 0.02, NaN].map(format.turnSpread), ["± 0.0°", "± < 0.1°", "± 1.1°", "± –"]);
});

test("the difference of two headings goes the short way round", () => {
  for (const a of [-3, -1, 0, 2, 3.1]) {
    for (const b of [-3.1, 0, 1, 3]) {
      const d = format.headingBetween(a, b);
      assert.ok(d > -Math.PI - 1e-12 && d <= Math.PI + 1e-12);
      assert.ok(Math.abs(Math.sin(a - b - d)) < 1e-9 && Math.cos(a - b - d) > 0);
    }
  }
});

test("a day is written as every country reads it", () => {
  assert.equal(format.date(new Date(2026, 10, 9, 8, 5).getTime() / 1000), "2026-11-09");
});
