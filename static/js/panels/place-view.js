// Element <place-view>: places the robot on the map: press its position, drag to its heading.

import * as maps from "../net/maps-api.js";
import { CanvasHand } from "../ui/canvas-hand.js";
import { icon, make, numberField, onSubmit, write } from "../ui/element.js";
import { FloorView, headingOf } from "../ui/floor-view.js";
import { degrees } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { drawPlace } from "../ui/place-drawing.js";
import { t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { View } from "../net/session.js" */
/** @import { Point } from "../ui/floor-view.js" */
/** @import { Placed } from "../ui/place-drawing.js" */

const MARGIN = 34; // [px] around the map
const DRAG = 14; // [px] from which a drag says a heading
const SCAN_MS = 1000;

class PlaceView extends Panel {
  #canvas = make("canvas.place-floor", { "aria-hidden": "true" });
  #words = make("p.place-words");
  #trouble = new TroubleLine();
  #fields = { x: field("x", "m"), y: field("y", "m"), heading: field("heading", "°") };
  #put = make("button.button.primary", { type: "submit" }, icon("here"), make("span", t("place-view.it_is_here")));
  #leave = make("button.button", { onclick: () => this.#close() }, t("place-view.cancel"));
  #form = make(
    "form.row.place-form",
    this.#fields.x.row,
    this.#fields.y.row,
    this.#fields.heading.row,
    make("span.spring"),
    this.#leave,
    this.#put,
  );
  /** @type {maps.Plan | null} */
  #plan = null;
  /** @type {Array<[number, number]>} */
  #scan = [];
  #scanAt = -Infinity;
  #view = new FloorView(50, 0, 0);
  #moved = false; // by the operator: kept when the window changes
  /** @type {Placed | null} */
  #placed = null;
  /** @type {Point | null} */
  #pressed = null; // where the newest press was
  #wasLost = false;
  /** @type {View | null} */
  #shown = null;

  /** @override */
  build() {
    this.hidden = true;
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("place-view.where_is_the_robot"));
    this.append(
      make("div.place-head", make("h2.card-title", t("place-view.where_is_the_robot")), this.#words),
      this.#canvas,
      this.#trouble.element,
      this.#form,
    );
    addEventListener("place-robot", () => void this.#open());
    onSubmit(this.#form, () => void this.#tell());
    for (const { box } of Object.values(this.#fields)) box.addEventListener("input", () => this.#typed());
    new CanvasHand(this.#canvas, {
      move: (about, times, shift) => {
        this.#moved = true;
        this.#view = this.#view.changed(about, times, shift);
        this.#draw();
      },
      draw: (at) => {
        this.#pressed = at;
        this.#place({ ...this.#view.floor(at), heading: null });
        return true;
      },
      drawn: (at) => {
        const heading = headingOf(/** @type {Point} */ (this.#pressed), at, DRAG);
        if (this.#placed) this.#place({ ...this.#placed, heading });
      },
    });
    new ResizeObserver(() => this.#fit()).observe(this.#canvas);
  }

  /** @override @param {View} view */
  show(view) {
    this.#shown = view;
    if (this.hidden || !view.state) return;
    const { lost } = view.state.floor;
    if (this.#wasLost && lost === null) {
      this.#close();
      this.session.announce(t("place-view.the_robot_is_localized"));
      return;
    }
    this.#wasLost = lost !== null;
    this.#put.disabled = !view.up || this.#placed === null;
    if (performance.now() - this.#scanAt > SCAN_MS) void this.#look();
  }

  async #open() {
    const { state } = this.session;
    if (!this.hidden || !state) return;
    this.hidden = false;
    this.dispatchEvent(new CustomEvent("open-view", { detail: "map", bubbles: true }));
    this.#wasLost = state.floor.lost !== null;
    this.#placed = null;
    this.#moved = false;
    this.#trouble.say("");
    this.#write();
    this.#leave.focus();
    await this.#trouble.attempt(async () => {
      this.#plan = await maps.plan();
      this.#fit();
    });
  }

  #close() {
    this.hidden = true;
    this.#plan = null;
  }

  async #tell() {
    const placed = this.#placed;
    if (!placed) return;
    const where = { x_m: placed.x, y_m: placed.y, heading_rad: placed.heading, force: !this.#wasLost };
    await this.#trouble.attempt(async () => {
      await maps.here(where);
      this.session.announce(t("place-view.the_robot_looks_around_the_place"));
      this.#close();
    });
  }

  async #look() {
    this.#scanAt = performance.now();
    this.#scan = await maps.scan().then(
      ({ points_m: points }) => points,
      () => this.#scan,
    );
    this.#draw();
  }

  // operator input

  #typed() {
    const { x, y, heading } = this.#fields;
    const [east, north, turned] = [x, y, heading].map(({ box }) => box.valueAsNumber);
    if (east === undefined || north === undefined || !Number.isFinite(east + north)) return;
    const known = turned !== undefined && Number.isFinite(turned);
    this.#placed = { x: east, y: north, heading: known ? (turned * Math.PI) / 180 : null };
    this.#write();
    this.#draw();
  }

  /** @param {Placed} placed */
  #place(placed) {
    this.#placed = placed;
    const { x, y, heading } = this.#fields;
    x.box.value = placed.x.toFixed(2);
    y.box.value = placed.y.toFixed(2);
    heading.box.value = placed.heading === null ? "" : ((placed.heading * 180) / Math.PI).toFixed(0);
    this.#write();
    this.#draw();
  }

  #write() {
    const placed = this.#placed;
    if (placed === null) write(this.#words, t("place-view.press_its_position_and_drag_to"));
    else if (placed.heading === null) write(this.#words, t("place-view.drag_to_give_its_heading_or"));
    else write(this.#words, t("place-view.heading_degrees_the_dots_are_the", { degrees: degrees(placed.heading) }));
    this.#put.disabled = placed === null || this.#shown?.up === false;
  }

  // drawing

  #fit() {
    if (this.hidden || !this.#plan) return;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    if (!this.#moved) this.#view = FloorView.fitted(this.#plan.extent, width, height, MARGIN);
    this.#draw();
  }

  #draw() {
    if (this.hidden || !this.#plan) return;
    const { state, hello } = this.#shown ?? {};
    drawPlace(this.#canvas, this.#view, {
      plan: this.#plan,
      scan: this.#scan,
      placed: this.#placed,
      candidates: state?.floor.lost?.candidates ?? [],
      radius: hello?.robot.radius_m ?? 0.1,
    });
  }
}

/**
 * @param {string} name
 * @param {string} unit
 */
function field(name, unit) {
  const says = t("place-view.name_in_value", { name, value: unit === "°" ? "degrees" : "metres" });
  const box = numberField(says, { step: "any" });
  const row = make("label.place-field", make("span.note", name), box, make("span.note", unit));
  return { row, box };
}

customElements.define("place-view", PlaceView);
