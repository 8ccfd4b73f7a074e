// The keys that stop the robot, on pages from which it is not driven.

import { intentionOf, takesText } from "./keys.js";
import { remembered } from "./memory.js";

const singleKeys = () => remembered("single-keys", "on") === "on";

/** @param {import("./session.js").Session} session */
export function stopByKeys(session) {
  addEventListener(
    "keydown",
    (event) => {
      const typing = takesText(event.composedPath()[0]);
      if (intentionOf(event, { typing, singleKeys: singleKeys() })?.does !== "stop") return;
      if (event.key !== "Escape") event.preventDefault();
      if (!event.repeat) session.stop();
    },
    true,
  );
  addEventListener("keyup", (event) => {
    // Space stops; it must not press the button in focus besides
    if (event.code === "Space" && singleKeys() && !takesText(event.composedPath()[0])) event.preventDefault();
  });
}
