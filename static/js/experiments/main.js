// The experiments page.

import "./experiment-list.js";
import "./experiment-result.js";
import { make } from "../ui/element.js";
import { ExperimentRuns } from "./runs-model.js";

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new ExperimentRuns(session);
  const parts = ["experiment-list", "experiment-result", "experiment-figures"].map((name) =>
    document.createElement(name),
  );
  const element = make("div.experiments-page", ...parts);
  return { element, model, opened: () => model.follow(true), left: () => model.follow(false) };
}
