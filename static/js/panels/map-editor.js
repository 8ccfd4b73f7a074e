// Element <map-editor>: erase and draw cells, crop and turn the map, name rooms; each edit can be taken back.

import * as api from "../net/edits-api.js";
import { addRoom, marksOf } from "../net/marks-api.js";
import { CanvasHand, stepped } from "../ui/canvas-hand.js";
import { make, mark, nameField, numberField, onSubmit, write } from "../ui/element.js";
import { apart } from "../ui/flat-drawing.js";
import { FloorView } from "../ui/floor-view.js";
import { day } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { colourOf, drawCross, trace } from "../ui/place-drawing.js";
import { refill } from "../ui/press.js";
import { t } from "../ui/texts.js";
import { onTheme } from "../ui/theme.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { EditRow } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */
/** @import { Point } from "../ui/floor-view.js" */
/** @typedef {"free" | "occupied" | "unknown" | "crop" | "room"} Tool */

const MARGIN = 16; // [px]
const STEPS_M = /** @type {const} */ ([0.1, 0.5]); // of the keyboard's cursor, and with Shift
const ZOOM = 1.4;
const APART_PX = 3; // between two points of a stroke
const BRUSHES_CM = [5, 10, 20, 40, 80];
const REFRESH_MS = 3000;
/** @type {ReadonlyArray<[Tool, string, string]>} */
const TOOLS = [
  ["free", t("map-editor.erase"), t("map-editor.brush_help")],
  ["occupied", t("map-editor.draw_walls"), t("map-editor.brush_help")],
  ["unknown", t("map-editor.make_unknown"), t("map-editor.brush_help")],
  ["crop", t("map-editor.crop"), t("map-editor.crop_help")],
  ["room", t("map-editor.name_a_room"), t("map-editor.room_help")],
];
/** @type {Readonly<Record<api.EditKind, string>>} */
const DONE = {
  free: t("map-editor.erased"),
  occupied: t("map-editor.drawn"),
  unknown: t("map-editor.made_unknown"),
  crop: t("map-editor.cropped"),
  turn: t("map-editor.turned"),
};

class MapEditor extends Panel {
  #canvas = make("canvas.map-edit-floor.scrolls", {
    tabindex: "0",
    role: "application",
    "aria-label": t("map-editor.map_to_edit_the_arrow_keys"),
  });
  #help = make("p.note");
  #said = make("p.visually-hidden", { role: "status" });
  #trouble = new TroubleLine();
  /** @type {Map<Tool, HTMLButtonElement>} */
  #tools = new Map();
  #brush = make("select.field-box.map-edit-brush", { "aria-label": t("map-editor.width_of_the_brush") });
  #undo = make(
    "button.button.small",
    { onclick: () => void this.#try(() => api.takeBack("undo")) },
    t("map-editor.undo"),
  );
  #redo = make(
    "button.button.small",
    { onclick: () => void this.#try(() => api.takeBack("redo")) },
    t("map-editor.redo"),
  );
  #degrees = numberField(t("map-editor.degrees"), { min: -180, max: 180, step: 0.5, value: 1 }, "place-degrees");
  #turn = make("button.button", t("map-editor.turn"));
  #name = nameField(t("map-editor.name_of_the_room"));
  #done = make("button.button.primary", { type: "submit" }, t("place-sheet.save"));
  #cancel = make("button.button", { onclick: () => this.#take(this.#tool) }, t("place-view.cancel"));
  #room = make("form.row.map-edit-row", { hidden: true }, this.#name, this.#cancel, this.#done);
  #list = make("ol.places.map-edit-list", { reversed: true, "aria-label": t("map-editor.edits") });
  #bar = make("div.row.map-edit-row", { role: "toolbar", "aria-label": t("map-editor.edit_the_map") });
  /** @type {Tool} */
  #tool = "free";
  /** @type {api.MapPicture | null} */
  #picture = null;
  /** @type {OffscreenCanvas | null} its cells as they are drawn; null: to be painted */
  #cells = null;
  /** @type {FloorView | null} */
  #view = null;
  /** @type {Point[]} [m] of the stroke or the corners under way */
  #points = [];
  #pen = false; // the arrow keys draw
  /** @type {Point | null} */
  #cursor = null;
  #askedAt = -Infinity; // [ms]
  #revision = -1;
  /** @type {Promise<void>} what was drawn waits for what was drawn before: no stroke is lost */
  #edits = Promise.resolve();
  #operates = false;

  /** @override */
  build() {
    for (const [tool, name, says] of TOOLS) {
      const button = make("button.button.small", { title: says, onclick: () => this.#take(tool) }, name);
      this.#tools.set(tool, button);
    }
    this.#brush.append(
      ...BRUSHES_CM.map((cm) => make("option", { value: String(cm), selected: cm === 20 }, t("map-editor.cm", { cm }))),
    );
    const near = make("button.button.small", { "aria-label": t("map-editor.larger") }, "+");
    const far = make("button.button.small", { "aria-label": t("map-editor.smaller") }, "−");
    const whole = make("button.button.small", { onclick: () => this.#whole() }, t("map-editor.whole_map"));
    near.addEventListener("click", () => this.#zoom(ZOOM));
    far.addEventListener("click", () => this.#zoom(1 / ZOOM));
    this.#bar.append(...this.#tools.values(), this.#brush, this.#undo, this.#redo);
    this.append(
      make("h3", t("map-editor.edit_the_map")),
      this.#bar,
      this.#help,
      this.#trouble.element,
      this.#room,
      make("div.map-edit-place", this.#canvas, make("div.map-edit-zoom", near, far, whole)),
      make("div.row.map-edit-row", this.#degrees, "°", this.#turn),
      this.#list,
      this.#said,
    );
    this.#turn.addEventListener("click", () => {
      const angle = ((this.#degrees.valueAsNumber || 0) * Math.PI) / 180;
      void this.#try(() => api.edit({ kind: "turn", angle_rad: angle })).then(() => this.#whole());
    });
    onSubmit(this.#room, () => void this.#keepRoom());
    new CanvasHand(this.#canvas, {
      move: (about, times, shift) => {
        this.#view = this.#view?.changed(about, times, shift) ?? null;
        this.#draw();
      },
      press: (at) => this.#operates && this.#tool === "room" && this.#view && this.#corner(this.#view.floor(at)),
      draw: (at) => this.#begin(at),
      drawn: (at) => this.#go(at),
      ended: () => this.#points.length && void this.#finish(),
      left: () => this.#begin(null),
      scrolls: true,
    });
    this.#canvas.addEventListener("keydown", (event) => this.#key(event));
    new ResizeObserver(() => this.#whole()).observe(this.#canvas);
    marksOf(this.session).addEventListener("change", () => void this.#read());
    onTheme(() =>
      requestAnimationFrame(() => {
        this.#cells = null;
        this.#draw();
      }),
    );
    this.#take("free");
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state || this.offsetParent === null) return;
    this.#operates = up && hello !== null && hello.you.role !== "viewer";
    for (const button of this.querySelectorAll("button")) button.disabled = !this.#operates;
    const { marks } = state.map;
    const now = performance.now();
    if (!up || this.#points.length || (marks === this.#revision && now - this.#askedAt < REFRESH_MS)) return;
    [this.#revision, this.#askedAt] = [marks, now];
    void this.#read();
  }

  async #read() {
    const [picture, list] = await Promise.all([api.picture(), api.edits()]).catch(() => [null, null]);
    if (!picture || !list) return;
    [this.#picture, this.#cells] = [picture, null];
    this.#undo.hidden = !list.edits.some(({ holds }) => holds);
    this.#redo.hidden = list.edits.every(({ holds }) => holds);
    const newest = list.edits.findLast(({ holds }) => holds)?.id ?? 0;
    refill(this.#list, ...[...list.edits].reverse().map((row) => this.#row(row, newest)));
    this.#draw();
  }

  /** @param {EditRow} row @param {number} newest number of the newest that holds */
  #row({ id, kind, by, at_s: at, holds }, newest) {
    const words = t("map-editor.what_by_at", { what: DONE[kind], by, at: day(at) });
    const act = make(
      "button.button.small",
      { type: "button", "aria-label": `${holds ? t("map-editor.undo") : t("map-editor.redo")} ${id}` },
      holds ? t("map-editor.undo") : t("map-editor.redo"),
    );
    act.addEventListener("click", () => void this.#try(() => api.takeBack(holds ? "undo" : "redo", id)));
    const back = make(
      "button.button.small",
      { "aria-label": t("map-editor.undo_all_after_id", { id }), onclick: () => void this.#try(() => api.backTo(id)) },
      t("map-editor.undo_later_ones"),
    );
    const body = make("div.place-body", make("p", { class: holds ? "" : "note" }, words));
    return make("li.row.place", { "data-holds": String(holds), value: id }, body, holds && id < newest && back, act);
  }

  /** @param {Tool} tool */
  #take(tool) {
    this.#tool = tool;
    [this.#points, this.#pen] = [[], false];
    for (const [one, button] of this.#tools) mark(button, "aria-pressed", String(one === tool));
    this.#brush.hidden = tool === "crop" || tool === "room";
    this.#room.hidden = true;
    write(this.#help, TOOLS.find(([one]) => one === tool)?.[2] ?? "");
    this.#trouble.say("");
    this.#draw();
  }

  // fingers and mouse

  /** Begin a stroke; corners of a room are pressed. @param {Point | null} at [px]; null: it was none */
  #begin(at) {
    if (!this.#operates || !this.#view || this.#tool === "room") return false;
    this.#points = at ? [this.#view.floor(at)] : [];
    this.#draw();
    return true;
  }

  /** @param {Point} at [px] where the stroke goes on */
  #go(at) {
    const [first, last] = [this.#points[0], this.#points.at(-1)];
    if (!this.#view || !first || !last || apart(this.#view.drawn(last), at) < APART_PX) return;
    const point = this.#view.floor(at);
    if (this.#tool === "crop") this.#points = [first, point];
    else this.#points.push(point);
    this.#draw();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || !this.#view) return;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const to = stepped(event, this.#cursor ?? this.#view.floor({ x: width / 2, y: height / 2 }), STEPS_M);
    if (to) {
      this.#cursor = to;
      if (this.#pen) this.#points.push(to);
      const at = this.#view.drawn(to);
      if (at.x < 0 || at.y < 0 || at.x > width || at.y > height) this.#view = this.#view.centred(to, width, height);
      write(this.#said, `x ${to.x.toFixed(2)}, y ${to.y.toFixed(2)}`);
    } else if (event.key === "Enter" && this.#cursor && this.#operates) this.#enter(this.#cursor);
    else if (event.key === "+" || event.key === "-") this.#zoom(event.key === "+" ? ZOOM : 1 / ZOOM);
    else if (event.key === "Backspace") this.#points.pop();
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.#draw();
  }

  /** @param {Point} at [m] */
  #enter(at) {
    if (this.#tool === "room") this.#corner(at);
    else if (this.#tool === "crop") {
      this.#points.push(at);
      if (this.#points.length === 2) void this.#finish();
    } else if (this.#pen) {
      this.#pen = false;
      void this.#finish();
    } else [this.#pen, this.#points] = [true, [at]];
  }

  // edits

  /** @param {Point} at [m] */
  #corner(at) {
    this.#points.push(at);
    this.#room.hidden = this.#points.length < 3;
    this.#draw();
  }

  async #finish() {
    const kind = /** @type {"free" | "occupied" | "unknown" | "crop"} */ (this.#tool);
    const drawn = this.#points;
    const points = kind === "crop" ? rectangle(drawn) : drawn;
    if (kind === "crop" && points.length < 4) {
      this.#take("crop");
      return;
    }
    const at = thinned(points).map(({ x, y }) => /** @type {[number, number]} */ ([x, y]));
    const width = kind === "crop" ? 0 : Number(this.#brush.value) / 100;
    await this.#try(() => api.edit({ kind, points_m: at, width_m: width }));
    if (this.#points === drawn) this.#points = []; // else the next stroke has begun meanwhile
    this.#draw();
  }

  async #keepRoom() {
    const name = this.#name.value.trim();
    if (!name) {
      this.#trouble.say(t("place-sheet.a_name_is_missing"));
      return;
    }
    const outline = this.#points.map(({ x, y }) => /** @type {[number, number]} */ ([x, y]));
    await this.#try(async () => {
      const kept = await addRoom(name, outline);
      this.session.announce(t("map-editor.the_room_name_is_kept", { name: kept.name }));
      this.#name.value = "";
      this.#take("room");
    });
  }

  /** @param {() => Promise<unknown>} act */
  #try(act) {
    this.#edits = this.#edits.then(async () => {
      if (await this.#trouble.attempt(act)) await this.#read();
    });
    return this.#edits;
  }

  // drawing

  /** @param {number} times */
  #zoom(times) {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    this.#view = this.#view?.changed({ x: width / 2, y: height / 2 }, times) ?? null;
    this.#draw();
  }

  #whole() {
    this.#view = null;
    this.#draw();
  }

  #draw() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const picture = this.#picture;
    const context = this.#canvas.getContext("2d");
    if (!context || !picture || !width) return;
    const { image, cell, left, bottom } = picture;
    const extent = { left, bottom, right: left + cell * image.width, top: bottom + cell * image.height };
    this.#view ??= FloorView.fitted(extent, width, height, MARGIN);
    const fine = devicePixelRatio || 1;
    [this.#canvas.width, this.#canvas.height] = [Math.round(fine * width), Math.round(fine * height)];
    context.scale(fine, fine);
    context.imageSmoothingEnabled = false;
    const corner = this.#view.drawn({ x: extent.left, y: extent.top });
    const scale = this.#view.scale * cell;
    this.#cells ??= this.#painted(image);
    context.drawImage(this.#cells, corner.x, corner.y, scale * image.width, scale * image.height);
    context.strokeStyle = context.fillStyle = colourOf(this.#canvas, "accent");
    context.lineJoin = context.lineCap = "round";
    for (const { outline_m: corners = [] } of marksOf(this.session).places)
      this.#line(
        context,
        corners.map(([x, y]) => ({ x, y })),
        2,
        true,
      ); // prettier-ignore
    const points = this.#tool === "crop" ? rectangle(this.#points) : this.#points;
    const thin = this.#brush.hidden === true;
    const brush = thin ? 2 : Math.max(2, (this.#view.scale * Number(this.#brush.value)) / 100);
    context.globalAlpha = thin ? 1 : 0.5;
    this.#line(context, points, brush, thin);
    context.globalAlpha = 1;
    if (this.#cursor && document.activeElement === this.#canvas) {
      context.lineWidth = 2;
      drawCross(context, this.#view.drawn(this.#cursor), 10);
    }
  }

  /** Floor and walls in the colours of the theme, what is unknown clear. @param {ImageBitmap} image free 254, occupied 0, unknown 205 */
  #painted({ width, height }) {
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d");
    if (!context || !this.#picture) return canvas;
    context.drawImage(this.#picture.image, 0, 0);
    const cells = context.getImageData(0, 0, width, height);
    const [floor = 0, wall = 0] = ["plan-floor", "plan-wall"].map((name) => {
      const [red = 0, green = 0, blue = 0] = colourOf(this.#canvas, name).match(/\d+/g)?.map(Number) ?? [];
      return 0xff000000 + (blue << 16) + (green << 8) + red;
    });
    new Uint32Array(cells.data.buffer).forEach((cell, at, all) => {
      const grey = cell & 0xff;
      all[at] = grey > 230 ? floor : grey < 100 ? wall : 0;
    });
    context.putImageData(cells, 0, 0);
    return canvas;
  }

  /** @param {CanvasRenderingContext2D} context @param {Point[]} points [m] @param {number} wide [px] @param {boolean} closed */
  #line(context, points, wide, closed) {
    const [first, ...rest] = points.map((point) => /** @type {FloorView} */ (this.#view).drawn(point));
    if (!first) return;
    const alone = { x: first.x + 0.1, y: first.y }; // a single point is a dot
    context.lineWidth = wide;
    context.beginPath();
    trace(context, [first, ...(rest.length || closed ? rest : [alone])], closed);
    context.stroke();
  }
}

/** @param {Point[]} points two opposite corners @returns {Point[]} all four */
function rectangle([one, other]) {
  if (!one || !other || Math.abs(one.x - other.x) < 0.1 || Math.abs(one.y - other.y) < 0.1) return [];
  return [one, { x: other.x, y: one.y }, other, { x: one.x, y: other.y }];
}

/** @param {Point[]} points @returns {Point[]} at most a thousand of them */
function thinned(points) {
  const every = Math.ceil(points.length / 900);
  return points.filter((_, number) => number % every === 0 || number === points.length - 1);
}

customElements.define("map-editor", MapEditor);
