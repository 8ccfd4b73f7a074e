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

test("a tour that ends while its person is chosen leaves the robot's choice as it was", {
  timeout: 60_000,
}, async (of) => {
  const element = () => ({ nodeType: 1, append() {}, setAttribute() {}, addEventListener() {} });
  /** @type {Record<string, (event?: any) => any>} */
  const listeners = {};
  /** @type {any} */
  let TourGuide = null;
  Object.assign(globalThis, {
    HTMLElement: class {
      append() {}
    },
    customElements: { define: (/** @type {string} */ _, /** @type {any} */ made) => (TourGuide = made) },
    document: { createElement: element, createTextNode: element, querySelector: () => null, baseURI: "http://robot/" },
    addEventListener: (/** @type {string} */ what, /** @type {any} */ then) => (listeners[what] = then),
    dispatchEvent: () => true,
  });
  await import("../../static/js/panels/tour-guide.js");
  /** @type {(string | null)[]} */
  const chosen = [];
  of.mock.method(globalThis, "fetch", async (/** @type {URL} */ url, /** @type {any} */ { body }) => {
    if (String(url).endsWith("chosen")) {
      chosen.push(JSON.parse(body).id);
      listeners.stopped?.();
    }
    return Response.json({ people: [{ id: "ann-1", name: "Ann" }], chosen: "bob-1", enrollment: null });
  });
  const guide = new TourGuide();
  const restored = new Promise((resolve) => {
    guide.join({
      on: (/** @type {string} */ what, /** @type {any} */ then) => (listeners[what] = then),
      attempt: async (/** @type {() => Promise<unknown>} */ act) => {
        await act();
        if (chosen.length === 2) resolve(null);
        return true;
      },
      announce() {},
      state: null,
      history: [],
    });
  });
  listeners["show-tour"]?.();
  await restored;
  assert.deepEqual(chosen, ["ann-1", "bob-1"]);
});
