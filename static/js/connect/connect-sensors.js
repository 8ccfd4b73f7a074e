// Element <connect-sensors>: where the sensors are mounted, the robot's size and limits; all to be confirmed or entered.

import { isNew, make, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { ConnectionModel, Origin } from "./connection-model.js" */
/** @import { FoundLimit as Limit } from "../net/rest.js" */
/** @typedef {{key: string, name: string, unit: "m" | "°" | "ms" | "m/s" | "°/s", value: number, known: boolean}} Field a value in the unit of the wire */
/** @typedef {{kind: "lasers" | "cameras" | "microphones" | "limits", name: string, field: Field, input: HTMLInputElement}} Entry */

const SCALE = { m: 1, "m/s": 1, ms: 1000, "°": 180 / Math.PI, "°/s": 180 / Math.PI };
const OFFSET = "time_offset_s";
/** @type {Record<Origin, string>} */
const ORIGINS = {
  robot: t("connect-sensors.mounting_as_the_robot_says_it"),
  file: t("connect-sensors.mounting_from_the_robot_file"),
  assumed: t("connect-sensors.its_mounting_is_not_known_enter"),
};
/** @type {Record<Limit["name"], {key: string, name: string, unit: Field["unit"]}>} */
const LIMITS = {
  radius: { key: "radius_m", name: t("connect-sensors.radius"), unit: "m" },
  wheelbase: { key: "wheelbase_m", name: t("connect-sensors.wheelbase"), unit: "m" },
  cruise: { key: "cruise_m_s", name: t("connect-sensors.cruise"), unit: "m/s" },
  max_speed: { key: "max_speed_m_s", name: t("connect-sensors.highest_speed"), unit: "m/s" },
  max_turn_rate: { key: "max_turn_rate_rad_s", name: t("connect-sensors.highest_turn_rate"), unit: "°/s" },
};

/** @extends {PagePanel<ConnectionModel>} */
export class ConnectSensors extends PagePanel {
  #body = make("div.connect-mounts");
  /** @type {Entry[]} */
  #entries = [];
  /** @type {Map<string, HTMLButtonElement>} by laser: take its estimated time offset */
  #estimates = new Map();

  /** @override */
  build() {
    this.append(
      make(
        "section.card.page-card",
        { "aria-label": t("connect-sensors.body_and_mountings") },
        make("h2", t("connect-sensors.body_and_mountings")),
        make("p.note", t("connect-sensors.seen_from_the_middle_between_the")),
        this.#body,
      ),
    );
    this.hidden = true;
  }

  /** @override @param {import("../net/session.js").View} view */
  show({ state }) {
    for (const [laser, button] of this.#estimates) {
      const timings = this.model.own ? (state?.robot.timings ?? []) : [];
      const timing = timings.find((one) => one.laser === laser);
      button.hidden = !timing || timing.applied_s === 0;
      if (!timing) continue;
      const value = fixed(1000 * timing.offset_s, 0);
      write(button, t("connect-sensors.use_the_estimated_value_ms", { value }));
      button.value = String(Math.round(1000 * timing.offset_s));
    }
  }

  /** @override */
  draw() {
    const found = this.model.found;
    this.hidden = !found || Boolean(this.model.whyNot);
    if (!found) return;
    if (!isNew(this, found.url, found.limits, found.lasers, found.cameras, found.microphones, this.model.may)) return;
    this.#entries = [];
    this.#estimates.clear();
    this.#body.replaceChildren(
      this.#group(
        "limits",
        "",
        t("connect-sensors.body"),
        t("connect-sensors.left_empty_the_value_in_grey"),
        false,
        found.limits.map(limit),
      ),
      ...found.lasers.map((one) => {
        const says = t("connect-sensors.beams_beams_fixed_m_fixed2_hz", {
          beams: one.beams,
          fixed: fixed(one.range_max_m, 1),
          fixed2: fixed(one.rate_hz, 0),
        });
        return this.#mount("lasers", t("connect-sensors.laser"), one, says, [
          ...flat(one),
          {
            key: OFFSET,
            name: t("connect-sensors.add_to_stamps"),
            unit: "ms",
            value: one.time_offset_s,
            known: one.time_offset_s !== 0,
          },
        ]);
      }),
      ...found.cameras.map((one) =>
        this.#mount(
          "cameras",
          t("connect-sensors.camera"),
          one,
          `${one.width} × ${one.height}, ${fixed(one.rate_hz, 0)} Hz`,
          camera(one),
        ),
      ),
      ...found.microphones.map((one) =>
        this.#mount(
          "microphones",
          t("connect-sensors.microphones"),
          one,
          t("connect-sensors.microphones_microphones", { microphones: one.microphones }),
          flat(one),
        ),
      ),
    );
  }

  /**
   * @param {Entry["kind"]} kind @param {string} word
   * @param {{name: string, mounting: Origin}} sensor @param {string} says @param {Field[]} fields
   */
  #mount(kind, word, sensor, says, fields) {
    const title = sensor.name === word.toLowerCase() ? word : `${word} ${sensor.name}`;
    const missing = sensor.mounting === "assumed";
    const roles = this.model.found?.parts.flatMap(({ findings }) => findings.roles) ?? [];
    const tf = ["frames", "description"]
      .flatMap((name) => roles.filter(({ role }) => role === name).flatMap(({ used }) => used))
      .map(({ topic }) => topic)
      .join(" or ");
    const origin =
      sensor.mounting === "robot" && tf && kind !== "microphones"
        ? t("connect-sensors.mounting_from_tf", { tf })
        : ORIGINS[sensor.mounting];
    const text = `${says} · ${origin}`;
    return this.#group(kind, sensor.name, title, text, missing, fields);
  }

  /**
   * @param {Entry["kind"]} kind @param {string} name @param {string} title @param {string} says
   * @param {boolean} missing @param {Field[]} fields
   */
  #group(kind, name, title, says, missing, fields) {
    return make(
      "fieldset.connect-mount",
      make("legend", title),
      make("p.note", { "data-tone": missing ? "stale" : null }, says),
      make("div.connect-fields", ...fields.map((field) => this.#field(kind, name, title, field))),
      kind === "lasers" && this.#estimate(name),
    );
  }

  /** @param {string} laser */
  #estimate(laser) {
    const button = make("button.button.connect-estimate", { hidden: true });
    button.addEventListener("click", () => {
      const entry = this.#entries.find((one) => one.name === laser && one.field.key === OFFSET);
      if (entry) entry.input.value = button.value;
    });
    this.#estimates.set(laser, button);
    return button;
  }

  /** @param {Entry["kind"]} kind @param {string} name @param {string} title @param {Field} field */
  #field(kind, name, title, field) {
    const shown = shownOf(field);
    const input = make("input.field-box.connect-input", {
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      "aria-label": t("connect-sensors.title_name_in_unit", { title, name: field.name, unit: field.unit }),
      value: field.known ? shown : "",
      placeholder: shown,
      disabled: !this.model.may,
    });
    const trouble = make("span.visually-hidden");
    input.addEventListener("input", () => {
      const bad = Number.isNaN(read(input, field) ?? 0);
      input.setAttribute("aria-invalid", String(bad));
      write(trouble, bad ? t("connect-sensors.this_is_not_a_number") : "");
    });
    this.#entries.push({ kind, name, field, input });
    return make(
      "label.connect-field",
      make("span", field.name),
      make("span.connect-unit", input, make("span", field.unit)),
      trouble,
    );
  }

  /**
   * The values as they stand, for the robot file; null when one of them is no number.
   * @returns {Record<string, unknown> | null}
   */
  get confirmed() {
    /** @type {Record<string, any>} */
    const body = { lasers: {}, cameras: {}, microphones: {} };
    for (const { kind, name, field, input } of this.#entries) {
      const value = read(input, field);
      if (Number.isNaN(value ?? 0)) {
        input.focus();
        return null;
      }
      if (value === null) continue;
      if (kind === "limits") body[field.key] = value;
      else body[kind][name] = { ...body[kind][name], [field.key]: value };
    }
    this.#complete(body);
    return body;
  }

  /** Where one figure of a mounting was entered, the empty ones are the grey ones. @param {Record<string, any>} body */
  #complete(body) {
    for (const { kind, name, field } of this.#entries) {
      const place = kind === "limits" ? null : body[kind][name];
      const keys = Object.keys(place ?? {}).filter((key) => key !== OFFSET);
      if (keys.length > 0 && field.key !== OFFSET) place[field.key] ??= field.value;
    }
  }
}

/** @param {Limit} one @returns {Field} */
const limit = (one) => ({ ...LIMITS[one.name], value: one.value, known: one.origin !== "assumed" });

/** @param {{x_m: number, y_m: number, heading_rad: number, height_m: number, mounting: Origin}} one @returns {Field[]} */
function flat(one) {
  const known = one.mounting !== "assumed";
  return [
    { key: "x_m", name: "x", unit: "m", value: one.x_m, known },
    { key: "y_m", name: "y", unit: "m", value: one.y_m, known },
    { key: "heading_rad", name: "heading", unit: "°", value: one.heading_rad, known },
    { key: "height_m", name: "height", unit: "m", value: one.height_m, known },
  ];
}

/** @param {import("../net/rest.js").FoundCamera} one @returns {Field[]} */
function camera(one) {
  const known = one.mounting !== "assumed";
  return [
    { key: "x_m", name: "x", unit: "m", value: one.x_m, known },
    { key: "y_m", name: "y", unit: "m", value: one.y_m, known },
    { key: "z_m", name: "height", unit: "m", value: one.z_m, known },
    { key: "yaw_rad", name: t("connect-sensors.yaw_left"), unit: "°", value: one.yaw_rad, known },
    { key: "pitch_rad", name: t("connect-sensors.pitch_down"), unit: "°", value: one.pitch_rad, known },
    { key: "roll_rad", name: "roll", unit: "°", value: one.roll_rad, known },
  ];
}

/** @param {Field} field */
function shownOf({ value, unit }) {
  const digits = unit.startsWith("°") ? 100 : 10_000;
  return String(Math.round(value * SCALE[unit] * digits) / digits);
}

/**
 * The entered value in the unit of the wire; null when empty, NaN when it is no number. What was not changed is exact.
 * @param {HTMLInputElement} input @param {Field} field
 */
function read(input, field) {
  const text = input.value.trim().replace(",", ".").replace("−", "-");
  if (text === "") return null;
  if (text === shownOf(field)) return field.value;
  const value = Number(text) / SCALE[field.unit];
  return Number.isFinite(value) ? value : NaN;
}

customElements.define("connect-sensors", ConnectSensors);
