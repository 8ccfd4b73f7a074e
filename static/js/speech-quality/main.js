// The speech quality page.

import "./quality-form.js";
import "./quality-result.js";
import { make } from "../ui/element.js";
import { Runs } from "./runs.js";

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new Runs(session);
  const parts = ["quality-form", "quality-result", "quality-list"].map((name) => document.createElement(name));
  return {
    element: make("div.quality-page", ...parts),
    model,
    opened: () => model.follow(true),
    left: () => model.follow(false),
  };
}
