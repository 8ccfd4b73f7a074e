// Element <values-card>: estimated values and standard deviations (Table 3), next to the active ones.
// Element <poses-card>: where the board was in every view, in the camera's frame, with standard deviations.
// Element <findings-card>: findings about a solution in sentences: predicted error, warnings, checks.
// Element <exports-card>: download links of the calibration in several formats.
// Element <fields-card>: residual vectors and projection uncertainty over the picture.

import { cardHead, icon, isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { inLanguage, t } from "../ui/texts.js";
import { isDark } from "../ui/theme.js";
import * as api from "./api.js";
import { paint } from "./capture-cards.js";
import { cameraRows, mountRows, poseRows } from "./figures.js";
import { heatWords } from "./progress.js";

/** @import { Calibration } from "./types.js" */

export class ValuesCard extends HTMLElement {
  #title = make("h2.card-title");
  #head = make("tr");
  #body = make("tbody");
  #note = make("p.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("div.card-head", this.#title),
      make("table.values", make("thead", this.#head), this.#body),
      this.#note,
    );
  }

  /** @param {Calibration} calibration */
  show({ kind, solution, active_compare: compare }) {
    this.hidden = solution === null;
    if (!solution || !isNew(this, solution?.["sd"], solution?.["fx"], solution?.["translation_m"], compare)) return;
    const rows = kind === "camera" ? cameraRows(solution, compare) : mountRows(solution, compare);
    const compared = rows.some((row) => row.other);
    write(this.#title, kind === "camera" ? t("values-card.the_camera") : t("values-card.the_camera_on_the_laser"));
    this.classList.toggle("is-compared", compared); // no room for explanations then
    const columns = [
      "",
      t("values-card.value"),
      t("values-card.standard_dev"),
      ...(compared ? [t("values-card.in_use"), t("values-card.change")] : []),
    ];
    this.#head.replaceChildren(...columns.map((name) => make("th", { scope: "col" }, name)));
    this.#body.replaceChildren(
      ...rows.map((row) => {
        const name = make(
          "th",
          { scope: "row", title: row.says },
          make("span.value-name", row.name),
          make("span.note", row.says),
        );
        const change = make("td", row.change);
        mark(change, "data-far", row.far);
        const cells = [make("td", { class: row.open && "open" }, row.value), make("td", row.sd)];
        return make("tr", name, ...cells, ...(compared ? [make("td", row.other), change] : []));
      }),
    );
    write(
      this.#note,
      kind === "camera"
        ? t("values-card.one_standard_deviation_the_paper_s", { equation44: equation44(solution) })
        : t("values-card.one_standard_deviation_turns_are_away"),
    );
  }
}

/**
 * The coefficients in the printed form of eq. 44, where the console runs the chapter's own forms.
 * @param {Record<string, any>} solution
 */
function equation44(solution) {
  const printed = solution["eq_44"];
  if (!printed) return "";
  const names = /** @type {const} */ ([
    ["k1", "k₁"],
    ["k2", "k₂"],
    ["p1", "p₁"],
    ["p2", "p₂"],
  ]);
  const values = names.map(([key, name]) => `${name} = ${printed[key].toExponential(3)}`).join(", ");
  return ` As printed (eq. 44, f = ${printed["f_px"].toFixed(2)} px): ${values}.`;
}

customElements.define("values-card", ValuesCard);

export class PosesCard extends HTMLElement {
  #body = make("tbody");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    const names = [t("poses-card.view"), t("poses-card.place_mm"), t("poses-card.turn_degrees")];
    const head = make("tr", ...names.map((name) => make("th", { scope: "col" }, name)));
    this.append(
      cardHead(t("poses-card.poses_of_the_board")),
      make("table.values", make("thead", head), this.#body),
      make("p.note", t("poses-card.in_the_camera_s_frame")),
    );
  }

  /** @param {Calibration} calibration */
  show({ solution, kind }) {
    const rows = poseRows(kind === "camera" ? (solution?.["views"] ?? []) : []);
    this.hidden = rows.length === 0;
    if (!isNew(this, rows)) return;
    this.#body.replaceChildren(
      ...rows.map(([name, place, turned]) =>
        make("tr", make("th", { scope: "row" }, name), make("td", place), make("td", turned)),
      ),
    );
  }
}

customElements.define("poses-card", PosesCard);

export class FindingsCard extends HTMLElement {
  #offsets = make("tbody");
  #table = make(
    "table.values.laser-offset-table",
    make("caption", t("findings-card.where_a_laser_point_lands_in")),
    make(
      "thead",
      make(
        "tr",
        ...[t("findings-card.distance"), t("findings-card.sideways"), t("findings-card.up_down")].map((name) =>
          make("th", { scope: "col" }, name),
        ),
      ),
    ),
    this.#offsets,
  );
  #list = make("ul.findings");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("findings-card.what_to_know")), this.#table, this.#list);
  }

  /** @param {Calibration} calibration */
  show({ solution, check, kind }) {
    const findings = solution ? sentences(kind, solution, check?.words ?? "") : [];
    this.hidden = findings.length === 0 && !solution?.["laser_offset"];
    if (!isNew(this, findings, solution?.["laser_offset"])) return;
    /** @type {Array<{distance_m: number, sideways_px: number, up_down_px: number}>} */
    const offsets = solution?.["laser_offset"] ?? [];
    this.#table.hidden = offsets.length === 0;
    this.#offsets.replaceChildren(
      ...offsets.map((row) =>
        make(
          "tr",
          make("th", { scope: "row" }, `${fixed(row.distance_m, 1)} m`),
          make("td", t("findings-card.fixed_px", { fixed: fixed(row.sideways_px, 1) })),
          make("td", t("findings-card.fixed_px", { fixed: fixed(row.up_down_px, 1) })),
        ),
      ),
    );
    this.#list.replaceChildren(
      ...findings.map(({ doubt, words }) => {
        const sentence = make("span");
        write(sentence, words);
        return make("li", { "data-doubt": doubt }, icon(doubt ? "warning" : "done"), sentence);
      }),
    );
  }
}

/**
 * @param {"camera" | "laser"} kind
 * @param {Record<string, any>} solution
 * @param {string} check how a pose without a part in the solution was predicted
 * @returns {Array<{doubt: boolean, words: string}>}
 */
function sentences(kind, solution, check) {
  /** @type {string[]} */
  const doubts = [...(solution["weak_directions"] ?? []), ...(solution["warnings"] ?? [])];
  /** @type {string[]} */
  const good = [];
  if (kind === "camera")
    good.push(
      t("findings-card.corners_are_met_to_fixed_px", {
        fixed: fixed(solution["rms_px"], 2),
        solution: solution["views_used"],
      }),
    );
  else
    good.push(
      t("findings-card.board_and_laser_agree_to_fixed", {
        fixed: fixed(1e3 * solution["residual_rms_m"], 1),
        solution: solution["poses_used"],
      }),
    );
  if (kind === "laser" && solution["square_words"]) good.push(`${inLanguage(solution["square_words"])}.`);
  if (check) good.push(check);
  return [
    ...doubts.map((words) => ({ doubt: true, words: inLanguage(words) })),
    ...good.map((words) => ({ doubt: false, words })),
  ];
}

customElements.define("findings-card", FindingsCard);

const FORMS = {
  camera: [
    ["ros", "ROS", t("exports-card.camera_info_yaml")],
    ["opencv", "OpenCV", "FileStorage YAML"],
    ["kalibr", "Kalibr", "camchain YAML"],
    ["json", "Beckon", t("exports-card.json_with_covariance")],
  ],
  laser: [
    ["json", "Beckon", t("exports-card.json_with_covariance")],
    ["urdf", "URDF", t("exports-card.fixed_joint")],
    ["static_transform", "ROS", t("exports-card.static_transform")],
    ["matrix", t("exports-card.matrix"), t("exports-card.4_4_both_ways")],
  ],
};

export class ExportsCard extends HTMLElement {
  #list = make("ul.exports");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("exports-card.take_it_along")), this.#list);
  }

  /** @param {Calibration} calibration */
  show({ id, kind, solution }) {
    this.hidden = solution === null;
    const bent = typeof solution?.["k3"] === "number";
    if (!isNew(this, id, bent)) return;
    const forms = [
      ...FORMS[kind],
      ["all", t("exports-card.everything"), t("exports-card.pictures_corners_solution_zip")],
    ];
    this.#list.replaceChildren(
      ...forms.map(([form = "", name = "", says = ""]) =>
        make("li", bent && form === "kalibr" ? NO_KALIBR() : link(api.exported(id, form), name, says)),
      ),
    );
  }
}

/** @param {string} href @param {string} name @param {string} says */
function link(href, name, says) {
  const words = make("span", make("span.export-name", name), make("span.note", says));
  return make("a.export", { href, download: "" }, icon("download"), words);
}

const NO_KALIBR = () => make("p.export.note", t("exports-card.kalibr_s_form_has_no_place"));

customElements.define("exports-card", ExportsCard);

const ACROSS = 640; // canvas pixels
const TYPICAL = 16; // canvas pixels that a typical miss is drawn long

export class FieldsCard extends HTMLElement {
  #arrows = make("canvas.field", { role: "img" });
  #heat = make("canvas.field.heat", { role: "img" });
  #arrowWords = make("figcaption.note");
  #heatWords = make("figcaption.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("figure", make("h2.card-title", t("fields-card.what_is_left_over")), this.#arrows, this.#arrowWords),
      make("figure", make("h2.card-title", t("fields-card.how_sure")), this.#heat, this.#heatWords),
    );
  }

  /** @param {Calibration} calibration */
  show({ solution, uncertainty, size, progress }) {
    /** @type {Array<[number, number, number, number]>} */
    const residuals = solution?.["residuals"] ?? [];
    this.hidden = !size || (!residuals.length && !uncertainty);
    if (this.hidden || !size) return;
    if (!isNew(this, residuals.length, residuals[0], progress.p95_px, isDark())) return;
    this.#arrows.style.aspectRatio = this.#heat.style.aspectRatio = `${size[0]} / ${size[1]}`;
    const longer = draw(this.#arrows, residuals, size);
    const rms = solution?.["rms_px"];
    const misses = t("fields-card.every_corner_s_miss_drawn_longer", { longer, fixed: fixed(rms ?? NaN, 2) });
    write(this.#arrowWords, t("fields-card.misses_no_pattern_should_be_seen", { misses }));
    mark(this.#arrows, "aria-label", misses);
    if (!uncertainty) return;
    const target = progress.target_px ?? 0.5;
    paint(this.#heat, uncertainty, target);
    write(this.#heatWords, `${heatWords(uncertainty, target)}.`);
  }
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Array<[number, number, number, number]>} residuals u, v, du, dv [px]
 * @param {readonly [number, number]} size of the picture
 * @returns {number} how many times longer they are drawn
 */
function draw(canvas, residuals, [width, height]) {
  const scale = ACROSS / width;
  [canvas.width, canvas.height] = [ACROSS, Math.round(height * scale)];
  const brush = canvas.getContext("2d", { willReadFrequently: true });
  const lengths = residuals.map(([, , du, dv]) => Math.hypot(du, dv)).sort((a, b) => a - b);
  const typical = lengths[Math.floor(0.7 * lengths.length)] ?? 1;
  const longer = round(TYPICAL / Math.max(typical * scale, 1e-6));
  if (!brush) return longer;
  brush.strokeStyle = isDark() ? "#43d1e8" : "#08748a";
  brush.fillStyle = brush.strokeStyle;
  brush.lineWidth = 1.5;
  for (const [u, v, du, dv] of residuals) {
    const [x, y] = [(u + 0.5) * scale, (v + 0.5) * scale];
    brush.beginPath();
    brush.moveTo(x, y);
    brush.lineTo(x + du * scale * longer, y + dv * scale * longer);
    brush.stroke();
    brush.beginPath();
    brush.arc(x, y, 1.8, 0, 2 * Math.PI);
    brush.fill();
  }
  return longer;
}

/** To 1, 2 or 5 times a power of ten. @param {number} factor */
function round(factor) {
  const power = 10 ** Math.floor(Math.log10(Math.max(factor, 1)));
  return power * (factor / power >= 5 ? 5 : factor / power >= 2 ? 2 : 1);
}

customElements.define("fields-card", FieldsCard);
