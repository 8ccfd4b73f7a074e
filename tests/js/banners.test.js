import assert from "node:assert/strict";
import { test } from "node:test";
import { banners } from "../../static/js/ui/banners.js";
import { HELLO, STATE, VIEW } from "./view.js";

/** @import { View } from "../../static/js/net/session.js" */

/** @param {Partial<View>} change */
const told = (change) => banners({ ...VIEW, ...change });
/** @param {object} change @param {"gate" | "robot" | "slam"} part */
const changed = (part, change) => ({ state: { ...STATE, [part]: { ...STATE[part], ...change } } });

test("when all is well nothing is in the way", () => {
  assert.deepEqual(told({}), []);
});

test("a lost link is told whatever else there is, and alone", () => {
  const [banner, ...others] = told({
    ...changed("gate", { state: "halted" }),
    link: { ...VIEW.link, is: "down", again_s: 2.4 },
  });
  assert.equal(banner?.id, "lost");
  assert.match(banner?.text ?? "", /stops by itself.*3 s/);
  assert.deepEqual(others, []);
});

test("a recording that is being opened is no lost link", () => {
  const link = { ...VIEW.link, is: /** @type {const} */ ("down") };
  const [banner, ...others] = told({ link, opening: "log:/data/recordings/walk.mcap" });
  assert.equal(banner?.tone, "calm");
  assert.equal(banner?.text, "Opening walk…");
  assert.equal(told({ link, opening: "sim:lab" })[0]?.text, "Opening the simulated robot…");
  assert.deepEqual(others, []);
  assert.deepEqual(told({ opening: "log:/data/walk.mcap" }), []);
});

test("the console's own reason for hanging up is passed on", () => {
  const link = { ...VIEW.link, is: /** @type {const} */ ("down"), why: "Too many people watch now; try again later." };
  assert.match(told({ link })[0]?.text ?? "", /Too many people watch now/);
});

test("a page that has just been opened does not cry", () => {
  assert.deepEqual(told({ state: null, hello: null, link: { ...VIEW.link, is: "opening" } }), []);
});

test("silence is told within a second", () => {
  assert.deepEqual(told({ link: { ...VIEW.link, age_s: 0.7 } }), []);
  assert.match(told({ link: { ...VIEW.link, age_s: 0.95 } })[0]?.text ?? "", /No news/);
});

test("a halt offers its reset to an operator and not to a viewer", () => {
  const halted = changed("gate", { state: "halted" });
  assert.equal(told(halted)[0]?.offers, "reset");
  const viewer = { ...HELLO, you: { ...HELLO.you, role: /** @type {const} */ ("viewer") } };
  assert.equal(told({ ...halted, hello: viewer })[0]?.offers, "");
});

test("a halt says by whom, as long as its notice stands", () => {
  const notice = { id: 1, stamp_s: 0, at_s: 0, level: /** @type {const} */ ("warning"), text: "Ann halted the robot." };
  const told_by = { ...notice, code: "stop.who_halted", values: { name: "Ann" } };
  const gate = { ...STATE.gate, state: "halted" };
  const view = (/** @type {typeof notice[]} */ notices) => ({ state: { ...STATE, gate, notices } });
  assert.match(told(view([told_by]))[0]?.text ?? "", /^Halted by Ann\. Nothing moves/);
  assert.match(told(view([]))[0]?.text ?? "", /^Halted\. Nothing moves/);
});

test("what blocks is told in the robot's own directions, wherever it stands", () => {
  for (const heading of [0, 0.7, -2.4]) {
    const pose = { ...STATE.pose, x_m: 3, y_m: -1, heading_rad: heading };
    const ahead = { x_m: 3 + 0.2 * Math.cos(heading), y_m: -1 + 0.2 * Math.sin(heading) };
    const gate = { ...STATE.gate, limit_v_m_s: 0, blocked_by: ahead };
    assert.deepEqual(
      told({ state: { ...STATE, pose, gate } }).map(({ text }) => text),
      ["Blocked at 0.2 m ahead."],
    );
  }
});

test("being slowed is said calmly, with the speed that is left", () => {
  const slowed = changed("gate", { limit_v_m_s: 0.06, blocked_by: { x_m: 0, y_m: 0.4 } });
  const [banner] = told(slowed);
  assert.equal(banner?.tone, "calm");
  assert.equal(banner?.text, "Slowed to 0.06 m/s: something at 0.4 m on the left.");
});

test("a silent robot, a touch and the first look around are told", () => {
  assert.match(told(changed("robot", { link: "stale", age_s: 1.2 }))[0]?.text ?? "", /silent for 1.2 s/);
  assert.equal(told(changed("robot", { contact: true }))[0]?.id, "contact");
  assert.equal(told(changed("slam", { looking_around: true }))[0]?.tone, "calm");
});

test("a recording is not blocked and does not look around", () => {
  const hello = { ...HELLO, robot: { ...HELLO.robot, drives: false } };
  assert.deepEqual(told({ hello, ...changed("slam", { looking_around: true }) }), []);
});

/** @type {import("../../static/js/net/messages.js").LocalizationState} */
const LOST = { phase: "asking", words: "I am lost. Show me where I am.", since_s: 1, candidates: [] };

/** @param {object} change @param {Partial<View>} [more] */
const afloat = (change, more = {}) => told({ state: { ...STATE, floor: { ...STATE.floor, ...change } }, ...more });

test("a robot that is lost says so in its own words, and who may can show it where it is", () => {
  const [banner] = afloat({ lost: LOST });
  assert.equal(banner?.text, LOST.words);
  assert.equal(banner?.tone, "stale");
  assert.equal(banner?.offers, "here");
  assert.equal(afloat({ lost: { ...LOST, phase: "searching" } })[0]?.tone, "calm");
});

test("who watches, and a recording, cannot be asked where the robot is", () => {
  const watching = { hello: { ...HELLO, you: { ...HELLO.you, role: /** @type {const} */ ("viewer") } } };
  const recording = { hello: { ...HELLO, robot: { ...HELLO.robot, drives: false } } };
  for (const more of [watching, recording]) assert.equal(afloat({ lost: LOST }, more)[0]?.offers, "");
});

test("a lost robot does not say that it looks around as well", () => {
  const state = { ...STATE, slam: { ...STATE.slam, looking_around: true }, floor: { ...STATE.floor, lost: LOST } };
  assert.deepEqual(
    told({ state }).map(({ id }) => id),
    ["localization"],
  );
});

test("slipping wheels are told", () => {
  assert.match(afloat({ slipping: true })[0]?.text ?? "", /slip/);
});

test("plain HTTP over a network is told for as long as it is", () => {
  assert.match(told({ secure: false })[0]?.text ?? "", /Plain HTTP.*--tls-cert/);
  assert.match(told({ secure: false, ...changed("gate", { state: "halted" }) }).at(-1)?.text ?? "", /Plain HTTP/);
});

test("who asks for control is seen by the one who drives, and by nobody else", () => {
  const lease = { ...STATE.lease, asked_by: "Bert", asked_by_id: "bert-1", answer_within_s: 7.4 };
  const [asked] = told({ mine: true, state: { ...STATE, lease } });
  assert.match(asked?.text ?? "", /Bert asks for control \(8 s\)/);
  assert.equal(asked?.offers, "answer");
  assert.deepEqual(told({ mine: false, state: { ...STATE, lease } }), []);
});

test("who loses control reads it over the map, and may ask for it where someone has it", () => {
  const [taken] = told({ mine: false, lostControl: { to: "Bert" } });
  assert.match(taken?.text ?? "", /Bert took control from you/);
  assert.equal(taken?.offers, "regain");
  const nobody = { ...STATE, lease: { ...STATE.lease, holder: null, holder_id: null } };
  assert.match(told({ mine: false, state: nobody, lostControl: { to: null } })[0]?.text ?? "", /lost control/);
});

test("a console that began again says so, offers the last map, and blames nobody", () => {
  const [banner, ...others] = told({ restarted: true });
  assert.match(banner?.text ?? "", /restarted; the robot is at its start/);
  assert.equal(banner?.offers, "load");
  assert.deepEqual(others, []);
  const viewer = { ...HELLO, you: { ...HELLO.you, role: /** @type {const} */ ("viewer") } };
  assert.equal(told({ restarted: true, hello: viewer })[0]?.offers, "begun");
});
