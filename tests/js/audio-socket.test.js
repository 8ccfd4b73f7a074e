// Speech over its socket: what is said before it is open is sent when it opens, and ends there.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { Talk } from "../../static/js/voice/audio-socket.js";
import { FakeSocket } from "./fake-socket.js";

beforeEach(() => {
  FakeSocket.all = [];
  Object.assign(globalThis, { WebSocket: FakeSocket, document: { baseURI: "http://robot/" } });
});

/** A press before the socket is open, `pieces` of sound while it is held. @param {number} pieces */
function pressed(pieces) {
  const talk = new Talk();
  talk.open();
  talk.begin("held", 7);
  for (let at = 0; at < pieces; at += 1) talk.add({ pcm: new ArrayBuffer(4), at, peak: 0, rms: 0 });
  const socket = /** @type {FakeSocket} */ (FakeSocket.all.at(-1));
  const kinds = () => socket.sent.map((one) => (typeof one === "string" ? JSON.parse(one).kind : "sound"));
  return { talk, socket, kinds };
}

test("a button that is let go before the socket opens ends its turn as soon as it opens", () => {
  const { talk, socket, kinds } = pressed(60);
  assert.equal(talk.rest(), true);
  talk.add({ pcm: new ArrayBuffer(4), at: 60, peak: 0, rms: 0 });
  assert.deepEqual(kinds(), []);
  socket.opens();
  assert.deepEqual(kinds(), ["listen", ...Array(61).fill("sound"), "rest"]);
  assert.equal(talk.speaking, false);
});

test("pressed twice while the socket opens is one turn", () => {
  const { talk, socket, kinds } = pressed(1);
  talk.rest();
  talk.begin("held", 8);
  socket.opens();
  assert.deepEqual(kinds(), ["listen", "sound"]);
  talk.rest();
  assert.deepEqual(kinds(), ["listen", "sound", "rest"]);
});

test("a socket that never opens says so", () => {
  const { talk, socket } = pressed(1);
  /** @type {string[]} */
  const ends = [];
  talk.ended = (why) => ends.push(why);
  talk.rest();
  socket.gone();
  assert.match(ends[0] ?? "", /link for sound was lost/);
});
