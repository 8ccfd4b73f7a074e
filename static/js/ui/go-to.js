// A press on the floor, on the map or in the camera's picture, becomes words.

import { wordsTo } from "../net/marks-api.js";

/**
 * Send the robot to a point of the floor; a route in the making takes the press instead.
 * @param {HTMLElement} from where it was pressed
 * @param {import("../net/session.js").Session} session
 * @param {import("./floor-view.js").Point} point [m]
 * @param {import("../net/marks-api.js").Place | null} [place] that was pressed
 * @param {"click" | "camera"} [source] the map, or the camera's picture
 */
export function goTo(from, session, point, place = null, source = "click") {
  const pressed = new CustomEvent("place-pressed", { detail: place?.name, bubbles: true, cancelable: true });
  if (!from.dispatchEvent(pressed) || session.hello?.robot.drives !== true) return;
  const [east, north] = [point.x, point.y].map((value) => String(Number(value.toFixed(2)) + 0));
  void session.say(place ? wordsTo(place) : `go to ${east} and ${north}`, source);
}
