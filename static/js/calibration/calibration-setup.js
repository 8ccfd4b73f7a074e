// Setup step: source of the pictures and size of the board.
// Element <board-drawing>: chessboard whose inner corners are numbered as the operator has to count them.
// Form fields: picture source, stepper for counts, length in millimetres.

import { sentenceOf } from "../net/api.js";
import { icon, isNew, make, onSubmit, svg, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";
import { inWords } from "./active-calibration.js";
import * as api from "./api.js";
import { webcamRefusal } from "./webcam.js";
import { WizardStep } from "./wizard-step.js";

/** @import { Board, Source } from "./types.js" */

/**
 * @param {Source} value
 * @param {string} drawing
 * @param {string} name
 * @param {string} says
 */
export function source(value, drawing, name, says) {
  const input = make("input", { type: "radio", name: "source", value });
  const note = make("span.note", says);
  const words = make("span.source-words", make("span.source-name", name), note);
  return { input, note, says, row: make("label.source", input, icon(drawing), words) };
}

/**
 * A whole number with − and +.
 * @param {string} id
 * @param {string} name
 * @param {number} start
 */
export function stepper(id, name, start) {
  const input = make("input.words", {
    id,
    type: "text",
    inputmode: "numeric",
    value: String(start),
    autocomplete: "off",
  });
  /** @param {number} step */
  const by = (step) => {
    const sign = step < 0 ? "−" : "+";
    const button = make(
      "button.button",
      { "aria-label": `${name}: ${step < 0 ? t("fields.one_less") : t("fields.one_more")}` },
      sign,
    );
    button.addEventListener("click", () => {
      field.value = Math.min(40, Math.max(3, (field.value || start) + step));
      input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    return button;
  };
  const field = {
    row: make("div.box", make("label", { for: id }, name), make("div.corner-count", by(-1), input, by(1))),
    get value() {
      return /^\d{1,2}$/.test(input.value.trim()) ? Number(input.value) : NaN;
    },
    set value(count) {
      input.value = String(count);
    },
  };
  return field;
}

/**
 * A length, entered in millimetres.
 * @param {string} id
 * @param {string} name
 * @param {string} unit
 * @param {string} start
 */
export function box(id, name, unit, start) {
  const input = make("input.words", { id, type: "text", inputmode: "decimal", value: start, autocomplete: "off" });
  const row = make(
    "div.box",
    make("label", { for: id }, name),
    make("div.inline.with-unit", input, make("span", unit)),
  );
  return {
    row,
    get entered() {
      return input.value.trim();
    },
    /** @returns {number | null} null when it is empty, NaN when it is no number */
    get metres() {
      const text = input.value.trim().replace(",", ".");
      return text === "" ? null : Number(text) / 1000;
    },
    set metres(length) {
      input.value = length === null ? "" : String(Math.round(length * 1e5) / 100);
    },
  };
}

/** @param {string} name */
export const option = (name) => make("option", { value: name }, name === "letter" ? t("fields.us_letter") : name);

/** @typedef {{columns: number, rows: number}} Counts */

const SQUARE = 10;
const ROOM = 11; // around the board, for the numbers

export class BoardDrawing extends HTMLElement {
  /** @param {Counts} counts inner corners */
  show({ columns, rows }) {
    if (!(columns > 0 && rows > 0) || !isNew(this, columns, rows)) return;
    const [width, height] = [(columns + 1) * SQUARE, (rows + 1) * SQUARE];
    const drawing = svg("svg", {
      viewBox: `${-ROOM} ${-ROOM} ${width + 1.4 * ROOM} ${height + 1.4 * ROOM}`,
      role: "img",
      "aria-label": t("board-drawing.a_board_of_columns_by_rows", {
        columns: columns + 1,
        rows: rows + 1,
        columns2: columns,
        rows2: rows,
      }),
    });
    drawing.append(svg("rect", { class: "board-paper", x: -3, y: -3, width: width + 6, height: height + 6, rx: 1.5 }));
    for (let row = 0; row <= rows; row += 1)
      for (let column = row % 2; column <= columns; column += 2)
        drawing.append(
          svg("rect", { class: "board-square", x: column * SQUARE, y: row * SQUARE, width: SQUARE, height: SQUARE }),
        );
    for (let row = 1; row <= rows; row += 1)
      for (let column = 1; column <= columns; column += 1) {
        const counted = row === 1 || column === 1;
        const place = { cx: column * SQUARE, cy: row * SQUARE, r: counted ? 2.3 : 1.5 };
        drawing.append(svg("circle", { class: counted ? "board-corner is-counted" : "board-corner", ...place }));
      }
    for (let column = 1; column <= columns; column += 1) drawing.append(number(column * SQUARE, -6.5, column, columns));
    for (let row = 1; row <= rows; row += 1) drawing.append(number(-7, row * SQUARE, row, rows));
    this.replaceChildren(drawing);
  }
}

/**
 * @param {number} x
 * @param {number} y
 * @param {number} value
 * @param {number} last the one to be entered
 */
function number(x, y, value, last) {
  const kind = value === last ? "board-number is-last" : "board-number";
  const text = svg("text", { class: kind, x, y, "text-anchor": "middle", "dominant-baseline": "central" });
  text.textContent = String(value);
  return text;
}

customElements.define("board-drawing", BoardDrawing);

/** Landscape pages [mm]; margins as in the printable board of the console. */
const PAGES = /** @type {Readonly<Record<string, readonly [number, number]>>} */ ({
  A4: [297, 210],
  A3: [420, 297],
  letter: [279.4, 215.9],
});
const RIMS = 16; // [mm] both together
const RULERS = 12; // [mm]

const FILES = t("calibration-setup.press_start_then_choose_the_pictures");
const PLANS = {
  camera: t("calibration-setup.fetch_a_chessboard_or_print_one"),
  laser: t("calibration-setup.the_laser_looks_at_the_empty") + t("calibration-setup.ten_times_for_two_seconds_tilted"),
};

class CalibrationSetup extends WizardStep {
  #title = make("h2.setup-title", { tabindex: "-1" });
  #sources = {
    robot: source(
      "robot",
      "antenna",
      t("calibration-setup.the_robot_s_camera"),
      t("calibration-setup.what_the_robot_sees_now"),
    ),
    webcam: source(
      "webcam",
      "webcam",
      t("calibration-setup.this_device_s_camera"),
      t("calibration-setup.for_a_camera_on_this_computer"),
    ),
    upload: source(
      "upload",
      "upload",
      t("calibration-setup.picture_files"),
      t("calibration-setup.pictures_taken_before_jpeg_or_png"),
    ),
  };
  #plan = make("p.setup-plan");
  #against = make("p.note");
  #where = make("fieldset.card.sources");
  #drawing = new BoardDrawing();
  #columns = stepper("columns", t("calibration-setup.inner_corners_across"), 9);
  #rows = stepper("rows", t("calibration-setup.inner_corners_down"), 6);
  #square = box("square", t("calibration-setup.side_of_a_square"), "mm", "25");
  #panelWidth = box("panel-width", t("calibration-setup.panel_width"), "mm", "");
  #panelHeight = box("panel-height", t("calibration-setup.panel_height"), "mm", "");
  #height = box("height", t("calibration-setup.camera_above_the_laser"), "mm", "");
  #print = make(
    "a.link",
    { target: "_blank", rel: "noopener" },
    icon("print"),
    t("calibration-setup.print_this_board"),
  );
  #fits = make("p.note.print-fits");
  #page = make(
    "select.field-box",
    { "aria-label": t("calibration-setup.paper") },
    ...["A4", "A3", "letter"].map(option),
  );
  #toPrint = make("p.row.print-line", this.#print, this.#page);
  #begin = make("button.button.primary.large", { type: "submit" }, t("calibration-setup.start"));
  #says = make("p.setup-says", { role: "alert" });
  #laserOnly = make(
    "details.more",
    make("summary", t("calibration-setup.the_board_cannot_be_tilted_a")),
    make("p.note", t("calibration-setup.upright_boards_leave_height_roll_and")),
    make("div.boxes", this.#height.row),
  );

  /** @override */
  build() {
    const legend = make("legend.card-title", t("calibration-setup.where_do_the_pictures_come_from"));
    this.#where.append(legend, ...Object.values(this.#sources).map(({ row }) => row));
    const board = make(
      "fieldset.card.board-card",
      make("legend.card-title", t("calibration-setup.which_board")),
      make("div.board-figure", this.#drawing, make("p.note", t("calibration-setup.count_the_dots_the_points_where"))),
      make(
        "div.board-boxes",
        this.#columns.row,
        this.#rows.row,
        this.#square.row,
        make("p.note", t("calibration-setup.measure_five_squares_with_a_ruler")),
        this.#toPrint,
        this.#fits,
        make(
          "details.more",
          make("summary", t("calibration-setup.the_print_is_glued_on_a")),
          make("p.note", t("calibration-setup.the_laser_sees_the_whole_panel")),
          make("div.boxes", this.#panelWidth.row, this.#panelHeight.row),
        ),
        this.#laserOnly,
      ),
    );
    const form = make(
      "form.setup",
      { novalidate: true, oninput: () => this.#show() },
      make("div.setup-head", this.#title, this.#plan, this.#against),
      this.#where,
      board,
      make("div.setup-foot", this.#says, this.#begin),
    );
    this.append(form);
    this.#remembered();
    onSubmit(form, () => void this.#start());
  }

  get #kind() {
    return this.model.place.at === "new" ? this.model.place.kind : "camera";
  }

  /** @override */
  opened() {
    write(this.#says, "");
    write(
      this.#title,
      this.#kind === "camera"
        ? t("calibration-setup.calibrate_the_camera")
        : t("calibration-setup.calibrate_the_laser_on_the_camera"),
    );
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
    write(
      this.#against,
      camera ? t("calibration-setup.the_camera_it_is_measured_against", { inwords: inWords("camera", camera) }) : "",
    );
    this.#begin.hidden = !may;
    if (!may && !this.#says.textContent) write(this.#says, t("calibration-setup.you_are_watching_only_an_operator"));
  }

  /** @param {"robot" | "webcam"} which @param {string} why not; "" when it may be chosen */
  #offer(which, why) {
    const { input, note, says, row } = this.#sources[which];
    input.disabled = why !== "";
    row.toggleAttribute("data-off", why !== "");
    write(note, why || says);
    if (why && input.checked) this.#sources.upload.input.checked = true;
  }

  #show() {
    const files = this.#kind === "camera" && this.#sources.upload.input.checked;
    const demo = this.model.simulated ? ` ${t("calibration-setup.in_the_simulator_show_me")}` : "";
    write(this.#plan, files ? FILES : PLANS[this.#kind] + demo);
    this.#toPrint.hidden = files;
    const board = this.#board();
    this.#drawing.show({ columns: this.#columns.value, rows: this.#rows.value });
    this.#print.href = api.printable(board, this.#page.value);
    const [across = 0, down = 0] = PAGES[this.#page.value] ?? [];
    const largest = Math.min((across - RIMS) / (board.columns + 1), (down - RIMS - RULERS) / (board.rows + 1));
    const fits = !(board.square_m * 1000 > largest);
    this.#fits.hidden = fits || files;
    this.#print.hidden = !fits;
    const advice = t("calibration-setup.at_most_floor_mm_do_enter", { floor: Math.floor(largest) });
    write(
      this.#fits,
      fits ? "" : t("calibration-setup.squares_of_entered_mm_do_not", { entered: this.#square.entered, advice }),
    );
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
      return t("calibration-setup.a_board_needs_3_to_40");
    if (!(square >= 0.001 && square <= 1)) return t("calibration-setup.enter_the_side_of_one_square");
    if ((this.#panelWidth.metres === null) !== (this.#panelHeight.metres === null))
      return t("calibration-setup.enter_both_sides_of_the_panel");
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
    write(this.#begin, t("calibration-setup.starting"));
    try {
      const height = kind === "laser" ? this.#height.metres : null;
      const begun = await api.begin({ kind, board, source: from, height_m: height });
      if (from === "robot") await api.live(begun.id, true);
      this.model.go({ at: "capture", id: begun.id });
    } catch (refusal) {
      write(this.#says, sentenceOf(refusal));
    } finally {
      write(this.#begin, t("calibration-setup.start"));
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
