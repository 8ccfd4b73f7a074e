// The people page: enrollment, known people, and the choice of person.

import "./people-known.js";
import "./people-enrollment.js";
import { make } from "../ui/element.js";
import { EnrollmentModel } from "./enrollment-model.js";

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new EnrollmentModel(session);
  const parts = ["people-known", "people-enrollment"].map((name) => document.createElement(name));
  return { element: make("div.page-cards.people-page", ...parts), model, opened: () => void model.read() };
}
