// What the camera's chip tells of a picture.

import assert from "node:assert/strict";
import { test } from "node:test";
import { figures } from "../../static/js/ui/picture-quality-chip.js";

/** @type {import("../../static/js/net/messages.js").PictureQualityState} */
const CLEAN = {
  state: "good",
  label: "good",
  words: "Good.",
  mean: 135,
  low: 40,
  high: 220,
  dark_share: 0,
  bright_share: 0.004,
  noise_sd: 1.4,
  snr_db: 39.7,
  blur_px: 0.4,
  blur_down_px: null,
  margin: 2.9,
  gain: 1,
  gamma: 1,
  contrast: 1,
  smoothing: 1,
};

/** @param {Partial<typeof CLEAN>} change */
function told(change, drift = null) {
  return Object.fromEntries(figures({ ...CLEAN, ...change }, drift));
}

test("a clean picture is looked at as it comes", () => {
  const rows = told({});
  assert.equal(rows["Before edges"], "as it comes");
  assert.equal(rows["Light"], "135 of 255, from 40 to 220");
  assert.equal(rows["Black, white"], "0 %, 0.4 %");
  assert.equal(rows["Blur"], "0.4 px across, – down");
});

test("what is done to a bad picture is told", () => {
  const rows = told({ gain: 3.3, contrast: 1.4, smoothing: 6, gamma: 0.8 });
  assert.equal(rows["Before edges"], "light × 3.3, darks lifted, contrast × 1.4, smoothed × 6.0");
});

test("the mount's turn has its sign and its uncertainty", () => {
  const drift = { apparent_rad: -0.014, apparent_sd_rad: 0.002, shift_m: 0, shift_sd_m: 0.01, pairs: 40, corners: 8 };
  const rows = told({}, /** @type {any} */ ({ ...drift, alarm: true, words: "" }));
  assert.equal(rows["Camera on laser"], "turned −0.8° ± 0.1°");
});
