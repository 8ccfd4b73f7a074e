// Element <quality-form>: settings of a measurement: distances, noise levels, number of phrases.

import { make, onSubmit, write } from "../ui/element.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { Runs } from "./runs.js" */

const PLACE = "place";
const DISTANCES = [0.5, 1, 2, 3, 4];
const NOISES = /** @type {const} */ ([
  [30, t("quality-form.quiet")],
  [20, t("quality-form.a_fan")],
  [10, t("quality-form.people_talk")],
  [0, t("quality-form.as_loud_as_you")],
]);
const AROUND = /** @type {const} */ ([
  [t("quality-form.ahead"), 0],
  [t("quality-form.left"), Math.PI / 2],
  [t("quality-form.behind"), Math.PI],
  [t("quality-form.right"), -Math.PI / 2],
  [t("quality-form.at_a_place_of_the_map"), null],
]);
const PHRASES = /** @type {const} */ ([
  [6, t("quality-form.6_a_first_impression")],
  [18, t("quality-form.18_enough_to_judge_by")],
  [36, t("quality-form.36_thorough")],
]);

/** @extends {PagePanel<Runs>} */
class QualityForm extends PagePanel {
  #distances = DISTANCES.map((metres) => tick("distance", metres, `${metres} m`, metres >= 1 && metres <= 3));
  #noises = NOISES.map(([ratio, says]) => tick("noise", ratio, `${ratio} dB`, ratio === 30 || ratio === 10, says));
  #around = make(
    "select.field-box",
    { id: "quality-around" },
    ...AROUND.map(([name, angle]) => make("option", { value: angle === null ? PLACE : String(angle) }, name)),
  );
  #x = make("input.field-box", { type: "number", id: "quality-x", step: "0.1", value: "2" });
  #y = make("input.field-box", { type: "number", id: "quality-y", step: "0.1", value: "1" });
  #place = make(
    "div.quality-row.quality-place",
    make("label", { for: "quality-x" }, "x [m]"),
    this.#x,
    make("label", { for: "quality-y" }, "y [m]"),
    this.#y,
  );
  #far = make("fieldset", make("legend", t("quality-form.how_far_away")), make("div.ticks", ...this.#distances));
  #phrases = make(
    "select.field-box",
    { id: "quality-phrases" },
    ...PHRASES.map(([count, says]) => make("option", { value: String(count) }, says)),
  );
  #begin = make("button.button.primary.large", { type: "submit" }, t("quality-form.measure"));
  #why = make("p.note", { role: "status" });

  /** @override */
  build() {
    this.#phrases.value = "18";
    const form = make(
      "form.card.page-card.quality-form",
      make("h2", t("quality-form.how_well_does_the_robot_hear")),
      make("p", t("quality-form.a_text_of_commands_is_spoken")),
      make("div.quality-row", make("label", { for: "quality-around" }, t("quality-form.where")), this.#around),
      this.#place,
      this.#far,
      make("fieldset", make("legend", t("quality-form.voice_over_noise")), make("div.ticks", ...this.#noises)),
      make("div.quality-row", make("label", { for: "quality-phrases" }, t("quality-form.phrases")), this.#phrases),
      this.#begin,
      this.#why,
    );
    onSubmit(form, () => {
      void this.model.begin({
        snr_db: ticked(this.#noises),
        phrases: Number(this.#phrases.value),
        ...(this.#placed
          ? { x_m: this.#x.valueAsNumber, y_m: this.#y.valueAsNumber }
          : { distances_m: ticked(this.#distances), azimuth_rad: Number(this.#around.value) }),
      });
    });
    form.addEventListener("change", () => this.draw());
    this.append(form);
    this.draw();
  }

  get #placed() {
    return this.#around.value === PLACE;
  }

  /** @returns {number[]} how far the place of the map is from the robot [m]; [] while it is not said where */
  #away() {
    const { x_m: x = 0, y_m: y = 0 } = this.model.session.state?.pose ?? {};
    const metres = Math.hypot(this.#x.valueAsNumber - x, this.#y.valueAsNumber - y);
    return Number.isFinite(metres) ? [Math.round(10 * metres) / 10] : [];
  }

  /** @override */
  draw() {
    const runs = this.model;
    this.#place.hidden = !this.#placed;
    this.#far.hidden = this.#placed;
    const distances = this.#placed ? this.#away() : ticked(this.#distances);
    const noises = ticked(this.#noises);
    const count = distances.length * noises.length;
    runs.plan(distances.flatMap((distance_m) => noises.map((snr_db) => ({ distance_m, snr_db }))));
    const why = runs.whyNot || (runs.runs && !runs.may ? t("quality-form.you_are_watching_only_an_operator") : "");
    this.#begin.disabled = Boolean(why) || count === 0 || runs.running !== null;
    const says =
      count === 0
        ? t("quality-form.choose_a_place_or_at_least")
        : t("quality-form.count_value_each_takes_some_ten", {
            count,
            value: t(count === 1 ? "quality-form.place" : "quality-form.places"),
          });
    write(this.#why, why || (runs.running ? t("quality-form.one_measurement_is_under_way") : says));
  }
}

/**
 * @param {string} name
 * @param {number} value
 * @param {string} says
 * @param {boolean} on
 * @param {string} [note]
 */
function tick(name, value, says, on, note = "") {
  const box = make("input", { type: "checkbox", name, value: String(value), checked: on });
  return make("label.tick", box, make("span", says, note && make("span.note", ` ${note}`)));
}

/** @param {HTMLLabelElement[]} ticks */
const ticked = (ticks) =>
  ticks
    .map((one) => one.querySelector("input"))
    .filter((box) => box?.checked)
    .map((box) => Number(box?.value));

customElements.define("quality-form", QualityForm);
