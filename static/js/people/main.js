// Entry point of the people page: enrollment, known people, and the choice of person.

import "./people-known.js";
import "./people-enrollment.js";
import { startPage } from "../page.js";
import { EnrollmentModel } from "./enrollment-model.js";

startPage({ model: (session) => new EnrollmentModel(session) });
