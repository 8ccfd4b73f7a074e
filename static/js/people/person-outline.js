// Drawing of a person in a picture: contour, head, torso and feet.

import { make, svg } from "../ui/element.js";
import { pictureOf } from "./enrollment-model.js";

/** @import { JudgedPictureState as Judged } from "../net/rest.js" */

/**
 * The picture with everything drawn on it.
 * @param {string} id of the enrollment
 * @param {Judged} judged
 * @param {string} says
 */
export function sketched(id, judged, says) {
  const [width, height] = judged.size;
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "sketch", "aria-hidden": "true" });
  if (judged.outline.length)
    drawing.append(
      svg("polygon", { points: judged.outline.map(([u, v]) => `${u},${v}`).join(" "), class: "sketch-outline" }),
    );
  for (const { name, box_px: box } of judged.parts) {
    const [left, top, right, bottom] = box;
    drawing.append(svg("rect", { x: left, y: top, width: right - left, height: bottom - top, class: "sketch-part" }));
    const label = svg("text", {
      x: right + 0.012 * height,
      y: (top + bottom) / 2,
      class: "sketch-name",
      "font-size": 0.04 * height,
    });
    label.textContent = name;
    drawing.append(label);
  }
  const picture = make("img", {
    src: pictureOf(id, judged.number),
    alt: says,
    width: String(width),
    height: String(height),
  });
  return make("div.sketched", { "data-good": judged.good }, picture, drawing);
}
