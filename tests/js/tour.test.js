// The tour: its steps, and how it ends.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Tour } from "../../static/js/ui/tour.js";

test("an ended tour waits for nothing and does no further step", async () => {
  /** @type {string[]} */
  const done = [];
  const steps = ["one", "two", "three"].map((title) => ({
    title,
    text: "",
    at: "",
    act: async (/** @type {Tour} */ tour) => {
      done.push(title);
      if (title === "two") tour.end();
      await tour.until(() => title === "one");
    },
  }));
  const shown = /** @type {string[]} */ ([]);
  assert.equal(await new Tour(steps, ({ title }) => shown.push(title)).run(), false);
  assert.deepEqual(
    [done, shown],
    [
      ["one", "two"],
      ["one", "two"],
    ],
  );
});

test("a step that fails ends the tour", async () => {
  const tour = new Tour(
    [{ title: "", text: "", at: "", act: () => Promise.reject(new Error("no link")) }],
    () => undefined,
  );
  assert.equal(await tour.run(), false);
});
