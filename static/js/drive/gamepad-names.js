// Names of gamepads and of their buttons, as they are printed on them.

import { t } from "../ui/texts.js";

/** @import { Pad, PadInput } from "./gamepad-mapping.js" */

const PAD = [
  t("gamepad-names.d_pad_up"),
  t("gamepad-names.d_pad_down"),
  t("gamepad-names.d_pad_left"),
  t("gamepad-names.d_pad_right"),
];
const XBOX = [
  "A",
  "B",
  "X",
  "Y",
  "LB",
  "RB",
  "LT",
  "RT",
  t("gamepad-names.view"),
  t("gamepad-names.menu"),
  "LS",
  "RS",
  ...PAD,
  "Xbox",
];
const PLAYSTATION = [
  ...[
    "cross",
    "circle",
    "square",
    "triangle",
    "L1",
    "R1",
    "L2",
    "R2",
    t("gamepad-names.create"),
    t("gamepad-names.options"),
    "L3",
    "R3",
  ],
  ...[...PAD, "PS", t("gamepad-names.touch_pad")],
];
const NINTENDO = [
  ...[
    "B",
    "A",
    "Y",
    "X",
    "L",
    "R",
    "ZL",
    "ZR",
    "−",
    "+",
    t("gamepad-names.left_stick_button"),
    t("gamepad-names.right_stick_button"),
  ],
  ...[...PAD, t("gamepad-names.home")],
];
const AXES = [
  t("gamepad-names.left_stick"),
  t("gamepad-names.left_stick_2"),
  t("gamepad-names.right_stick"),
  t("gamepad-names.right_stick_2"),
];

/** @param {string} id as the browser reports it */
function buttonNames(id) {
  if (/054c|playstation|dualsense|dualshock|wireless controller/i.test(id)) return PLAYSTATION;
  if (/057e|nintendo|joy-con|pro controller/i.test(id)) return NINTENDO;
  return XBOX;
}

/**
 * Name of a button or an axis; on a layout that is not known its number, from 0 as in every driver.
 * @param {Pick<Pad, "id" | "mapping">} pad
 * @param {PadInput} input
 */
export function inputName({ id, mapping }, input) {
  const known = mapping === "standard";
  if ("button" in input)
    return (known && buttonNames(id)[input.button]) || t("gamepad-names.button_button", { button: input.button });
  return (
    (known && AXES[input.axis]) ||
    t("gamepad-names.axis_axisvalue", { axis: input.axis, value: input.sign < 0 ? " −" : " +" })
  );
}

/**
 * Name of a gamepad without the numbers of its maker: "Xbox 360 Controller (STANDARD GAMEPAD Vendor: …)" or
 * "045e-028e-Xbox 360 Controller" → "Xbox 360 Controller".
 * @param {string} id
 */
export function padName(id) {
  const name = id
    .replace(/\s*\((?:STANDARD GAMEPAD|Vendor:).*$/i, "")
    .replace(/^[0-9a-f]{1,4}-[0-9a-f]{1,4}-/i, "")
    .trim();
  return name.slice(0, 60) || t("gamepad-names.gamepad");
}
