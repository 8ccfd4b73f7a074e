import assert from "node:assert/strict";
import { test } from "node:test";
import { heightOf, insetsOf } from "../../static/js/ui/clear-area.js";
import { FloorView, headingOf, seenFrom } from "../../static/js/ui/floor-view.js";

const ROOM = { left: -2, bottom: -1, right: 6, top: 3 };

/** @param {number} a @param {number} b */
const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

test("what is drawn of a point leads back to it, however the view is moved", () => {
  let view = FloorView.fitted(ROOM, 390, 500, 30);
  for (const [about, times, shift] of [
    [{ x: 10, y: 20 }, 1.5, { x: 4, y: -7 }],
    [{ x: 300, y: 90 }, 0.4, { x: 0, y: 0 }],
  ]) {
    view = view.changed(/** @type {any} */ (about), /** @type {number} */ (times), /** @type {any} */ (shift));
    const back = view.floor(view.drawn({ x: 1.25, y: -0.5 }));
    near(back.x, 1.25);
    near(back.y, -0.5);
  }
});

test("all of a map is in the drawing, its middle in the middle, and y is up", () => {
  for (const [width, height] of /** @type {Array<[number, number]>} */ ([
    [1000, 300],
    [390, 700],
  ])) {
    const view = FloorView.fitted(ROOM, width, height, 20);
    const [low, high] = [view.drawn({ x: -2, y: -1 }), view.drawn({ x: 6, y: 3 })];
    assert.ok(low.x >= 19.9 && high.x <= width - 19.9 && high.y >= 19.9 && low.y <= height - 19.9);
    assert.ok(high.y < low.y);
    near((low.x + high.x) / 2, width / 2);
    near((low.y + high.y) / 2, height / 2);
  }
});

test("what opens beside a map moves it only where it would be covered, and it grows only by much", () => {
  const box = { left: 0, right: 800, top: 0, bottom: 500 };
  const [view, lower] = [FloorView.fitted(ROOM, 800, 500, 40), FloorView.fitted(ROOM, 800, 440, 40)];
  assert.equal(view.steady(lower, ROOM, { ...box, bottom: 440 }), view, "a pill below that covers no wall");
  const covered = { ...box, bottom: 300 };
  const fitted = FloorView.fitted(ROOM, 800, 300, 40);
  assert.equal(view.steady(fitted, ROOM, covered), fitted);
  assert.equal(fitted.steady(view, ROOM, box), view, "there is room for one half larger");
  const nearly = FloorView.fitted(ROOM, 800, 500, 100);
  assert.equal(nearly.steady(view, ROOM, box), nearly);
  assert.equal(view.steady(nearly, { ...ROOM, right: 9 }, box), nearly, "the map has grown out of it");
});

test("zooming leaves the point under the finger where it is, within bounds", () => {
  const view = FloorView.fitted(ROOM, 800, 600, 20);
  const under = view.floor({ x: 123, y: 456 });
  for (const times of [1.7, 0.2, 1000, 1e-6]) {
    const drawn = view.changed({ x: 123, y: 456 }, times).drawn(under);
    near(drawn.x, 123);
    near(drawn.y, 456);
  }
  assert.ok(view.changed({ x: 0, y: 0 }, 1e9).scale <= 400);
});

test("a drag says which way it looks: up the drawing is +y; a tap says nothing", () => {
  near(headingOf({ x: 50, y: 50 }, { x: 90, y: 50 }, 14) ?? NaN, 0);
  near(headingOf({ x: 50, y: 50 }, { x: 50, y: 10 }, 14) ?? NaN, Math.PI / 2);
  assert.equal(headingOf({ x: 50, y: 50 }, { x: 58, y: 50 }, 14), null);
});

test("what the robot sees turns and moves with it", () => {
  const [ahead, left] = seenFrom(
    [
      [1, 0],
      [0, 1],
    ],
    { x: 2, y: 3, heading: Math.PI / 2 },
  );
  near(ahead?.x ?? NaN, 2);
  near(ahead?.y ?? NaN, 4);
  near(left?.x ?? NaN, 1);
  near(left?.y ?? NaN, 3);
});

test("panels cover the view at its edges, and a view that lies elsewhere not at all", () => {
  const all = { left: 0, top: 0, right: 1440, bottom: 900 };
  const free = { left: 100, top: 76, right: 1042, bottom: 690 };
  assert.deepEqual(insetsOf(all, free), { left: 100, top: 76, right: 398, bottom: 210 });
  assert.deepEqual(insetsOf({ ...free, left: 1100, right: 1400 }, free), { left: 0, top: 0, right: 0, bottom: 0 });
});

test("the map gives way to what a running command shows above the status, and not to what passes", () => {
  const chain = { offsetTop: 10, offsetHeight: 26, dataset: {} };
  const status = { offsetTop: 42, offsetHeight: 40, dataset: { state: "running" } };
  const pending = { offsetTop: 0, offsetHeight: 0, dataset: {} };
  assert.equal(heightOf([chain, status, pending]), 72);
  assert.equal(heightOf([{ ...chain, offsetHeight: 0 }, status, pending]), 40);
  assert.equal(heightOf([chain, { ...status, dataset: { state: "refused" } }, pending]), null);
  assert.equal(heightOf([]), 0);
});
