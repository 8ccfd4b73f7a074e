import assert from "node:assert/strict";
import { test } from "node:test";
import { CommandVoice, chainOf, LastVoice } from "../../static/js/ui/sensed.js";
import { STATE } from "./view.js";

const VOICE = /** @type {any} */ ({ azimuth_world_rad: 1, sd_heard_rad: 0.1, age_s: 2 });
const KINDS = /** @type {any} */ ([
  { name: "come_here", target: "person" },
  { name: "turn_left", target: "" },
]);
const COMING = /** @type {any} */ ({ name: "come_here", state: "running" });

test("the last voice is remembered for a minute, seen from where the robot looks now", () => {
  const last = new LastVoice();
  assert.equal(last.saw(STATE), null);
  assert.equal(last.saw({ ...STATE, stamp_s: 10, direction: VOICE })?.azimuth, 1);
  const turned = { ...STATE, stamp_s: 20, pose: { ...STATE.pose, heading_rad: 0.75 } };
  assert.deepEqual(last.saw(turned), { azimuth: 0.25, sd: 0.1, age: 12 });
  assert.equal(last.saw({ ...STATE, stamp_s: 69 }), null);
  assert.equal(last.age(69), 61);
  assert.equal(new LastVoice().age(69), null);
});

test("the chain says what each sense has of the person, and only while something is done for them", () => {
  assert.equal(chainOf(STATE, null, KINDS), null);
  assert.equal(chainOf({ ...STATE, command: { ...COMING, name: "turn_left" } }, null, KINDS), null);
  const nobody = chainOf({ ...STATE, command: COMING }, null, KINDS);
  assert.deepEqual(nobody, { heard: null, seen: null, laser: null, left: null, found: false, looks: false });
  const turning = { ...COMING, code: "come.turn_to_voice" };
  assert.equal(chainOf({ ...STATE, command: turning }, null, KINDS)?.looks, false); // nobody is looked for yet
  const looking = { ...COMING, code: "come.look_who_spoke" };
  assert.equal(chainOf({ ...STATE, command: looking }, null, KINDS)?.looks, true);
  const person = /** @type {any} */ ({
    x_m: 3,
    y_m: 4,
    laser: [3, 4],
    camera: {},
    value: 0.9,
    picture_age_s: 0.2,
    name: "Ann",
  });
  const chain = chainOf({ ...STATE, command: COMING, person }, { azimuth: 1, sd: 0.1 }, KINDS);
  assert.deepEqual([chain?.seen, chain?.laser, chain?.left], [{ value: 0.9, name: "Ann" }, 5, 4.5]);
  assert.deepEqual([chain?.found, chain?.looks], [true, false]);
  const old = chainOf({ ...STATE, command: COMING, person: { ...person, picture_age_s: 9, laser: null } }, null, KINDS);
  assert.deepEqual([old?.seen, old?.laser], [null, null]);
});

test("a voice that is heard once the person was found is not that of the command", () => {
  const voice = new CommandVoice();
  const command = /** @type {any} */ ({ id: 7, name: "come_here", state: "running" });
  const coming = { ...STATE, command };
  const found = { ...coming, person: /** @type {any} */ ({ x_m: 1, y_m: 1 }) };
  assert.equal(voice.of(coming, null), null);
  assert.deepEqual(voice.of(coming, { azimuth: 0.5, sd: 0.1 }), { azimuth: 0.5, sd: 0.1 });
  assert.deepEqual(voice.of(found, { azimuth: -1.7, sd: 0.2 }), { azimuth: 0.5, sd: 0.1 }); // an echo, or another one
  const turned = { ...found, pose: { ...STATE.pose, heading_rad: 0.25 } };
  assert.deepEqual(voice.of(turned, null), { azimuth: 0.25, sd: 0.1 });
  const next = { ...found, command: { ...command, id: 8 } };
  assert.deepEqual(voice.of(next, { azimuth: -1, sd: 0.2 }), { azimuth: -1, sd: 0.2 });
});
