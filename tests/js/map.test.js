import assert from "node:assert/strict";
import { test } from "node:test";

globalThis.matchMedia ??= /** @type {any} */ (() => ({ matches: false, addEventListener: () => undefined }));
globalThis.document ??= /** @type {any} */ ({
  documentElement: { dataset: {}, toggleAttribute: () => false },
  createElement: () => ({}),
});
const { CanvasHand } = await import("../../static/js/ui/canvas-hand.js");
const { suitable } = await import("../../static/js/ui/map-choice.js");
const { FloorView } = await import("../../static/js/ui/floor-view.js");
const { mapInWords, nearest, wayLeft } = await import("../../static/js/ui/map-text.js");
const { STATE } = await import("./view.js");

test("the map is flat where nothing else can be drawn, as was chosen, and on phones", () => {
  assert.equal(suitable(false, "3-D", false), "flat");
  assert.equal(suitable(true, "3-D", true), "3-D");
  assert.equal(suitable(true, "flat", false), "flat");
  assert.equal(suitable(true, "", true), "flat");
  assert.equal(suitable(true, "", false), "3-D");
  assert.equal(suitable(true, "nonsense", false), "3-D");
});

test("what is left of a way is counted from the robot", () => {
  const path = /** @type {Array<[number, number]>} */ ([
    [0, 0],
    [2, 0],
    [2, 1],
  ]);
  assert.equal(wayLeft({ x_m: 0, y_m: 0 }, path), 3);
  assert.equal(wayLeft({ x_m: 2, y_m: 0 }, path), 1);
  assert.equal(wayLeft({ x_m: 5, y_m: 5 }, []), 0);
});

test("the nearest obstacle is the nearest, and nobody is told of none", () => {
  assert.equal(nearest([]), null);
  assert.equal(
    nearest([
      [3, 4],
      [0, -2],
    ])?.distance,
    2,
  );
});

test("the map in words says where the robot is, what is near, where it goes and who is there", () => {
  const words = mapInWords({ ...STATE, goal: { x_m: 1, y_m: 0 }, path: [] }, [[0, -2]], {
    left: -1,
    right: 3,
    bottom: 0,
    top: 2,
  });
  assert.match(words, /^The robot is at x 0\.00 m, y 0\.00 m, heading 0°\./);
  assert.match(words, /Nearest obstacle 2\.0 m on the right\./);
  assert.match(words, /It goes to x 1\.00 m, y 0\.00 m: 1\.0 m to go\./);
  assert.match(words, /The map is 4\.0 m by 2\.0 m\.$/);
  assert.doesNotMatch(mapInWords(STATE, [], null), /obstacle|goes|Someone|map is/);
});

test("a view that is centred shows the point in the middle", () => {
  const at = new FloorView(50, 0, 0).centred({ x: 3, y: -1 }, 400, 300).drawn({ x: 3, y: -1 });
  assert.deepEqual(at, { x: 200, y: 150 });
});

test("a touch that the browser takes for itself neither presses nor draws on", () => {
  /** @type {Record<string, (event: any) => void>} */
  const listeners = {};
  const canvas = {
    addEventListener: (/** @type {string} */ type, /** @type {any} */ then) => (listeners[type] = then),
  };
  /** @type {string[]} */
  const done = [];
  let draws = true;
  new CanvasHand(/** @type {any} */ ({ ...canvas, setPointerCapture: () => undefined }), {
    move: () => done.push("moved"),
    press: () => done.push("pressed"),
    draw: () => draws,
    drawn: () => done.push("drew"),
    ended: () => done.push("ended"),
    left: () => done.push("left"),
  });
  const event = { button: 0, pointerId: 1, offsetX: 5, offsetY: 5 };
  listeners.pointerdown?.(event);
  listeners.pointercancel?.(event);
  listeners.pointerup?.(event);
  assert.deepEqual(done, ["left"]);
  draws = false;
  listeners.pointerdown?.(event);
  listeners.pointercancel?.(event);
  listeners.pointerup?.(event);
  assert.deepEqual(done, ["left"]);
});
