// Element <flat-map>: the map from above. Press it to go there; it needs no WebGL and little else.

import * as maps from "../net/maps-api.js";
import { marksOf } from "../net/marks-api.js";
import { CanvasHand, stepped } from "../ui/canvas-hand.js";
import { watchClearArea, watchLowerEdge } from "../ui/clear-area.js";
import { action, iconButton, make, mark, write } from "../ui/element.js";
import { apart, drawFlat, drawMoving, PIN_PX } from "../ui/flat-drawing.js";
import { FlatGround } from "../ui/flat-ground.js";
import { FloorView, seenFrom } from "../ui/floor-view.js";
import { fixed, metres } from "../ui/format.js";
import { goTo } from "../ui/go-to.js";
import { remember, remembered } from "../ui/local-storage.js";
import { mapShown, onMapKind, whyFlat } from "../ui/map-choice.js";
import { mapInWords } from "../ui/map-text.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { PoseMotion } from "../ui/pose-motion.js";
import { chainOf, LastVoice } from "../ui/sensed.js";
import { t } from "../ui/texts.js";
import { onTheme } from "../ui/theme.js";
import { ToGo } from "../ui/to-go.js";
import { askName } from "./place-list.js";

/** @import { State } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */
/** @import { Layer } from "../ui/flat-drawing.js" */
/** @import { Point } from "../ui/floor-view.js" */

const SAID_MS = 20_000; // for which it is said why the map is flat; the switch beside stays
const MARGIN = 36; // [px] around the whole map at most
const [WIDE, WIDE_SHARE] = [1.5, 0.06]; // of a view that much wider than high the margin is that share of the height
const SMALL_MARGIN = 14; // of a docked one
const STATUS = 40; // [px] that it takes below at least …
const STATUS_SHARE = 0.35; // … and at most, of what no panel covers
const STEPS_M = /** @type {const} */ ([0.25, 1]); // of the keyboard's cursor, and with Shift
const ZOOM = 1.4;
const IDLE_SHARE = 4; // times the duration of a drawing pass between two
const MOVING = 0.01; // [m/s], [rad/s]
const SCAN_MS = { moving: 250, standing: 1000 };
const PLAN_MS = { moving: 1500, standing: 10_000 };
const WORDS_MS = 2000;
const REACH = 24; // [px] around a person in which a press is for them
/** @type {ReadonlyArray<readonly [Layer, string, string]>} */
const LAYERS = [
  ["scan", t("flat-map.laser"), t("flat-map.the_newest_sweep")],
  ["trail", t("flat-map.trail"), t("flat-map.where_the_robot_was_within")],
  ["way", t("flat-map.way_and_goal"), t("flat-map.where_the_robot_is_going_and")],
  ["places", t("flat-map.places"), t("flat-map.named_places_a_press_goes_there")],
  ["zones", t("flat-map.zones"), t("flat-map.keep_out_of_the_red_slow_in")],
  ["people", t("flat-map.person"), t("flat-map.whom_the_running_command_looks_at")],
  ["voice", t("flat-map.voice"), t("flat-map.direction_of_a_voice_two_standard")],
  ["landmarks", t("flat-map.corners"), t("flat-map.landmarks_the_ellipse_is_two_standard")],
  ["ghost", t("flat-map.wheels_alone"), t("flat-map.pose_by_dead_reckoning_alone")],
  ["grid", t("flat-map.metres"), t("flat-map.lines_a_metre_apart")],
];
const HIDDEN = "landmarks,ghost"; // at first

/** @typedef {"measure" | "name" | "zone"} Mode */
/** What presses do instead of sending the robot: its drawing, its name, and what is said when it begins. @type {ReadonlyArray<readonly [Mode, string, string, string]>} */
const MODES = [
  ["measure", "measure", t("flat-map.measure_a_distance"), t("flat-map.press_two_points")],
  ["name", "pin", t("flat-map.name_a_place"), t("flat-map.press_where_the_place_is")],
  ["zone", "zone", t("flat-map.draw_a_zone"), t("flat-map.press_its_corners")],
];

class FlatMap extends Panel {
  #text = make("p.visually-hidden", { id: "flat-map-words" });
  #said = make("p.visually-hidden", { role: "status" });
  #toGo = new ToGo();
  #canvas = make("canvas.flat-floor.scrolls", {
    tabindex: "0",
    role: "application",
    "aria-roledescription": t("flat-map.map"),
    "aria-label": t("flat-map.map_from_above_the_arrow_keys"),
    "aria-describedby": "flat-map-words",
  });
  #moving = make("canvas.flat-moving", { "aria-hidden": "true" });
  #whyWords = make("span");
  #whyAway = iconButton("close", t("notice-toasts.dismiss"), () => (this.#why.hidden = true), { look: "small" });
  #why = make("p.flat-why", { hidden: true }, this.#whyWords, this.#whyAway);
  #awaits = make("p.flat-awaits", t("flat-map.reading_the_map"));
  #follow = tool("here", t("flat-map.follow_the_robot"), () => this.#look(this.#looks === "robot" ? "free" : "robot"));
  #fit = tool("whole", t("flat-map.whole_map"), () => this.#look("whole"));
  /** @type {Map<Mode, HTMLButtonElement>} */
  #modes = new Map(MODES.map(([mode, drawing, says]) => [mode, tool(drawing, says, () => this.#switchTo(mode))]));
  #before = new Set(); // names of the places when the mode began
  #modeSays = make("span.flat-mode-says");
  #modeCount = make("span");
  #zoneDone = make("button.button.primary", { onclick: () => this.#closeZone() }, t("flat-map.done"));
  #zoneBack = action("undo", t("flat-map.last_corner_away"), () => this.#mark(this.#points.slice(0, -1)));
  #modeLeave = make("button.button", { onclick: () => this.#switchTo("") });
  #modeBar = make(
    "div.row.flat-mode-bar",
    { role: "group", "aria-label": t("flat-map.what_a_press_does"), hidden: true },
    make("p.flat-mode-words", this.#modeSays, " ", this.#modeCount),
    this.#zoneBack,
    this.#modeLeave,
    this.#zoneDone,
  );
  #layersButton = tool("layers", t("flat-map.layers"));
  #layersPanel = make("div.flat-layers", { role: "group", "aria-label": t("flat-map.layers") });
  #tools = make("div.flat-tools", { role: "toolbar", "aria-label": t("flat-map.map_2") });
  #view = new FloorView(60, 0, 0);
  /** @type {import("../ui/clear-area.js").Insets} by panels */
  #covered = { left: 0, top: 0, right: 0, bottom: 0 };
  /** @type {"whole" | "robot" | "free"} */
  #looks = "whole";
  #fitted = ""; // the canvas's size [px] for which the whole map was fitted
  #status = 0; // [px] that stands below
  /** @type {Set<Layer>} */
  #layers = new Set();
  /** @type {maps.Plan | null} */
  #plan = null;
  /** @type {Array<[number, number]>} */
  #scan = [];
  #scanned = 0; // [s] of the robot's clock
  #asked = { scan: -Infinity, plan: -Infinity, words: -Infinity }; // [ms]
  /** @type {Point | null} */
  #cursor = null;
  /** @type {Mode | ""} what presses do; "": they send the robot */
  #mode = "";
  /** @type {readonly Point[]} [m] that are measured, or corners of the zone that is drawn */
  #points = [];
  #drawn = ""; // what the newest drawing showed
  #motion = new PoseMotion();
  #ground = new FlatGround();
  #voice = new LastVoice();
  /** @type {{azimuth: number, sd: number} | null} */
  #heard = null;
  #glides = 0; // number of the frame that is asked for; 0: none
  #cost = 0; // [ms] of the newest drawing
  #revision = -1; // of the pose graph when the plan was asked for
  /** @type {readonly import("../net/rest.js").PersonInRoom[]} */
  #room = [];
  /** @type {View | null} */
  #shown = null;

  /** @override */
  build() {
    const hidden = new Set(remembered("map-hidden", HIDDEN).split(","));
    this.#layers = new Set(LAYERS.map(([layer]) => layer).filter((layer) => !hidden.has(layer)));
    this.#layersPanel.append(...LAYERS.map((row) => this.#switch(...row)));
    const layers = make("div.flat-layers-place", this.#layersButton, this.#layersPanel);
    this.#tools.append(this.#fit, this.#follow, ...this.#modes.values(), layers);
    this.append(
      this.#canvas,
      this.#moving,
      this.#awaits,
      this.#why,
      this.#tools,
      this.#modeBar,
      this.#text,
      this.#said,
    );
    popover(this.#layersButton, this.#layersPanel);
    this.session.on("restarted", () => {
      [this.#plan, this.#scan] = [null, []]; // of a robot that stood elsewhere
      this.#awaits.hidden = false;
      this.#motion.forget();
      this.#asked = { scan: -Infinity, plan: -Infinity, words: -Infinity };
    });
    marksOf(this.session).addEventListener("change", () => this.#draw());
    new CanvasHand(this.#canvas, {
      move: (about, times, shift) => {
        this.#looks = "free";
        this.#view = this.#view.changed(about, times, shift);
        this.#draw();
      },
      press: (at, event) => this.#press(at, event),
    });
    this.#canvas.addEventListener("keydown", (event) => this.#key(event));
    this.#canvas.addEventListener("blur", () => {
      this.#cursor = null;
      this.#draw();
    });
    addEventListener("room-people", (event) => {
      const people = /** @type {CustomEvent} */ (event).detail;
      if (JSON.stringify(people) !== JSON.stringify(this.#room)) this.#draw("", () => (this.#room = people));
    });
    watchClearArea(/** @type {HTMLElement} */ (this.parentElement), (insets) =>
      this.#draw("", () => (this.#covered = insets)),
    );
    watchLowerEdge((height) => this.#draw("", () => (this.#status = height)));
    onTheme(() => requestAnimationFrame(() => this.#draw()));
    let said = 0; // timer
    const chosen = () => {
      this.hidden = mapShown() !== "flat";
      this.#why.hidden = !whyFlat();
      write(this.#whyWords, whyFlat());
      clearTimeout(said);
      said = setTimeout(() => (this.#why.hidden = true), SAID_MS);
      this.#draw();
    };
    onMapKind(chosen);
    chosen();
  }

  /** @override @param {View} view */
  show(view) {
    this.#shown = view;
    const { state, up } = view;
    if (state) {
      const { x_m: x, y_m: y, heading_rad: heading } = state.pose;
      this.#heard = this.#voice.saw(state);
      this.#motion.saw(state.stamp_s, { x, y, heading }, performance.now() / 1000);
    }
    this.classList.toggle("is-old", !up);
    if (this.hidden || !state || document.hidden || this.#canvas.clientWidth === 0) return;
    this.#read(state, up);
    const { pose, path, goal, person, direction } = state;
    const near = [pose.x_m, pose.y_m, pose.heading_rad, person?.x_m ?? 0, person?.y_m ?? 0].map((value) =>
      value.toFixed(2),
    );
    const rest = [path.length, goal?.x_m, goal?.y_m, direction?.id, Math.round(direction?.age_s ?? 99), up];
    const moves = this.#layers.has("ghost") || state.playback?.comparison;
    const places = JSON.stringify(state.floor.lost?.candidates ?? []);
    const picture = [...near, ...rest, state.landmarks.length, places, moves && state.seq].join(" ");
    if (picture !== this.#drawn) this.#draw(picture);
    this.#glide();
  }

  /** Draw as often as the display shows, while the robot moves: at most a quarter of the time is drawing. */
  #glide() {
    if (this.#glides || this.hidden || document.hidden || matchMedia("(prefers-reduced-motion: reduce)").matches)
      return;
    const begun = performance.now();
    /** @param {number} now [ms] */
    const frame = (now) => {
      this.#glides = 0;
      const shown = this.#motion.at(now / 1000);
      if (!shown?.moving || this.hidden || document.hidden) return;
      if (now - begun < IDLE_SHARE * this.#cost) this.#glides = requestAnimationFrame(frame);
      else {
        if (this.#looks === "robot") this.#draw(this.#drawn);
        else this.#move();
        this.#glide();
      }
    };
    this.#glides = requestAnimationFrame(frame);
  }

  /** @param {State} state @param {boolean} up */
  #read({ velocity, floor }, up) {
    const now = performance.now();
    const moves = Math.abs(velocity.v_m_s) > MOVING || Math.abs(velocity.w_rad_s) > MOVING ? "moving" : "standing";
    if (up && now - this.#asked.scan > SCAN_MS[moves]) {
      this.#asked.scan = now;
      void maps.scan().then(
        ({ stamp_s: stamp, points_m: points }) =>
          this.#draw("", () => {
            [this.#scan, this.#scanned] = [points, stamp];
          }),
        () => undefined, // the link chip says that there is none
      );
    }
    if (up && (now - this.#asked.plan > PLAN_MS[moves] || this.#revision !== floor.graph_revision)) {
      this.#asked.plan = now;
      this.#revision = floor.graph_revision;
      const read = maps.plan().then(
        (plan) => this.#draw("", () => (this.#plan = plan)),
        () => undefined, // nothing is known yet
      );
      void read.then(() => (this.#awaits.hidden = true));
    }
    if (now - this.#asked.words > WORDS_MS) {
      this.#asked.words = now;
      const { state } = this.session;
      if (state) write(this.#text, mapInWords(state, this.#scan, this.#plan?.extent ?? null));
    }
  }

  // operator input

  /** @param {Point} at [px] @param {PointerEvent} event */
  #press(at, { clientX, clientY }) {
    const point = this.#view.floor(at);
    const pressed =
      this.#layers.has("people") &&
      this.#room.find(({ x_m: x, y_m: y }) => apart(at, this.#view.drawn({ x, y })) < REACH);
    if (this.#taken(point)) return;
    if (pressed) {
      const detail = { name: pressed.id, x: point.x, y: point.y, clientX, clientY };
      this.dispatchEvent(new CustomEvent("person-press", { detail, bubbles: true }));
    } else this.#goTo(at, point);
  }

  /** @param {Mode | ""} mode that begins; pressed again, it ends */
  #switchTo(mode) {
    this.#mode = this.#mode === mode ? "" : mode;
    this.#before = new Set(marksOf(this.session).places.map(({ name }) => name));
    const says = MODES.find(([one]) => one === this.#mode)?.[3];
    if (says) write(this.#said, says);
    this.#mark([]);
  }

  /** @param {readonly Point[]} points [m] */
  #mark(points) {
    this.#points = points;
    this.#draw();
  }

  /** True where a mode takes the press. @param {Point} point [m] */
  #taken(point) {
    const mode = this.#mode;
    if (mode === "name") askName(this, { at: point });
    else if (mode === "zone") {
      const [first, last] = this.#points.length > 2 ? [this.#points[0], this.#points.at(-1)] : []; // a double press ends it, too
      const ends = [first, last].some(
        (end) => end && apart(this.#view.drawn(end), this.#view.drawn(point)) < REACH / 2,
      );
      if (ends) this.#closeZone();
      else this.#mark([...this.#points, point]);
    } else if (mode === "measure") {
      this.#mark(this.#points.length === 1 ? [...this.#points, point] : [point]);
      const [one, other] = this.#points;
      if (one && other) write(this.#said, metres(apart(one, other)));
    }
    return mode !== "";
  }

  #closeZone() {
    const points = this.#points.map(({ x, y }) => [x, y]);
    this.#switchTo("");
    this.dispatchEvent(new CustomEvent("name-zone", { detail: { points }, bubbles: true, composed: true }));
  }

  /** @param {Point} at [px] @param {Point} point [m] the same */
  #goTo(at, point) {
    goTo(this, this.session, point, this.#layers.has("places") ? this.#placeAt(at) : null);
  }

  /** @param {Point} at [px] */
  #placeAt(at) {
    const { places } = marksOf(this.session);
    const press = { x: at.x, y: at.y + PIN_PX / 2 }; // its tip is on the place, and one presses its head
    return places.find(({ x_m: x, y_m: y }) => apart(press, this.#view.drawn({ x, y })) < REACH / 2) ?? null;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const { state } = this.session;
    if (!state || event.ctrlKey || event.altKey || event.metaKey) return;
    const to = stepped(event, this.#cursor ?? { x: state.pose.x_m, y: state.pose.y_m }, STEPS_M);
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    if (to) {
      event.preventDefault();
      this.#cursor = to;
      const { x, y } = this.#view.drawn(to);
      const { left, top, right, bottom } = this.#covered;
      if (x < left || y < top || x > width - right || y > height - bottom) {
        this.#looks = "free";
        this.#view = this.#centred(to);
      }
      const away = Math.hypot(to.x - state.pose.x_m, to.y - state.pose.y_m);
      const where = `x ${fixed(to.x, 2)}, y ${fixed(to.y, 2)}`;
      write(this.#said, t("flat-map.where_metres_from_the_robot", { where, metres: metres(away, 1) }));
    } else if (event.key === "Enter" && this.#cursor) {
      if (!this.#taken(this.#cursor) && state.pending_command === null)
        this.#goTo(this.#view.drawn(this.#cursor), this.#cursor);
    } else if (event.key === "+" || event.key === "-") {
      this.#looks = "free";
      this.#view = this.#view.changed(this.#middle, event.key === "+" ? ZOOM : 1 / ZOOM);
    } else return;
    this.#draw();
  }

  /** @param {Layer} layer @param {string} name @param {string} says */
  #switch(layer, name, says) {
    const box = make("input", { type: "checkbox", checked: this.#layers.has(layer) });
    box.addEventListener("change", () => {
      if (box.checked) this.#layers.add(layer);
      else this.#layers.delete(layer);
      const left = LAYERS.map(([one]) => one).filter((one) => !this.#layers.has(one));
      remember("map-hidden", left.join(","));
      this.#draw();
    });
    const swatch = make("span.swatch", { "data-layer": SWATCHES[layer] ?? "" });
    return make("label.inline.flat-layer", { title: says }, box, swatch, make("span", name));
  }

  /** @param {"whole" | "robot" | "free"} at */
  #look(at) {
    this.#looks = at;
    this.#fitted = "";
    this.#draw();
  }

  // drawing

  /** Of what no panel covers [px]. */
  get #middle() {
    const { left, top, right, bottom } = this.#covered;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    return { x: (left + width - right) / 2, y: (top + height - bottom) / 2 };
  }

  /** @param {Point} floor [m] */
  #centred(floor) {
    const { x, y } = this.#middle;
    return this.#view.centred(floor, 2 * x, 2 * y);
  }

  /** Of the bar of a mode where it lies over the map, at its top [px]. */
  get #barHeight() {
    const { offsetTop, offsetHeight } = this.#modeBar;
    return offsetHeight ? Math.max(0, offsetTop + offsetHeight - this.#covered.top) : 0;
  }

  #aim() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const { left, right, bottom } = this.#covered;
    const top = this.#covered.top + this.#barHeight;
    const { state } = this.#shown ?? {};
    if (this.#looks === "robot" && state) this.#view = this.#centred({ x: state.pose.x_m, y: state.pose.y_m });
    if (this.#looks !== "whole") return;
    const around = state ? { x: state.pose.x_m, y: state.pose.y_m } : { x: 0, y: 0 };
    const none = { left: around.x - 2, right: around.x + 2, bottom: around.y - 2, top: around.y + 2 };
    const tools = this.#tools.clientWidth; // a docked map has none
    const free = height - top - bottom;
    const status = bottom && Math.max(STATUS, Math.min(this.#status, STATUS_SHARE * free));
    const [across, down] = [width - left - right - tools, free - status];
    const seen = state?.landmarks.length ? extentOf([...state.landmarks, state.pose]) : none;
    const margin = across > WIDE * down ? Math.min(MARGIN, WIDE_SHARE * free) : MARGIN; // else the scale is above
    const extent = this.#plan?.extent ?? seen;
    const fitted = FloorView.fitted(extent, across, down, tools ? margin : SMALL_MARGIN);
    const view = new FloorView(fitted.scale, fitted.left + left, fitted.top + top);
    const box = { left, right: left + across, top, bottom: top + down };
    this.#view = this.#fitted === `${width} ${height}` ? this.#view.steady(view, extent, box) : view;
    this.#fitted = `${width} ${height}`;
  }

  /** @param {string} [picture] what the drawing shows @param {() => void} [change] done before */
  #draw(picture = "", change = () => undefined) {
    change();
    const { state, hello } = this.#shown ?? {};
    mark(this.#follow, "aria-pressed", String(this.#looks === "robot"));
    mark(this.#fit, "aria-pressed", String(this.#looks === "whole"));
    const watches = !hello || hello.you.role === "viewer";
    for (const [mode, button] of this.#modes) {
      mark(button, "aria-pressed", String(mode === this.#mode));
      button.hidden = watches && mode !== "measure";
    }
    const draws = this.#mode === "zone";
    const corners = draws ? this.#points : [];
    this.#modeBar.hidden = this.#mode === "";
    this.#zoneDone.hidden = this.#zoneBack.hidden = !draws;
    this.#zoneDone.disabled = corners.length < 3;
    this.#zoneBack.disabled = corners.length === 0;
    const named = this.#mode === "name" && marksOf(this.session).places.findLast(({ name }) => !this.#before.has(name));
    const asks = MODES.find(([mode]) => mode === this.#mode)?.[3] ?? "";
    write(this.#modeSays, named ? t("flat-map.name_is_named_press_the_next", { name: named.name }) : asks);
    write(this.#modeCount, draws ? t("flat-map.count_corners", { count: corners.length }) : ""); // what is pressed next stays where it is
    mark(this.#modeBar, "data-begun", corners.length > 0);
    write(this.#modeLeave, draws ? t("place-view.cancel") : t("flat-map.done"));
    this.classList.toggle("is-measuring", this.#mode !== "");
    if (this.hidden || !state || this.#canvas.clientWidth === 0) return;
    this.#aim();
    if (picture) this.#drawn = picture;
    const begun = performance.now();
    const { at } = this.#robotNow(state);
    drawFlat(this.#canvas, this.#view, {
      state,
      plan: this.#plan,
      scan: seenFrom(this.#scan, this.#motion.where(this.#scanned) ?? at),
      layers: this.#plan ? this.#layers : new Set([...this.#layers, "landmarks"]), // without walls, what there is
      cursor: this.#cursor,
      measured: draws ? [] : this.#points,
      radius: hello?.robot.radius_m ?? 0.1,
      left: this.#toGo.saw(state).join(" · "),
      room: this.#room,
      robot: at,
      chain: chainOf(state, this.#heard, this.session.kinds),
      trail: this.#motion.trail,
      ground: this.#ground,
      places: marksOf(this.session).places,
      zones: marksOf(this.session).zones,
      corners,
      covered: this.#covered,
    });
    this.#move();
    this.#cost = performance.now() - begun;
  }

  /** Where the robot is shown, and whether nothing newer came for a while. @param {State} state */
  #robotNow({ pose: { x_m: x, y_m: y, heading_rad: heading } }) {
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    return (still ? null : this.#motion.at(performance.now() / 1000)) ?? { at: { x, y, heading }, old: false };
  }

  /** Draw the robot where it is now. */
  #move() {
    const { state, hello } = this.#shown ?? {};
    if (!state) return;
    const begun = performance.now();
    const { at: robot, old } = this.#robotNow(state);
    const { cov } = state.pose;
    drawMoving(this.#moving, this.#view, {
      robot,
      old,
      radius: hello?.robot.radius_m ?? 0.1,
      sees: hello?.robot.camera_view_rad ?? null,
      cov,
    });
    this.#cost = performance.now() - begun;
  }
}

/** @type {Partial<Record<Layer, string>>} */
const SWATCHES = {
  scan: "scan",
  trail: "pose",
  way: "plan",
  voice: "voice",
  landmarks: "convex",
  ghost: "ghost",
  people: "person",
  places: "place",
  zones: "zone",
  grid: "grid",
};

/** @param {{x_m: number, y_m: number}[]} points @returns {import("../ui/floor-view.js").Extent} */
function extentOf(points) {
  return maps.extentOf([points.flatMap(({ x_m: x, y_m: y }) => [100 * x, 100 * y])]);
}

/** @param {string} drawing @param {string} says @param {() => void} [act] */
const tool = (drawing, says, act) => iconButton(drawing, says, act, { title: says, look: "flat-tool" });

customElements.define("flat-map", FlatMap);
