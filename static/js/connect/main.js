// The Connect page.

import "./connect-file.js";
import "./connect-parts.js";
import "./connect-robot.js";
import "./connect-sensors.js";
import "./connect-timing.js";
import { make } from "../ui/element.js";
import { ConnectionModel } from "./connection-model.js";

/** @param {...string} names of elements */
const column = (...names) =>
  make("div.page-cards.connect-column", ...names.map((name) => document.createElement(name)));

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new ConnectionModel(session);
  const element = make(
    "div.connect-page",
    column("connect-robot", "connect-parts", "connect-sensors"),
    column("connect-file", "connect-timing"),
  );
  return { element, model, opened: () => model.follow(true), left: () => model.follow(false) };
}
