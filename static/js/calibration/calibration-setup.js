// Setup step: source of the pictures and size of the board.

import { sentenceOf } from "../net/api.js";
import { icon, make, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { inWords } from "./active-calibration.js";
import * as api from "./api.js";
import { BoardDrawing } from "./board-drawing.js";
import { box, option, source, stepper } from "./fields.js";
import { webcamRefusal } from "./webcam.js";
import { WizardStep } from "./wizard-step.js";

/** @typedef {import("./types.js").Source} Source */
/** @typedef {import("./types.js").Board} Board */

/** Landscape pages [mm]; margins as in the printable board of the console. */
const PAGES = /** @type {Readonly<Record<string, readonly [number, number]>>} */ ({
  A4: [297, 210],
  A3: [420, 297],
  letter: [279.4, 215.9],
});
const RIMS = 16; // [mm] both together
const RULERS = 12; // [mm]

const PLANS = {
  camera: "Fetch a chessboard, or print one and glue it on something stiff. Then press Start and follow the picture.",
  laser:
    "The laser looks at the empty room first, for three seconds. Then hold the board still before both sensors, " +
    "ten times for two seconds, tilted another way each time.",
};

class CalibrationSetup extends WizardStep {
  #title = make("h2", { class: "setup-title", tabindex: "-1" });
  #sources = {
    robot: source("robot", "antenna", "The robot’s camera", "What the robot sees now."),
    webcam: source("webcam", "webcam", "This device’s camera", "For a camera on this computer or phone."),
    upload: source("upload", "upload", "Picture files", "Pictures taken before, JPEG or PNG."),
  };
  #plan = make("p", { class: "setup-plan" });
  #against = make("p", { class: "note" });
  #where = make("fieldset", { class: "card sources" });
  #drawing = new BoardDrawing();
  #columns = stepper("columns", "Inner corners across", 9);
  #rows = stepper("rows", "Inner corners down", 6);
  #square = box("square", "Side of a square", "mm", "25");
  #panelWidth = box("panel-width", "Panel width", "mm", "");
  #panelHeight = box("panel-height", "Panel height", "mm", "");
  #height = box("height", "Camera above the laser", "mm", "");
  #print = make("a", { class: "link", target: "_blank", rel: "noopener" }, icon("print"), "Print this board");
  #fits = make("p", { class: "note print-fits" });
  #page = make("select", { class: "words small", "aria-label": "Paper" }, ...["A4", "A3", "letter"].map(option));
  #begin = make("button", { type: "submit", class: "button primary large" }, "Start");
  #says = make("p", { class: "setup-says", role: "alert" });
  #laserOnly = make(
    "details",
    { class: "more" },
    make("summary", {}, "The board cannot be tilted (a robot between upright boards)"),
    make(
      "p",
      { class: "note" },
      "Upright boards leave height, roll and pitch open. Measure with a ruler how far the camera’s lens is above the laser’s plane; below is negative. Leave it empty otherwise.",
    ),
    make("div", { class: "boxes" }, this.#height.row),
  );

  /** @override */
  build() {
    const legend = make("legend", { class: "card-title" }, "Where do the pictures come from?");
    this.#where.append(legend, ...Object.values(this.#sources).map(({ row }) => row));
    const board = make(
      "fieldset",
      { class: "card board-card" },
      make("legend", { class: "card-title" }, "Which board?"),
      make(
        "div",
        { class: "board-figure" },
        this.#drawing,
        make("p", { class: "note" }, "Count the dots: the points where four squares meet. Not the squares."),
      ),
      make(
        "div",
        { class: "board-boxes" },
        this.#columns.row,
        this.#rows.row,
        this.#square.row,
        make("p", { class: "note" }, "Measure five squares with a ruler and divide by five."),
        make("p", { class: "print-line" }, this.#print, this.#page),
        this.#fits,
        make(
          "details",
          { class: "more" },
          make("summary", {}, "The print is glued on a larger panel"),
          make("p", { class: "note" }, "The laser sees the whole panel. Measure it from rim to rim."),
          make("div", { class: "boxes" }, this.#panelWidth.row, this.#panelHeight.row),
        ),
        this.#laserOnly,
      ),
    );
    const form = make(
      "form",
      { class: "setup", novalidate: true },
      make("div", { class: "setup-head" }, this.#title, this.#plan, this.#against),
      this.#where,
      board,
      make("div", { class: "setup-foot" }, this.#says, this.#begin),
    );
    this.append(form);
    this.#remembered();
    form.addEventListener("input", () => this.#show());
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#start();
    });
  }

  get #kind() {
    return this.model.place.at === "new" ? this.model.place.kind : "camera";
  }

  /** @override */
  opened() {
    write(this.#says, "");
    write(this.#title, this.#kind === "camera" ? "Calibrate the camera" : "Calibrate the laser on the camera");
    write(this.#plan, PLANS[this.#kind]);
    this.#where.hidden = this.#kind === "laser";
    this.#laserOnly.hidden = this.#kind === "camera";
    this.#offer("webcam", webcamRefusal());
    this.#show();
    this.#title.focus({ preventScroll: true });
  }

  /** @override */
  draw() {
    const { may, inUse } = this.model;
    const camera = this.#kind === "laser" ? (inUse?.camera ?? null) : null;
    write(this.#against, camera ? `The camera it is measured against. ${inWords("camera", camera)}` : "");
    this.#begin.hidden = !may;
    if (!may && !this.#says.textContent) write(this.#says, "You are watching. Only an operator can calibrate.");
  }

  /**
   * @param {"robot" | "webcam"} which
   * @param {string} why not; "" when it may be chosen
   */
  #offer(which, why) {
    const { input, note, says, row } = this.#sources[which];
    input.disabled = why !== "";
    row.toggleAttribute("data-off", why !== "");
    write(note, why || says);
    if (why && input.checked) this.#sources.upload.input.checked = true;
  }

  #show() {
    const board = this.#board();
    this.#drawing.show({ columns: this.#columns.value, rows: this.#rows.value });
    this.#print.href = api.printable(board, this.#page.value);
    const [across = 0, down = 0] = PAGES[this.#page.value] ?? [];
    const largest = Math.min((across - RIMS) / (board.columns + 1), (down - RIMS - RULERS) / (board.rows + 1));
    const fits = !(board.square_m * 1000 > largest);
    this.#fits.hidden = fits;
    this.#print.hidden = !fits;
    const advice = `at most ${Math.floor(largest)} mm do. Enter that to print it, or take larger paper.`;
    write(this.#fits, fits ? "" : `Squares of ${this.#square.entered} mm do not fit; ${advice}`);
  }

  /** @returns {Board} */
  #board() {
    const [width, height] = [this.#panelWidth.metres, this.#panelHeight.metres];
    return {
      columns: this.#columns.value,
      rows: this.#rows.value,
      square_m: this.#square.metres ?? NaN,
      panel_m: width !== null && height !== null ? [width, height] : null,
    };
  }

  /** @returns {string} what is wrong with the entries, "" when nothing is */
  #wrong() {
    const { columns, rows, square_m: square } = this.#board();
    if (![columns, rows].every((count) => count >= 3 && count <= 40))
      return "A board needs 3 to 40 inner corners each way.";
    if (!(square >= 0.001 && square <= 1)) return "Enter the side of one square in millimetres, 1 to 1000.";
    if ((this.#panelWidth.metres === null) !== (this.#panelHeight.metres === null))
      return "Enter both sides of the panel, or none.";
    return "";
  }

  async #start() {
    const wrong = this.#wrong();
    write(this.#says, wrong);
    if (wrong) return;
    const board = this.#board();
    const kind = this.#kind;
    const chosen = Object.values(this.#sources).find(({ input }) => input.checked)?.input.value;
    const from = /** @type {Source} */ (kind === "laser" ? "robot" : (chosen ?? "robot"));
    remember("board", JSON.stringify(board));
    if (kind === "camera") remember("source", from);
    write(this.#begin, "Starting …");
    try {
      const height = kind === "laser" ? this.#height.metres : null;
      const begun = await api.begin({ kind, board, source: from, height_m: height });
      if (from === "robot") await api.live(begun.id, true);
      this.model.go({ at: "capture", id: begun.id });
    } catch (refusal) {
      write(this.#says, sentenceOf(refusal));
    } finally {
      write(this.#begin, "Start");
    }
  }

  #remembered() {
    const from = remembered("source", "robot");
    const chosen = from === "webcam" || from === "upload" ? from : "robot";
    this.#sources[chosen].input.checked = true;
    try {
      /** @type {Partial<Board>} */
      const board = JSON.parse(remembered("board", "{}"));
      this.#columns.value = board.columns ?? 9;
      this.#rows.value = board.rows ?? 6;
      this.#square.metres = board.square_m ?? 0.025;
      this.#panelWidth.metres = board.panel_m?.[0] ?? null;
      this.#panelHeight.metres = board.panel_m?.[1] ?? null;
    } catch {
      // the stored board cannot be read: keep the defaults
    }
  }
}

customElements.define("calibration-setup", CalibrationSetup);
