// Stop keys for the pages without driving controls.

import { remembered } from "../ui/local-storage.js";
import { intentionOf, takesText } from "./keys.js";

const singleKeys = () => remembered("single-keys", "on") === "on";

/** @param {import("../net/session.js").Session} session */
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
    // Space stops; it must not also press the focused button
    if (event.code === "Space" && singleKeys() && !takesText(event.composedPath()[0])) event.preventDefault();
  });
}
