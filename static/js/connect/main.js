// Entry point of the Connect page.

import "./connect-file.js";
import "./connect-parts.js";
import "./connect-robot.js";
import "./connect-sensors.js";
import "./connect-timing.js";
import { startPage } from "../page.js";
import { ConnectionModel } from "./connection-model.js";

startPage({ model: (session) => new ConnectionModel(session) });
