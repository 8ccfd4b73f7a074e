import assert from "node:assert/strict";
import { test } from "node:test";
import { offeredType, speedsOffer } from "../../static/js/ui/speeds-offer.js";

const said = { code: "speeds.type_guessed", values: { sent: "Twist", other: "TwistStamped", sensor: "/cmd_vel" } };

test("only a notice on a guessed type offers the other one, in every language", () => {
  assert.equal(offeredType(said), "TwistStamped");
  assert.equal(offeredType({ code: "scan.late", values: { other: "Twist" } }), "");
  assert.equal(offeredType({ code: null }), "");
});

test("who only watches gets no button", () => {
  const session = /** @type {import("../../static/js/net/session.js").Session} */ (
    /** @type {unknown} */ ({ hello: { you: { role: "viewer" } } })
  );
  assert.equal(speedsOffer(session, said), null);
});
