// Wizard for the microphone array: claps from known directions give its orientation on the robot.
// Element <clap-compass>: requested and measured clap directions around the robot, and the array’s orientation.

import { action, iconButton, isNew, make, mark, svg, write } from "../ui/element.js";
import { degrees } from "../ui/format.js";
import { meter } from "../ui/meter.js";
import { sure } from "../ui/row-question.js";
import { inLanguage, t } from "../ui/texts.js";
import * as api from "./microphones-api.js";
import { WizardStep } from "./wizard-step.js";

/** @import { MicrophonesState as MicrophoneCalibration } from "../net/rest.js" */

const RING = 78;
const HEARD = 60;

export class ClapCompass extends HTMLElement {
  #marks = svg("g", {});
  #array = svg("g", { class: "compass-array" });

  connectedCallback() {
    if (this.firstChild) return;
    const drawing = svg("svg", {
      viewBox: "-100 -100 200 200",
      role: "img",
      "aria-label": t("clap-compass.where_claps_are_asked_for_and"),
    });
    this.#array.append(
      svg("rect", { x: -17, y: -17, width: 34, height: 34, rx: 6 }),
      svg("path", { d: "M0 -9V-30M-5 -24L0 -30L5 -24" }),
    );
    drawing.append(
      svg("circle", { class: "compass-ring", cx: 0, cy: 0, r: RING }),
      svg("path", { class: "compass-ahead", d: "M0 -97l5 9h-10z" }),
      this.#array,
      this.#marks,
    );
    this.append(drawing);
  }

  /** @param {MicrophoneCalibration} calibration @param {number} next where the next clap is asked for [rad] */
  show({ asked_rad, claps, solution, active }, next) {
    const shown = solution ?? active;
    this.#array.setAttribute("transform", `rotate(${turned(shown?.yaw_rad ?? 0)})`);
    this.#array.setAttribute("data-known", String(shown !== null));
    const places = [...new Set([...asked_rad, next])].map((angle) => {
      const place = svg("circle", { class: "compass-asked", cx: x(angle, RING), cy: y(angle, RING), r: 8 });
      const taken = claps.some(({ asked_rad: asked }) => asked === angle);
      place.setAttribute("data-state", angle === next ? "next" : taken ? "taken" : "open");
      return place;
    });
    const heard = solution
      ? claps.map(({ asked_rad: asked, gap_rad: gap }) => {
          const angle = asked - (gap ?? 0);
          return svg("path", { class: "compass-heard", d: `M0 0L${x(angle, HEARD)} ${y(angle, HEARD)}` });
        })
      : [];
    this.#marks.replaceChildren(...heard, ...places);
  }
}

/** @param {number} angle [rad] counter-clockwise from ahead */
const turned = (angle) => ((-angle * 180) / Math.PI).toFixed(1);

/** @param {number} angle @param {number} radius */
const x = (angle, radius) => (-radius * Math.sin(angle)).toFixed(2);

/** @param {number} angle @param {number} radius */
const y = (angle, radius) => (-radius * Math.cos(angle)).toFixed(2);

customElements.define("clap-compass", ClapCompass);

class CalibrationMicrophones extends WizardStep {
  /** @type {MicrophoneCalibration | null} */
  #calibration = null;
  #busy = false;
  #demo = false;
  #compass = new ClapCompass();
  #advice = make("p.claps-advice", { role: "status" });
  #verdict = make("p.claps-verdict", { role: "alert" });
  #progress = meter("div.meter.progress", {
    role: "progressbar",
    "aria-label": t("calibration-microphones.listening"),
    hidden: true,
  });
  #listen = action("ears", t("calibration-microphones.listen_for_a_clap"), () => void this.#clap(false));
  #show = action("demo", t("calibration-microphones.show_me"), () => void this.#showMe());
  #again = action("undo", t("calibration-microphones.start_again"), () => this.#startAgain());
  #claps = make("ol.claps-list", { "aria-label": t("calibration-microphones.claps") });
  #found = make("p.claps-found");
  #remark = make("p.note");
  #accept = make("button.button.primary.large", t("calibration-microphones.use_this_orientation"));
  #used = make("p.note");
  #undo = make("button.button.plain", t("calibration-microphones.use_the_profile_s_own_orientation"));

  /** @override */
  build() {
    this.append(
      make(
        "div.claps",
        make(
          "section.card.page-card.claps-stage",
          { "aria-label": t("calibration-microphones.claps_from_known_sides") },
          make("h2", t("calibration-microphones.how_are_the_microphones_turned")),
          make("p.note", t("calibration-microphones.stand_where_the_ring_says_press")),
          this.#compass,
          this.#advice,
          this.#progress.element,
          this.#verdict,
          make("div.row.claps-buttons", this.#listen, this.#show, this.#again),
        ),
        make(
          "section.card.page-card",
          { "aria-label": t("calibration-microphones.result") },
          make("h3", t("calibration-microphones.what_was_heard")),
          this.#claps,
          this.#found,
          this.#remark,
          this.#accept,
          this.#used,
          this.#undo,
        ),
      ),
    );
    this.#listen.classList.add("primary");
    this.#accept.addEventListener("click", async () => {
      if (await this.#tried(() => api.perform("accept")))
        this.session.announce(t("calibration-microphones.this_orientation_is_in_use"));
    });
    this.#undo.addEventListener("click", () => void this.#tried(() => api.perform("undo")));
  }

  /** @override */
  opened() {
    void this.#tried(api.read);
  }

  /** @override */
  left() {
    this.#demo = false;
  }

  /** Direction of the next clap [rad]. */
  get #next() {
    const { asked_rad = [0], claps = [] } = this.#calibration ?? {};
    const open = asked_rad.find((angle) => !claps.some((clap) => clap.asked_rad === angle));
    return open ?? asked_rad[claps.length % asked_rad.length] ?? 0;
  }

  /** @override */
  draw() {
    const calibration = this.#calibration;
    if (!calibration) return;
    const { may } = this.model;
    this.#listen.disabled = this.#again.disabled = this.#busy || !may || !calibration.microphones;
    this.#show.hidden = !calibration.simulated;
    this.#show.disabled =
      !may ||
      !calibration.microphones ||
      (this.#busy && !this.#demo) ||
      calibration.claps.length >= calibration.asked_rad.length;
    write(
      /** @type {Element} */ (this.#show.lastElementChild),
      this.#demo ? t("calibration-microphones.enough_shown") : t("calibration-microphones.show_me"),
    );
    this.#accept.hidden = calibration.solution === null || !may;
    this.#accept.disabled = this.#busy;
    this.#undo.hidden = calibration.active === null || !may;
    this.#progress.element.hidden = !this.#busy;
    if (!isNew(this, calibration, this.#busy, may)) return;
    this.#compass.show(calibration, this.#next);
    write(
      this.#advice,
      calibration.microphones
        ? inLanguage(calibration.advice)
        : t("calibration-microphones.this_robot_has_no_microphones"),
    );
    write(this.#verdict, inLanguage(calibration.verdict));
    this.#verdict.hidden = calibration.verdict === "";
    this.#claps.replaceChildren(...calibration.claps.map((clap, index) => this.#row(clap, index)));
    this.#result(calibration);
  }

  /** @param {MicrophoneCalibration} calibration */
  #result({ solution, missing, active: used }) {
    mark(this.#found, "data-some", solution !== null);
    write(
      this.#found,
      solution
        ? t("calibration-microphones.turned_by_turned_degrees", {
            turned: api.turned(solution.yaw_rad),
            degrees: degrees(2 * solution.sd_yaw_rad, 1),
          })
        : inLanguage(missing),
    );
    const agree = solution
      ? t("calibration-microphones.the_claps_agree_to_degrees_rms", { degrees: degrees(solution.residual_rad, 1) })
      : "";
    const down = solution?.mirrored ? t("calibration-microphones.the_array_hangs_upside_down") : "";
    write(this.#remark, agree + down);
    write(this.#used, api.orientationInWords(used));
  }

  /** @param {import("../net/rest.js").ClapRow} clap @param {number} index */
  #row({ asked_rad, heard_rad, sd_rad, gap_rad }, index) {
    const says = t("calibration-microphones.leave_out_clap_index", { index: index + 1 });
    const away = iconButton("close", says, () => void this.#tried(() => api.drop(index)), { look: "small" });
    const gap =
      gap_rad === null
        ? ""
        : t("calibration-microphones.misses_by_degrees", { degrees: degrees(Math.abs(gap_rad), 1) });
    return make(
      "li",
      make("span.clap-asked", side(asked_rad)),
      make(
        "span.note",
        t("calibration-microphones.heard_at_turned_degrees_of_the", {
          turned: api.turned(heard_rad),
          degrees: degrees(2 * sd_rad, 1),
          gap,
        }),
      ),
      this.model.may && away,
    );
  }

  #startAgain() {
    const { length: count } = this.#calibration?.claps ?? [];
    if (count === 0 || sure(this.#again, t("calibration-microphones.press_again_to_delete_claps", { count })))
      void this.#tried(() => api.perform("again"));
  }

  /** @param {boolean} show */
  async #clap(show) {
    const seconds = this.#calibration?.listens_s ?? 3;
    const { style } = this.#progress.fill;
    style.transition = "none";
    style.width = "0";
    void this.#progress.fill.offsetWidth; // so that the next width is reached slowly
    style.transition = `width ${seconds + 0.5}s linear`;
    style.width = "100%";
    if (!show) this.session.announce(t("calibration-microphones.clap_now"));
    return this.#tried(() => api.clap(this.#next, show));
  }

  async #showMe() {
    if (this.#demo) {
      this.#demo = false;
      return;
    }
    this.#demo = true;
    const wanted = this.#calibration?.asked_rad.length ?? 4;
    for (let turn = 0; this.#demo && turn < wanted + 2 && (this.#calibration?.claps.length ?? 0) < wanted; turn += 1)
      if (!(await this.#clap(true))) break;
    this.#demo = false;
    this.draw();
  }

  /** @param {() => Promise<MicrophoneCalibration>} act */
  async #tried(act) {
    this.#busy = true;
    this.draw();
    const answer = await this.model.tried(act);
    this.#calibration = answer ?? this.#calibration;
    this.#busy = false;
    this.draw();
    return answer !== null;
  }
}

/** @param {number} angle [rad] */
function side(angle) {
  const quarter = Math.round((2 * angle) / Math.PI);
  const exact = Math.abs(angle - (quarter * Math.PI) / 2) < 0.01;
  return exact ? (["ahead", "left", "behind", "right"][(quarter + 4) % 4] ?? "") : api.turned(angle);
}

customElements.define("calibration-microphones", CalibrationMicrophones);
