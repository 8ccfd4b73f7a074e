import assert from "node:assert/strict";
import { test } from "node:test";
import { FARTHEST, rangeColour } from "../../static/js/ui/colormap.js";
import { apart, overlap, placed } from "../../static/js/ui/placement.js";

const HINT = { width: 296, height: 132 };

/** @param {{left: number, top: number}} at */
const box = ({ left, top }) => ({ left, top, right: left + HINT.width, bottom: top + HINT.height });

for (const [name, space, stop] of /** @type {const} */ ([
  ["a desk", { width: 1440, height: 900 }, { left: 1280, top: 0, right: 1440, bottom: 64 }],
  ["a phone", { width: 390, height: 844 }, { left: 261, top: 687, right: 373, bottom: 827 }],
])) {
  test(`on ${name} no hint leaves the window or covers STOP, wherever its target is`, () => {
    for (let x = 0; x <= space.width - 60; x += 30) {
      for (let y = 0; y <= space.height - 40; y += 30) {
        const at = placed({ left: x, top: y, right: x + 60, bottom: y + 40 }, HINT, space, stop);
        assert.equal(overlap(box(at), stop), 0, `${x} ${y}`);
        assert.ok(
          at.left >= 0 && at.top >= 0 && at.left + HINT.width <= space.width && at.top + HINT.height <= space.height,
        );
      }
    }
  });
}

test("a hint stands beside its target where there is room", () => {
  const target = { left: 600, top: 400, right: 700, bottom: 440 };
  const at = placed(target, HINT, { width: 1440, height: 900 }, { left: 0, top: 0, right: 0, bottom: 0 });
  assert.equal(overlap(box(at), target), 0);
});

test("boxes are apart by the wider of the gaps across and down, and touch where there is none", () => {
  const one = { left: 0, top: 0, right: 10, bottom: 10 };
  assert.equal(apart(one, { left: 14, top: 2, right: 20, bottom: 8 }), 4);
  assert.equal(apart({ left: 14, top: 30, right: 20, bottom: 40 }, one), 20);
  assert.ok(apart(one, { left: 5, top: 5, right: 20, bottom: 20 }) <= 0);
});

test("a hint stands off the line of words where there is room, and off STOP first", () => {
  const space = { width: 390, height: 844 };
  const stop = { left: 261, top: 687, right: 373, bottom: 827 };
  const words = { left: 16, top: 600, right: 374, bottom: 656 };
  const target = { left: 16, top: 664, right: 110, bottom: 700 };
  assert.ok(overlap(box(placed(target, HINT, space, stop)), words) > 0);
  const at = placed(target, HINT, space, stop, [words]);
  assert.equal(overlap(box(at), words) + overlap(box(at), stop) + overlap(box(at), target), 0);
  const everything = { left: 0, top: 0, right: 390, bottom: 844 };
  assert.equal(overlap(box(placed(target, HINT, space, stop, [everything])), stop), 0);
});

test("the hint for the stick stands right of it, over the map, and not over the rail", () => {
  const [stick, rail] = [
    { left: 115, top: 729, right: 259, bottom: 873 },
    { left: 0, top: 64, right: 88, bottom: 900 },
  ];
  const status = { left: 112, top: 604, right: 1030, bottom: 650 };
  const deck = { left: 100, top: 714, right: 1042, bottom: 888 };
  const stop = { left: 1280, top: 0, right: 1440, bottom: 64 };
  const at = placed(stick, HINT, { width: 1440, height: 900 }, stop, [status, rail, deck]);
  assert.ok(at.left > stick.right && at.top + HINT.height < status.top);
});

test("near is bright, far is dark, and the ramp ends where it ends", () => {
  /** @param {number} range */
  const light = (range) => (rangeColour(range).match(/\d+/g) ?? []).reduce((sum, part) => sum + Number(part), 0);
  for (let range = 0; range < FARTHEST - 0.5; range += 0.5) assert.ok(light(range) > light(range + 0.5), String(range));
  assert.equal(rangeColour(-1), rangeColour(0));
  assert.equal(rangeColour(99), rangeColour(FARTHEST));
});
