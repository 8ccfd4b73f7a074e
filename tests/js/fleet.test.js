// What the fleet's page says of a robot.

import assert from "node:assert/strict";
import { test } from "node:test";
import { standsStill } from "../../static/js/fleet/words.js";

/** @import { FleetRow } from "../../static/js/net/rest.js" */

test("a robot stands still where a fresh report says that nobody drives and nothing moves", () => {
  const rests = /** @type {FleetRow} */ ({ link: "live", operator: null, command: null, speed_m_s: 0 });
  assert.ok(standsStill(rests));
  assert.ok(!standsStill({ ...rests, operator: "Ann" }));
  assert.ok(!standsStill({ ...rests, speed_m_s: 0.1 }));
  assert.ok(!standsStill({ ...rests, link: "stale" }), "it may move by now");
});
