// Start page of the calibration: active calibrations, sessions begun before, and the three wizards.

import { address, wordedPath } from "../net/api.js";
import { cardHead, icon, iconButton, isNew, make, mark, write } from "../ui/element.js";
import { sure } from "../ui/row-question.js";
import { t } from "../ui/texts.js";
import { inWords, since, standing, takenBack, takesBack } from "./active-calibration.js";
import * as api from "./api.js";
import { orientationInWords, read as readMicrophones } from "./microphones-api.js";
import { RobotCamera } from "./picture-source.js";
import { WizardStep } from "./wizard-step.js";

/** @import { Kind } from "./types.js" */
/** @import { SessionRow as Row } from "../net/rest.js" */

const SOURCES = {
  robot: t("calibration-home.robot_s_camera"),
  upload: t("calibration-home.picture_files"),
  webcam: t("calibration-home.this_browser_s_camera"),
};

const COUNTED = /** @type {const} */ ({
  camera: ["calibration-home.one_view", "calibration-home.count_views"],
  laser: ["calibration-home.one_pose", "calibration-home.count_poses"],
});

const WIDE = matchMedia("(min-width: 1200px)"); // where there is room for the camera's picture beside the wizards

class CalibrationHome extends WizardStep {
  #camera = wizard(
    "camera",
    "camera",
    t("calibration-home.camera"),
    t("calibration-home.how_the_lens_bends_the_picture"),
  );
  #laser = wizard(
    "laser",
    "laser",
    t("calibration-home.laser_on_the_camera"),
    t("calibration-home.where_every_laser_point_lies_in"),
  );
  #microphones = wizard(
    "microphones",
    "ears",
    t("calibration-home.microphones"),
    t("calibration-home.how_the_array_is_turned_on"),
  );
  #picture = make("canvas.home-picture", { role: "img", "aria-label": t("calibration-home.what_the_camera_sees_now") });
  #sees = make(
    "section.card.page-card.home-sees",
    make("h2", t("calibration-home.what_the_camera_sees_now")),
    this.#picture,
    make("p.note", t("calibration-home.straight_edges_look_bent_at_the")),
  );
  /** @type {RobotCamera | null} */
  #robot = null;
  #rows = make("ul.rows");
  #begun = make("section.card.begun", { "aria-label": t("calibration-home.begun"), hidden: true });
  #file = make("input.visually-hidden", {
    type: "file",
    id: "camera-file",
    accept: ".json,.yaml,.yml,.txt,.xml,.urdf,.sh",
  });
  #foot = make("p.card.row.home-foot", { hidden: true });

  /** @override */
  build() {
    this.append(
      make(
        "div.home",
        make("div.wizards", this.#camera.card, this.#laser.card, this.#microphones.card),
        this.#sees,
        this.#begun,
        this.#foot,
      ),
    );
    this.#foot.append(
      icon("upload"),
      make("label.link", { for: "camera-file" }, t("calibration-home.bring_a_file")),
      this.#file,
      make("span.note", t("calibration-home.of_a_camera_ros_opencv_kalibr")),
    );
    for (const [kind, { start, undo }] of /** @type {const} */ ([
      ["camera", this.#camera],
      ["laser", this.#laser],
    ])) {
      start.addEventListener("click", () => this.model.go({ at: "new", kind: this.#first ? "camera" : kind }));
      undo.addEventListener(
        "click",
        () => sure(undo, t("calibration-home.press_again_to_take_it_back")) && void this.#undo(kind),
      );
    }
    this.#microphones.start.addEventListener("click", () => this.model.go({ at: "microphones" }));
    this.#microphones.undo.hidden = true;
    write(this.#microphones.start, t("calibration-home.open"));
    this.#file.addEventListener("change", () => void this.#bring());
  }

  /** @override */
  left() {
    this.#robot?.close();
  }

  /** @override */
  opened() {
    this.#robot ??= new RobotCamera(this.session);
    if (WIDE.matches) this.#robot.open();
    readMicrophones().then(
      (report) => {
        write(
          this.#microphones.used,
          report.microphones ? orientationInWords(report.active) : t("calibration-home.this_robot_has_no_microphones"),
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
    this.#drawPicture();
    const { rows, inUse, may } = this.model;
    if (!isNew(this, rows, inUse, may)) return;
    for (const [kind, card] of /** @type {const} */ ([
      ["camera", this.#camera],
      ["laser", this.#laser],
    ])) {
      const report = inUse?.[kind] ?? null;
      write(card.used, report ? inWords(kind, report) : NOTHING[kind]);
      card.used.toggleAttribute("data-some", report !== null && !report["not_used"]);
      card.start.hidden = !may;
      card.undo.hidden = !may || report === null;
      write(card.undo, takesBack(report));
      mark(card.undo, "aria-label", `${takesBack(report)}: ${CALLED[kind]}`);
      card.report.hidden = report === null;
      write(card.why, may ? "" : t("calibration-home.you_are_watching_only_an_operator"));
    }
    write(this.#laser.start, this.#first ? t("calibration-home.begin_with_the_camera") : t("calibration-home.begin"));
    this.#laser.start.classList.toggle("primary", !this.#first);
    this.#foot.hidden = !may;
    this.#begun.hidden = !rows?.length;
    const title = t(may ? "calibration-home.go_on_where_you_left_off" : "calibration-home.calibrations_to_look_at");
    this.#begun.replaceChildren(cardHead(title), this.#rows);
    this.#rows.replaceChildren(...(rows ?? []).map((row) => this.#row(row)));
  }

  #drawPicture() {
    const frame = this.#robot?.frame;
    this.#sees.hidden = !frame;
    if (!frame) return;
    [this.#picture.width, this.#picture.height] = [frame.width, frame.height];
    this.#picture.getContext("2d")?.drawImage(frame.image, 0, 0);
  }

  /** @param {Row} row */
  #row(row) {
    const what = CALLED[row.kind];
    const how = standing(row, this.model.inUse?.[row.kind]);
    const [one, more] = COUNTED[row.kind === "camera" ? "camera" : "laser"];
    const count = t(row.views === 1 ? one : more, { count: row.views });
    const go = make(
      "a.row-open",
      { href: `#s=${row.id}${row.ready ? "&review" : ""}` },
      icon(row.kind),
      make(
        "span",
        make("b", `${what}, ${count}`),
        make("span.note", `${how} · ${SOURCES[row.source]} · ${since(row.created_s)}`),
      ),
      row.ready && icon("done"),
    );
    const says = t("calibration-home.delete_what_count", { what, count });
    const away = iconButton("close", says, () => void this.#forget(row, away));
    return make("li", go, this.model.may && away);
  }

  /** Delete a session on the second press. @param {Row} row @param {HTMLButtonElement} button */
  async #forget(row, button) {
    if (!button.dataset["sure"]) {
      button.dataset["sure"] = "asked";
      button.classList.replace("icon-button", "button");
      button.replaceChildren(t("calibration-home.delete_it"));
      this.session.announce(t("calibration-home.press_once_more_to_delete_this"));
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
      this.session.announce(
        t("calibration-home.the_value_in_the_file_is", {
          value: imported.kind === "laser" ? t("calibration-home.mount") : t("calibration-home.a_camera"),
        }),
      );
    await this.model.readLists();
  }
}

/** @type {Readonly<Record<Kind, string>>} */
const CALLED = { camera: t("calibration-home.camera"), laser: t("calibration-home.laser_on_the_camera") };

/** @type {Readonly<Record<Kind, string>>} */
const NOTHING = {
  camera: t("calibration-home.not_calibrated_the_maker_s_nominal"),
  laser: t("calibration-home.not_calibrated_the_nominal_mount_is"),
};

/**
 * @param {Kind | "microphones"} kind
 * @param {string} drawing
 * @param {string} name
 * @param {string} says
 */
function wizard(kind, drawing, name, says) {
  const used = make("p.wizard-used", "");
  const why = make("p.note");
  const start = make("button.button.primary.large", t("calibration-home.begin"));
  start.setAttribute("aria-describedby", `about-${kind}`);
  const undo = make("button.button.plain");
  const href = address(wordedPath(`api/reports/calibration/${kind}`)).href;
  const report = make("a.button.plain", { href, download: "", hidden: true }, t("calibration-home.report"));
  const card = make(
    "section.card.wizard-card",
    { "aria-label": name, "data-kind": kind },
    make("span.wizard-sign", icon(drawing)),
    make("h2", { id: `about-${kind}` }, name),
    make("p.wizard-says", says),
    used,
    make("div.row", start, undo, report),
    why,
  );
  return { card, used, why, start, undo, report };
}

customElements.define("calibration-home", CalibrationHome);
