import assert from "node:assert/strict";
import { test } from "node:test";

/** @typedef {Record<string, Array<{name: string, of: string, wall_m?: number | null}>>} Marks */

test("robots of one map get the marks that they lack, keep their own, and nothing is written where one may not", async () => {
  /** @type {Record<string, Marks>} */
  const kept = {
    r1: {
      places: [
        { name: "dock", of: "r1" },
        { name: "desk", of: "r1", wall_m: null },
      ],
      zones: [{ name: "stairs", of: "r1" }],
      routes: [],
    },
    r2: { places: [{ name: "Dock", of: "r2" }], zones: [], routes: [{ name: "round", of: "r2" }] },
    r3: { places: [{ name: "lift", of: "r3" }], zones: [], routes: [] },
  };
  /** @type {string[]} */
  const order = [];
  Object.assign(globalThis, {
    document: { baseURI: "http://fleet/" },
    fetch: async (/** @type {URL} */ url, /** @type {RequestInit} */ { method, body }) => {
      const [, , robot = "", , kind = ""] = url.pathname.split("/");
      const own = kept[robot]?.[kind] ?? [];
      if (method !== "POST") return Response.json({ [kind]: own });
      const mark = JSON.parse(String(body));
      if ("wall_m" in mark) return Response.json({ detail: "It has not the form." }, { status: 422 });
      if (mark.name === "lift") return Response.json({ detail: "It sounds like left." }, { status: 422 });
      order.push(kind);
      own.push(mark);
      return Response.json(mark, { status: 201 });
    },
  });
  const { shareMarks } = await import("../../static/js/net/marks-api.js");
  const done = await shareMarks(["robots/r1/", "robots/r2/", "robots/r3/"], (root) => root !== "robots/r3/");
  assert.deepEqual(done, { added: 3, refused: ["lift: It sounds like left.", "lift: It sounds like left."] });
  assert.deepEqual(order, ["places", "zones", "routes"]);
  assert.deepEqual(kept, {
    r1: {
      places: [
        { name: "dock", of: "r1" },
        { name: "desk", of: "r1", wall_m: null },
      ],
      zones: [{ name: "stairs", of: "r1" }],
      routes: [{ name: "round", of: "r2" }],
    },
    r2: {
      places: [
        { name: "Dock", of: "r2" },
        { name: "desk", of: "r1" },
      ],
      zones: [{ name: "stairs", of: "r1" }],
      routes: [{ name: "round", of: "r2" }],
    },
    r3: { places: [{ name: "lift", of: "r3" }], zones: [], routes: [] },
  });
});

test("a stop that no place is called any more, or that lies in a zone to keep out of, is named before the route begins", async () => {
  const { troubleAt } = await import("../../static/js/net/marks-api.js");
  /** @param {string} name @param {number} x_m @param {number} y_m */
  const place = (name, x_m, y_m) => ({ name, x_m, y_m, heading_rad: null });
  /** @param {string} name @param {"keep_out" | "slow"} kind @param {[number, number][]} points_m */
  const zone = (name, kind, points_m) => ({ name, kind, points_m, max_speed_m_s: kind === "slow" ? 0.05 : null });
  const marks = /** @type {any} */ ({
    places: [place("Desk", 1.2, 0.3), place("sofa", 2.5, 2.5), place("lift", 1.9, 1.9)],
    zones: [
      zone("stairs", "keep_out", [
        [0, 0],
        [2, 0],
        [0, 2],
      ]),
      zone("rug", "slow", [
        [2, 2],
        [3, 2],
        [3, 3],
        [2, 3],
      ]),
    ],
  });
  assert.equal(troubleAt("desk", marks), "“desk” lies in “stairs”, which the robot keeps out of.");
  assert.equal(troubleAt("sofa", marks), ""); // slow is not closed
  assert.equal(troubleAt("lift", marks), ""); // beyond the third side
  assert.equal(troubleAt("door", marks), "No place is called “door” any more.");
});
