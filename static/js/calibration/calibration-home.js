// The way in: what is in use, what was begun, what can be begun.

import { icon, make, write } from "../element.js";
import * as api from "./api.js";
import { orientationInWords, read as readMicrophones } from "./microphones-api.js";
import { Room } from "./room.js";
import { sure } from "./sure.js";
import { inWords, since, standing } from "./used.js";

/** @typedef {import("./shape.js").Kind} Kind */
/** @typedef {import("./shape.js").Row} Row */

const SOURCES = { robot: "robot’s camera", upload: "picture files", webcam: "this browser’s camera" };

class CalibrationHome extends Room {
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
        make(
          "header",
          { class: "home-head" },
          make("h2", {}, "Teach the robot to measure with its eyes and ears"),
          make(
            "p",
            {},
            "A chessboard of known size, shown from a few sides, and hands that clap are all it needs. The page says what comes next.",
          ),
        ),
        make("div", { class: "wizards" }, this.#camera.card, this.#laser.card, this.#microphones.card),
        make(
          "section",
          { class: "card begun", "aria-label": "Begun" },
          make("div", { class: "card-head" }, make("h3", { class: "card-title" }, "Go on where you left off")),
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
      start.addEventListener("click", () => this.bench.go({ at: "new", kind: this.#first ? "camera" : kind }));
      undo.addEventListener("click", () => sure(undo, "Press again to take it back") && void this.#undo(kind));
    }
    this.#microphones.start.addEventListener("click", () => this.bench.go({ at: "microphones" }));
    this.#microphones.undo.hidden = true;
    write(this.#microphones.start, "Open");
    this.#file.addEventListener("change", () => void this.#bring());
  }

  /** @override */
  opened() {
    readMicrophones().then(
      (told) => {
        write(
          this.#microphones.used,
          told.microphones ? orientationInWords(told.in_use) : "This robot has no microphones.",
        );
        this.#microphones.used.toggleAttribute("data-some", told.in_use !== null);
        this.#microphones.start.disabled = !told.microphones;
      },
      () => undefined,
    );
  }

  /** Has the camera to be calibrated before the laser can be? */
  get #first() {
    return this.bench.inUse !== null && this.bench.inUse.camera === null;
  }

  /** @override */
  draw() {
    const { rows, inUse, may } = this.bench;
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
    const how = standing(row, this.bench.inUse?.[row.kind]);
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
    return make("li", {}, go, this.bench.may && away);
  }

  /**
   * Asks once more, in place.
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
    await this.bench.tried(() => api.forget(row.id));
    await this.bench.readLists();
  }

  /** @param {Kind} kind */
  async #undo(kind) {
    const told = await this.bench.tried(() => api.undo(kind));
    await this.bench.readLists();
    if (told !== null) this.session.complain(takenBack(this.bench.inUse?.[kind] ?? null));
  }

  async #bring() {
    const file = this.#file.files?.[0];
    this.#file.value = "";
    if (!file) return;
    const told = await this.bench.tried(async () => api.bring(await file.text()));
    if (told !== null)
      this.session.announce(`The ${told.kind === "laser" ? "mount" : "camera"} in the file is in use.`);
    await this.bench.readLists();
  }
}

/** @param {Record<string, any> | null} former that is in use now */
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
    make("h3", { id: `about-${kind}` }, name),
    make("p", { class: "wizard-says" }, says),
    used,
    make("div", { class: "wizard-buttons" }, start, undo),
    why,
  );
  return { card, used, why, start, undo };
}

customElements.define("calibration-home", CalibrationHome);
