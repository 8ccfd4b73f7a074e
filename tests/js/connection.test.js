import assert from "node:assert/strict";
import { test } from "node:test";
import { confirmedTopics, fileOf, isBare } from "../../static/js/connect/connection-model.js";
import { mapName, nameOf, openInstead } from "../../static/js/connect/opening.js";
import { nameTrouble } from "../../static/js/net/maps-api.js";

/** @import { FoundRobot as Connection, TopicRole } from "../../static/js/net/rest.js" */

/** @param {TopicRole["role"]} role @param {string[]} used @param {string[]} others @param {string} [type] @returns {TopicRole} */
const role = (role, used, others, type = "a/msg/B") => ({
  role,
  used: used.map((topic) => ({ topic, type, frame: "", rate_hz: null, age_s: null, guessed: false })),
  candidates: [...used, ...others].map((topic) => ({ topic, type })),
  most: 1,
  remark: "",
});

/** @param {TopicRole[]} roles @returns {Connection} */
const found = (...roles) => ({
  ...{
    url: "foxglove://a",
    name: "a",
    failsafe: "",
    odometry: true,
    limits: [],
    lasers: [],
    cameras: [],
    microphones: [],
  },
  parts: [
    {
      ...{ name: "foxglove://a", up: true, drives: true, lasers: [], cameras: [], microphones: [] },
      findings: { base_frame: "", roles, placed: [], clocks: [], faults: [], remarks: [] },
    },
  ],
});

test("a recording goes by its name, a robot by its URL", () => {
  const urls = ["log:first drive.mcap", "log:/data/walk.log", "sim:lab"];
  assert.deepEqual(urls.map(nameOf), ["first drive", "walk.log", "sim:lab"]);
});

test("what is used is confirmed, with the type of the speeds", () => {
  const speeds = role("cmd_vel", ["/tab_vel"], [], "geometry_msgs/msg/TwistStamped");
  assert.deepEqual(confirmedTopics(found(role("scan", ["/front", "/rear"], []), speeds)), [
    { part: 0, role: "scan", topics: ["/front", "/rear"] },
    { part: 0, role: "cmd_vel", topics: ["/tab_vel"] },
    { part: 0, role: "cmd_vel_type", topics: ["TwistStamped"] },
  ]);
});

test("what is not there is not named, so that it may come later", () => {
  assert.deepEqual(confirmedTopics(found(role("odometry", [], []), role("frames", ["/tf_static"], []))), []);
});

test("a battery is named only where it was a choice, and what is switched off stays off", () => {
  assert.deepEqual(confirmedTopics(found(role("battery", ["/battery"], []))), []);
  assert.equal(confirmedTopics(found(role("battery", ["/battery"], ["/spare"]))).length, 1);
  assert.deepEqual(confirmedTopics(found(role("battery", [], ["/battery"])))[0]?.topics, []);
  assert.deepEqual(confirmedTopics(found(role("sound", [], ["/sound"])))[0]?.topics, []);
});

test("a robot that is one whole has no second card; one with topics, remarks, parts or silence has", () => {
  const whole = found();
  const [part] = whole.parts;
  assert.ok(part && isBare(part, whole));
  const talks = found(role("scan", ["/scan"], []));
  assert.ok(talks.parts[0] && !isBare(talks.parts[0], talks));
  assert.ok(!isBare({ ...part, up: false }, whole));
  assert.ok(!isBare({ ...part, findings: { ...part.findings, remarks: ["It has no clock."] } }, whole));
  assert.ok(!isBare(part, { ...whole, parts: [part, { ...part, name: "scip:///dev/ttyACM0" }] }));
});

test("a file has a name that every file system takes", () => {
  assert.deepEqual(["Marvin 2", "Großes Büro", " – "].map(fileOf), ["marvin-2.toml", "groes-buro.toml", "robot.toml"]);
});

test("a map that is saved on the way out has a name that the console takes", () => {
  const name = mapName(new Date(2026, 10, 8, 9, 5, 7));
  assert.equal(name, "map 2026-11-08 09-05");
  assert.equal(nameTrouble(name), "");
});

test("what did not open leaves nothing behind, and a restart before the answer is seen", async () => {
  const heard = new EventTarget();
  let listeners = 0;
  const session = /** @type {any} */ ({
    hello: { console: "a", robot: { url: "sim:lab" } },
    state: { notices: [{ level: "error", text: "It holds no laser scans." }] },
    /** @param {string} _ @param {() => void} then @param {AddEventListenerOptions} options */
    on(_, then, options) {
      listeners += 1;
      heard.addEventListener("heard", then, options);
      options.signal?.addEventListener("abort", () => (listeners -= 1));
    },
  });
  Object.assign(globalThis, { document: { baseURI: "http://localhost/" } });
  const { fetch } = globalThis;
  globalThis.fetch = async () => {
    session.hello = { ...session.hello, console: "b" };
    heard.dispatchEvent(new Event("heard"));
    return Response.json({ url: "log:a.mcap" });
  };
  await assert.rejects(openInstead(session, "log:a.mcap"), /no laser scans/);
  globalThis.fetch = async () => Response.json({ detail: "No." }, { status: 409 });
  await assert.rejects(openInstead(session, "log:a.mcap"), /No\./);
  globalThis.fetch = fetch;
  assert.equal(listeners, 0);
});
