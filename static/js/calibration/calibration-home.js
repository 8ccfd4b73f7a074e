// Start page of the calibration: active calibrations, sessions begun before, and the three wizards.

import { sure } from "../ui/confirm-button.js";
import { icon, make, write } from "../ui/element.js";
import { inWords, since, standing } from "./active-calibration.js";
import * as api from "./api.js";
import { orientationInWords, read as readMicrophones } from "./microphones-api.js";
import { WizardStep } from "./wizard-step.js";

/** @typedef {import("./types.js").Kind} Kind */
/** @typedef {import("./types.js").Row} Row */

const SOURCES = { robot: "robot’s camera", upload: "picture files", webcam: "this browser’s camera" };

class CalibrationHome extends WizardStep {
  #camera = wizard(
    "camera",
    "camera",
    "Camera",
    "How the lens bends the picture and where it looks: focal length, centre, distortion. About two minutes with a printed chessboard.",
  );
  #laser = wizard(
    "laser",
    "laser",
    "Laser on the camera",
    "Where every laser point lies in the picture. The same board, held before both sensors. Calibrate the camera first.",
  );
  #microphones = wizard(
    "microphones",
    "ears",
    "Microphones",
    "How the array is turned on the robot: clap from four sides, and every direction it hears is right. No board needed.",
  );
  #rows = make("ul", { class: "session-rows" });
  #none = make("p", { class: "note" }, "Nothing has been begun yet.");
  #file = make("input", {
    type: "file",
    class: "visually-hidden",
    id: "camera-file",
    accept: ".json,.yaml,.yml,.txt,.xml,.urdf,.sh",
  });
  #drawn = "";

  /** @override */
  build() {
    this.append(
      make(
        "div",
        { class: "home" },
        make("div", { class: "wizards" }, this.#camera.card, this.#laser.card, this.#microphones.card),
        make(
          "section",
          { class: "card begun", "aria-label": "Begun" },
          make("div", { class: "card-head" }, make("h2", { class: "card-title" }, "Go on where you left off")),
          this.#none,
          this.#rows,
        ),
        make(
          "p",
          { class: "home-foot" },
          icon("upload"),
          make("label", { for: "camera-file", class: "link" }, "Bring a file"),
          this.#file,
          make(
            "span",
            { class: "note" },
            "of a camera (ROS, OpenCV, Kalibr, Beckon) or of its mount (URDF, static transform, 4x4), to be used as it is",
          ),
        ),
      ),
    );
    for (const [kind, { start, undo }] of /** @type {const} */ ([
      ["camera", this.#camera],
      ["laser", this.#laser],
    ])) {
      start.addEventListener("click", () => this.model.go({ at: "new", kind: this.#first ? "camera" : kind }));
      undo.addEventListener("click", () => sure(undo, "Press again to take it back") && void this.#undo(kind));
    }
    this.#microphones.start.addEventListener("click", () => this.model.go({ at: "microphones" }));
    this.#microphones.undo.hidden = true;
    write(this.#microphones.start, "Open");
    this.#file.addEventListener("change", () => void this.#bring());
  }

  /** @override */
  opened() {
    readMicrophones().then(
      (report) => {
        write(
          this.#microphones.used,
          report.microphones ? orientationInWords(report.active) : "This robot has no microphones.",
        );
        this.#microphones.used.toggleAttribute("data-some", report.active !== null);
        this.#microphones.start.disabled = !report.microphones;
      },
      () => undefined,
    );
  }

  /** True while the camera is not calibrated: it has to come before the laser. */
  get #first() {
    return this.model.inUse !== null && this.model.inUse.camera === null;
  }

  /** @override */
  draw() {
    const { rows, inUse, may } = this.model;
    const key = JSON.stringify([rows, inUse, may]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    for (const [kind, card] of /** @type {const} */ ([
      ["camera", this.#camera],
      ["laser", this.#laser],
    ])) {
      const report = inUse?.[kind] ?? null;
      write(card.used, report ? inWords(kind, report) : NOTHING[kind]);
      card.used.toggleAttribute("data-some", report !== null);
      card.start.hidden = card.undo.hidden = !may;
      card.undo.hidden = !may || report === null;
      write(card.why, may ? "" : "You are watching. Only an operator can calibrate.");
    }
    write(this.#laser.start, this.#first ? "Begin with the camera" : "Begin");
    this.#laser.start.classList.toggle("primary", !this.#first);
    this.#none.hidden = (rows?.length ?? 0) > 0;
    write(this.#none, rows === null ? "Looking …" : "Nothing has been begun yet.");
    this.#rows.replaceChildren(...(rows ?? []).map((row) => this.#row(row)));
  }

  /** @param {Row} row */
  #row(row) {
    const what = row.kind === "camera" ? "Camera" : "Laser on the camera";
    const how = standing(row, this.model.inUse?.[row.kind]);
    const count = `${row.views} ${row.kind === "camera" ? "view" : "pose"}${row.views === 1 ? "" : "s"}`;
    const go = make(
      "a",
      { class: "session-row", href: `#s=${row.id}${row.ready ? "&review" : ""}` },
      icon(row.kind),
      make(
        "span",
        { class: "session-words" },
        make("span", { class: "session-name" }, `${what}, ${count}`),
        make("span", { class: "note" }, `${how} · ${SOURCES[row.source]} · ${since(row.created_s)}`),
      ),
      row.ready && icon("done"),
    );
    const away = make(
      "button",
      { type: "button", class: "icon-button", "aria-label": `Delete: ${what}, ${count}` },
      icon("close"),
    );
    away.addEventListener("click", () => void this.#forget(row, away));
    return make("li", {}, go, this.model.may && away);
  }

  /**
   * Delete a session on the second press.
   * @param {Row} row
   * @param {HTMLButtonElement} button
   */
  async #forget(row, button) {
    if (!button.dataset["sure"]) {
      button.dataset["sure"] = "asked";
      button.classList.replace("icon-button", "button");
      button.replaceChildren("Delete it");
      this.session.announce("Press once more to delete this session with its pictures.");
      return;
    }
    await this.model.tried(() => api.forget(row.id));
    await this.model.readLists();
  }

  /** @param {Kind} kind */
  async #undo(kind) {
    const done = await this.model.tried(() => api.undo(kind));
    await this.model.readLists();
    if (done !== null) this.session.complain(takenBack(this.model.inUse?.[kind] ?? null));
  }

  async #bring() {
    const file = this.#file.files?.[0];
    this.#file.value = "";
    if (!file) return;
    const imported = await this.model.tried(async () => api.bring(await file.text()));
    if (imported !== null)
      this.session.announce(`The ${imported.kind === "laser" ? "mount" : "camera"} in the file is in use.`);
    await this.model.readLists();
  }
}

/** @param {Record<string, any> | null} former the calibration that is in use now */
const takenBack = (former) =>
  `Taken back: ${former ? "the former one is in use again" : "the nominal values are used now"}. To undo this, accept its session again, or bring its file.`;

/** @type {Readonly<Record<Kind, string>>} */
const NOTHING = {
  camera: "Not calibrated: the maker’s nominal values are used.",
  laser: "Not calibrated: the nominal mount is used.",
};

/**
 * @param {Kind | "microphones"} kind
 * @param {string} drawing
 * @param {string} name
 * @param {string} says
 */
function wizard(kind, drawing, name, says) {
  const used = make("p", { class: "wizard-used" }, "");
  const why = make("p", { class: "note" });
  const start = make("button", { type: "button", class: "button primary large" }, "Begin");
  start.setAttribute("aria-describedby", `about-${kind}`);
  const undo = make("button", { type: "button", class: "button plain" }, "Take the former one back");
  undo.setAttribute("aria-label", `Take the former one back: ${name}`);
  const card = make(
    "section",
    { class: "card wizard-card", "aria-label": name, "data-kind": kind },
    make("span", { class: "wizard-sign" }, icon(drawing)),
    make("h2", { id: `about-${kind}` }, name),
    make("p", { class: "wizard-says" }, says),
    used,
    make("div", { class: "wizard-buttons" }, start, undo),
    why,
  );
  return { card, used, why, start, undo };
}

customElements.define("calibration-home", CalibrationHome);
