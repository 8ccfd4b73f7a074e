// Entry point of the speech quality page.

import "./quality-form.js";
import "./quality-list.js";
import "./quality-result.js";
import { startPage } from "../page.js";
import { Runs } from "./runs.js";

startPage({ model: (session) => new Runs(session) });
