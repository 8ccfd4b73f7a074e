// Drawing of the map from above: what is known of the floor, the robot in it, and where it goes.

import { FloorView } from "./floor-view.js";
import { fixed, metres } from "./format.js";
import { colourOf, drawCross, drawRobot, fontOf, fresh, NOSE, trace } from "./place-drawing.js";
import { t } from "./texts.js";

/** @import { State } from "../net/messages.js" */
/** @import { Point } from "./floor-view.js" */
/** @typedef {"scan" | "trail" | "landmarks" | "way" | "voice" | "people" | "places" | "zones" | "ghost" | "grid"} Layer */
/**
 * @typedef {object} FlatScene
 * @property {State} state
 * @property {import("../net/maps-api.js").Plan | null} plan
 * @property {readonly Point[]} scan [m]
 * @property {ReadonlySet<Layer>} layers that are shown
 * @property {Point | null} cursor of the keyboard [m]
 * @property {readonly Point[]} measured none, one or two points [m]
 * @property {number} radius [m] of the robot
 * @property {string} left of the way, in words
 * @property {readonly import("../net/rest.js").PersonInRoom[]} room people in the simulated room
 * @property {{x: number, y: number, heading: number}} robot as it is shown now
 * @property {import("./sensed.js").Sensed | null} chain what the robot has of a person it comes to
 * @property {readonly {x: number, y: number, fresh: number}[]} trail fresh 0..1
 * @property {import("./flat-ground.js").FlatGround} ground
 * @property {readonly import("../net/marks-api.js").Place[]} places
 * @property {readonly import("../net/rest.js").ZoneRow[]} zones
 * @property {readonly Point[]} corners of the zone that is being drawn [m]
 * @property {import("./clear-area.js").Insets} covered by panels
 */

const LABEL_PX = 13;
const VOICE_M = 1.5;
const VOICE_S = 12; // [s] after which a voice is no longer drawn
const FAN_M = 2; // of the camera's fan
const MAX_FAN_PX = 240; // of the same
const TRAIL_LEVELS = 10; // of how fresh it is
const ROBOT_PX = 12; // that its radius has at least
const OTHER_PX = 7; // that of its other poses
const CANDIDATE_PX = 19; // that of a place where it may be
const MAX_HALF_PX = 640; // of the robot's canvas
const HALF_STEP_PX = 16; // its size changes rarely
const RIPPLE_S = 1.2; // [s] that the ring of a voice runs
const SIGMAS = 2;
const BARS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const FARTHER_PX = 24;
const [ABOVE, BELOW] = [-9, 19]; // [px] of words beside a point
const LINE_PX = 15; // by which lines of words are apart
const SMALL_PX = 300; // a map that is no wider has no words
const NARROW_PX = 976; // [px] that no panel covers: where it is no wider the status has no room for the scale beside it
const SAME_M = 0.6; // [m] within which the person who is followed is someone in the room
export const PIN_PX = 12; // of a place: height of its head
const TOOLS_PX = 48; // width of the map's tools
const [BAR_PX, SHORT_BAR_PX] = [60, 40]; // that the scale has at least, and where it stands above the map
const SCALE_PX = 14; // from the edges of what no panel covers

/**
 * @param {HTMLCanvasElement} canvas its CSS custom properties define the colours
 * @param {FloorView} view
 * @param {FlatScene} scene
 */
export function drawFlat(canvas, view, scene) {
  const context = fresh(canvas);
  if (!context) return;
  /** @param {string} name */
  const colour = (name) => colourOf(canvas, name);
  const brush = new Brush(context, view, colour, canvas.clientWidth < SMALL_PX);
  const { state, layers, robot } = scene;
  const { left, right, top, bottom } = scene.covered;
  brush.inside = { left, right: canvas.clientWidth - right - (right && TOOLS_PX) }; // the small view has none
  brush.keepFree(robot);
  if (layers.has("places")) for (const { x_m: x, y_m: y } of scene.places) brush.keepFree({ x, y }, PIN_PX / 2);
  if (layers.has("people")) for (const { x_m: x, y_m: y } of scene.room) brush.keepFree({ x, y }, LINE_PX - 3);
  context.drawImage(
    scene.ground.picture(canvas, view, scene.plan, layers.has("grid"), colour),
    0,
    0,
    canvas.clientWidth,
    canvas.clientHeight,
  );
  if (layers.has("zones")) for (const zone of scene.zones) brush.zone(zone);
  if (layers.has("trail")) brush.trail(scene.trail);
  if (layers.has("way")) brush.way(state.path, state.goal, scene.left);
  if (layers.has("landmarks")) brush.landmarks(state.landmarks);
  if (layers.has("scan")) brush.scan(scene.scan, (point) => scene.ground.explains(point));
  if (layers.has("voice") && state.direction && state.direction.age_s < VOICE_S) brush.voice(state.direction);
  if (layers.has("people")) {
    const { person } = state;
    /** @param {{x_m: number, y_m: number}} one */
    const same = ({ x_m: x, y_m: y }) => person !== null && apart({ x, y }, { x: person.x_m, y: person.y_m }) <= SAME_M;
    for (const one of scene.room) if (!same(one)) brush.inhabitant({ x: one.x_m, y: one.y_m }, robot, one.id);
    if (person && scene.chain) brush.beads(robot, { x: person.x_m, y: person.y_m }, scene.chain);
    if (person) brush.person(person, robot, person.name || (scene.room.find(same)?.id ?? t("flat-drawing.person")));
  }
  if (layers.has("places")) for (const place of scene.places) brush.place(place);
  for (const [rank, { x_m: x, y_m: y, heading_rad: heading }] of (state.floor.lost?.candidates ?? []).entries())
    brush.candidate({ x, y, heading }, rank === 0 ? 0.9 : 0.5);
  if (layers.has("ghost")) {
    const { x_m: x, y_m: y, heading_rad: heading } = state.dead_reckoning;
    brush.robot({ x, y, heading }, scene.radius, "scene-ghost", 0.6);
  }
  const other = state.playback?.comparison;
  if (other) brush.other(other, scene.radius);
  brush.measured(scene.measured);
  brush.corners(scene.corners);
  if (scene.cursor) brush.cross(scene.cursor);
  const narrow = bottom > 0 && canvas.clientWidth - left - right < NARROW_PX;
  const low = narrow ? top + 2 * SCALE_PX : canvas.clientHeight - bottom - SCALE_PX;
  brush.scale(left + SCALE_PX, low, narrow ? SHORT_BAR_PX : BAR_PX);
}

/**
 * The robot on a canvas of its own that is as large as it must be: it moves with every frame, the map does not.
 * @param {HTMLCanvasElement} canvas
 * @param {FloorView} view
 * @param {object} shown
 * @param {{x: number, y: number, heading: number}} shown.robot
 * @param {number} shown.radius [m]
 * @param {boolean} shown.old nothing newer came for a while: it is drawn in grey
 * @param {readonly [number, number] | null} shown.sees edges of the camera's picture, right then left [rad]
 * @param {number[][]} shown.cov [m²]
 */
export function drawMoving(canvas, view, { robot, radius, old, sees, cov }) {
  const at = view.drawn(robot);
  const spread = SIGMAS * Math.sqrt(Math.max(cov[0]?.[0] ?? 0, cov[1]?.[1] ?? 0));
  const reach = Math.max(view.scale * Math.max(NOSE * radius, spread), NOSE * ROBOT_PX, sees ? fanReach(view) : 0) + 4;
  const half = Math.ceil(Math.min(reach, MAX_HALF_PX) / HALF_STEP_PX) * HALF_STEP_PX;
  const [left, top] = [Math.round(at.x) - half, Math.round(at.y) - half];
  canvas.style.translate = `${left}px ${top}px`;
  if (canvas.clientWidth !== 2 * half) canvas.style.width = canvas.style.height = `${2 * half}px`;
  const context = fresh(canvas, { width: 2 * half, height: 2 * half });
  if (!context) return;
  /** @param {string} name */
  const colour = (name) => colourOf(canvas, name);
  const brush = new Brush(context, new FloorView(view.scale, view.left - left, view.top - top), colour);
  const look = old ? "faint" : "scene-pose";
  if (sees) brush.fan(robot, sees, colour(look));
  brush.halo(robot, cov, colour(look));
  brush.robot(robot, radius, look, 1, colour("surface"));
}

/** Of the camera's fan [px]. @param {FloorView} view */
const fanReach = ({ scale }) => Math.min(FAN_M * scale, MAX_FAN_PX);

/** @typedef {{left: number, low: number, wide: number}} Line words that are drawn: where they begin and stand [px] */

class Brush {
  /** @type {Line[]} */
  #written = [];
  inside = { left: -Infinity, right: Infinity }; // [px] where words can be read

  /**
   * @param {CanvasRenderingContext2D} context @param {FloorView} view @param {(name: string) => string} colour
   * @param {boolean} [small] true: without words
   */
  constructor(context, view, colour, small = false) {
    this.context = context;
    this.view = view;
    this.colour = colour;
    this.small = small;
  }

  /** Where no words may stand. @param {Point} point [m] @param {number} [half] [px] */
  keepFree(point, half = BELOW) {
    const { x, y } = this.view.drawn(point);
    for (const down of [-2, LINE_PX - 2]) this.#written.push({ left: x - half, low: y + down, wide: 2 * half });
  }

  /**
   * What stands where the map has floor; the rest is its walls.
   * @param {readonly Point[]} points [m]
   * @param {(point: Point) => boolean} explained
   */
  scan(points, explained) {
    this.context.fillStyle = this.colour("scene-scan");
    const rest = points.filter((point) => !explained(point));
    this.#dots(rest, Math.min(5, Math.max(2.5, 0.06 * this.view.scale)));
  }

  /** A line through points. @param {readonly Point[]} points [m] @param {boolean} [closed] */
  #line(points, closed) {
    this.context.beginPath();
    trace(
      this.context,
      points.map((point) => this.view.drawn(point)),
      closed,
    );
    this.context.stroke();
  }

  /** @param {readonly Point[]} points [m] @param {number} size [px] */
  #dots(points, size) {
    for (const point of points) {
      const { x, y } = this.view.drawn(point);
      this.context.fillRect(x - size / 2, y - size / 2, size, size);
    }
  }

  /** The way of the last half minute, which fades. @param {FlatScene["trail"]} passed */
  trail(passed) {
    const { context, view } = this;
    context.strokeStyle = this.colour("scene-pose");
    context.lineWidth = 3;
    context.lineCap = "round";
    let level = -1;
    for (const [index, { x, y, fresh }] of passed.entries()) {
      const before = passed[index - 1];
      if (!before) continue;
      if (Math.ceil(TRAIL_LEVELS * fresh) !== level) {
        if (level >= 0) context.stroke();
        level = Math.ceil(TRAIL_LEVELS * fresh);
        context.globalAlpha = (0.5 * level) / TRAIL_LEVELS;
        const from = view.drawn(before);
        context.beginPath();
        context.moveTo(from.x, from.y);
      }
      const to = view.drawn({ x, y });
      context.lineTo(to.x, to.y);
    }
    if (level >= 0) context.stroke();
    context.globalAlpha = 1;
  }

  /** Where the robot may be: two standard deviations, as a glow. @param {Point} at [m] @param {number[][]} cov [m²] @param {string} colour */
  halo(at, cov, colour) {
    const { context } = this;
    this.#outlined(at, cov);
    context.fillStyle = context.strokeStyle = colour;
    context.globalAlpha = 0.16;
    context.fill();
    context.globalAlpha = 0.5;
    context.lineWidth = 1;
    context.stroke();
    context.globalAlpha = 1;
  }

  /** @param {State["landmarks"]} rows */
  landmarks(rows) {
    const { context } = this;
    context.lineWidth = 2;
    for (const row of rows) {
      const colour = this.colour(row.kind === "concave" ? "scene-concave" : "scene-convex");
      const { x, y } = this.view.drawn({ x: row.x_m, y: row.y_m });
      context.strokeStyle = colour;
      context.beginPath();
      context.arc(x, y, 4.5, 0, 2 * Math.PI);
      context.stroke();
      this.ellipse({ x: row.x_m, y: row.y_m }, row.cov_m2, colour);
    }
  }

  /** The other way of a recording. @param {import("../net/messages.js").ComparisonState} other @param {number} radius [m] */
  other({ pose, trail, landmarks }, radius) {
    const { context, view } = this;
    context.strokeStyle = this.colour("scene-other");
    context.lineWidth = 2;
    context.setLineDash([6, 4]);
    this.#line(trail.map(([x, y]) => ({ x, y })));
    context.setLineDash([]);
    for (const [x, y] of landmarks) {
      const at = view.drawn({ x, y });
      context.strokeRect(at.x - 4, at.y - 4, 8, 8);
    }
    this.robot({ x: pose.x_m, y: pose.y_m, heading: pose.heading_rad }, radius, "scene-other", 0.7);
  }

  /** @param {State["path"]} path @param {State["goal"]} goal @param {string} left in words */
  way(path, goal, left) {
    const { context, view } = this;
    context.strokeStyle = context.fillStyle = this.colour("scene-plan");
    if (path.length > 1) {
      context.lineWidth = 3;
      context.lineJoin = context.lineCap = "round";
      this.#line(path.map(([x, y]) => ({ x, y })));
    }
    if (!goal) return;
    const at = view.drawn({ x: goal.x_m, y: goal.y_m });
    context.lineWidth = 2.5;
    context.beginPath();
    context.arc(at.x, at.y, 9, 0, 2 * Math.PI);
    context.moveTo(at.x + 3, at.y);
    context.arc(at.x, at.y, 3, 0, 2 * Math.PI);
    context.stroke();
    if (left) this.label(at, left, BELOW);
  }

  /** A light that fades outwards, and a ring that runs out with the sound. @param {NonNullable<State["direction"]>} heard */
  voice({ azimuth_world_rad: azimuth, sd_heard_rad: sd, age_s: age, x_m: x, y_m: y }) {
    const { context, view } = this;
    const at = view.drawn({ x, y });
    const half = Math.min(Math.PI, Math.max(0.03, SIGMAS * sd));
    const reach = VOICE_M * view.scale;
    const colour = this.colour("scene-voice");
    const light = context.createRadialGradient(at.x, at.y, 0, at.x, at.y, reach);
    light.addColorStop(0, colour);
    light.addColorStop(1, "transparent");
    context.save();
    context.globalAlpha = 0.8 * (1 - age / VOICE_S);
    context.fillStyle = light;
    context.beginPath();
    context.moveTo(at.x, at.y);
    context.arc(at.x, at.y, reach, -azimuth - half, -azimuth + half);
    context.closePath();
    context.fill();
    if (age < RIPPLE_S) {
      context.globalAlpha = 1 - age / RIPPLE_S;
      context.strokeStyle = colour;
      context.lineWidth = 2;
      context.beginPath();
      context.arc(at.x, at.y, reach * (0.3 + (0.7 * age) / RIPPLE_S), -azimuth - half, -azimuth + half);
      context.stroke();
    }
    context.restore();
  }

  /**
   * What the robot has of a person by each sense, as beads on the line between them.
   * @param {Point} from [m] @param {Point} to [m]
   * @param {import("./sensed.js").Sensed} chain
   */
  beads(from, to, { heard, seen, laser, left }) {
    const { context, view } = this;
    const [one, other] = [view.drawn(from), view.drawn(to)];
    const lit = [heard, seen, laser, left].map((sensed) => sensed !== null);
    context.strokeStyle = context.fillStyle = this.colour("goal");
    context.lineWidth = 1.5;
    context.setLineDash([2, 5]);
    this.#line([from, to]);
    context.setLineDash([]);
    for (const [index, has] of lit.entries()) {
      const part = (index + 1) / (lit.length + 1);
      context.fillStyle = this.colour(has ? "goal" : "plan-floor");
      context.beginPath();
      context.arc(one.x + part * (other.x - one.x), one.y + part * (other.y - one.y), 4.5, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
  }

  /** Head and shoulders from above, turned to the robot. @param {Point} point [m] @param {Point} towards [m] @param {string} fill */
  figure(point, towards, fill) {
    const { context } = this;
    this.keepFree(point, LINE_PX - 3);
    const at = this.view.drawn(point);
    const wide = Math.max(9, 0.24 * this.view.scale);
    const turn = Math.atan2(point.y - towards.y, towards.x - point.x);
    context.fillStyle = fill;
    context.strokeStyle = this.colour("goal");
    context.lineWidth = 2;
    context.beginPath();
    context.ellipse(at.x, at.y, 0.5 * wide, wide, turn, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.fillStyle = context.strokeStyle;
    context.beginPath();
    context.arc(at.x + 0.1 * wide * Math.cos(turn), at.y + 0.1 * wide * Math.sin(turn), 0.42 * wide, 0, 2 * Math.PI);
    context.fill();
  }

  /** @param {NonNullable<State["person"]>} person @param {Point} robot [m] @param {string} name */
  person({ x_m: x, y_m: y, cov_m2: cov, state }, robot, name) {
    const at = this.view.drawn({ x, y });
    this.figure({ x, y }, robot, this.colour("goal"));
    this.ellipse({ x, y }, cov, this.colour("goal"));
    this.label(at, state === "seen" ? name : t("flat-drawing.name_hidden_now", { name }));
  }

  /** @param {import("../net/rest.js").ZoneRow} zone */
  zone({ name, kind, points_m: points, max_speed_m_s: speed }) {
    const { context } = this;
    const corners = points.map(([x, y]) => ({ x, y }));
    context.fillStyle = context.strokeStyle = this.colour(kind === "keep_out" ? "stop" : "stale");
    context.lineWidth = 2;
    this.#line(corners, true);
    context.globalAlpha = 0.22;
    context.fill();
    context.globalAlpha = 1;
    const middle = { x: mean(corners.map(({ x }) => x)), y: mean(corners.map(({ y }) => y)) };
    const words = speed === null ? name : `${name}, ${fixed(speed, 2)} m/s`;
    this.label(this.view.drawn(middle), words, 0);
  }

  /** @param {readonly Point[]} points [m] */
  corners(points) {
    const { context } = this;
    context.strokeStyle = context.fillStyle = this.colour("accent");
    context.lineWidth = 2;
    this.#line(points, points.length > 2);
    this.#dots(points, 8);
  }

  /** @param {import("../net/marks-api.js").Place} place */
  place({ name, x_m: x, y_m: y, heading_rad: heading }) {
    const { context } = this;
    const at = this.view.drawn({ x, y });
    context.fillStyle = this.colour("accent");
    context.strokeStyle = this.colour("surface");
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(at.x, at.y);
    context.arc(at.x, at.y - PIN_PX, PIN_PX / 2, Math.PI - 0.5, 0.5);
    context.closePath();
    context.stroke();
    context.fill();
    if (heading !== null) {
      context.strokeStyle = this.colour("accent");
      context.beginPath();
      context.moveTo(at.x, at.y);
      context.lineTo(at.x + 14 * Math.cos(heading), at.y - 14 * Math.sin(heading));
      context.stroke();
    }
    this.label(at, name);
  }

  /** A person in the simulated room. @param {Point} point [m] @param {Point} robot [m] @param {string} name */
  inhabitant(point, robot, name) {
    this.figure(point, robot, this.colour("surface"));
    this.label(this.view.drawn(point), name);
  }

  /**
   * @param {{x: number, y: number, heading: number}} at @param {number} radius [m]
   * @param {string} colour @param {number} strength @param {string} [edge] of the robot itself
   */
  robot({ x, y, heading }, radius, colour, strength, edge) {
    drawRobot(this.context, this.view.drawn({ x, y }), heading, {
      radius: Math.max(edge ? ROBOT_PX : OTHER_PX, this.view.scale * radius),
      colour: this.colour(colour),
      strength,
      ...(edge ? { edge } : {}),
    });
  }

  /** Where a lost robot may be: around the robot where both are at one place. @param {{x: number, y: number, heading: number}} at @param {number} strength 0..1 */
  candidate({ x, y, heading }, strength) {
    const look = { radius: CANDIDATE_PX, colour: this.colour("scene-ghost"), strength };
    drawRobot(this.context, this.view.drawn({ x, y }), heading, look);
  }

  /** What the camera sees. @param {{x: number, y: number, heading: number}} at @param {readonly [number, number]} edges @param {string} colour */
  fan({ x, y, heading }, [right, left], colour) {
    const { context } = this;
    const at = this.view.drawn({ x, y });
    const far = fanReach(this.view);
    const fades = context.createRadialGradient(at.x, at.y, 0, at.x, at.y, far);
    fades.addColorStop(0, colour);
    fades.addColorStop(1, "transparent");
    context.globalAlpha = 0.22;
    context.fillStyle = fades;
    context.beginPath();
    context.moveTo(at.x, at.y);
    context.arc(at.x, at.y, far, -heading - left, -heading - right);
    context.fill();
    context.globalAlpha = 1;
  }

  /** Two standard deviations. @param {Point} at [m] @param {number[][]} cov [m²] @param {string} colour */
  ellipse(at, cov, colour) {
    this.#outlined(at, cov);
    this.context.strokeStyle = colour;
    this.context.lineWidth = 1.5;
    this.context.stroke();
  }

  /** The path of an ellipse of two standard deviations. @param {Point} at [m] @param {number[][]} cov [m²] */
  #outlined(at, cov) {
    const [a = 0, b = 0, d = 0] = [cov[0]?.[0], cov[0]?.[1], cov[1]?.[1]];
    const [mean, spread] = [(a + d) / 2, Math.hypot((a - d) / 2, b)];
    const { x, y } = this.view.drawn(at);
    const { context } = this;
    context.beginPath();
    const [long, short] = [mean + spread, mean - spread].map(
      (variance) => SIGMAS * this.view.scale * Math.sqrt(Math.max(0, variance)),
    );
    context.ellipse(x, y, long ?? 0, short ?? 0, -0.5 * Math.atan2(2 * b, a - d), 0, 2 * Math.PI);
  }

  /** @param {readonly Point[]} points [m] */
  measured(points) {
    const { context } = this;
    const [one, other] = points;
    if (!one) return;
    context.strokeStyle = context.fillStyle = this.colour("accent");
    context.lineWidth = 2;
    context.setLineDash([6, 4]);
    this.#line(points);
    context.setLineDash([]);
    this.#dots(points, 6);
    if (!other) return;
    const middle = this.view.drawn({ x: (one.x + other.x) / 2, y: (one.y + other.y) / 2 });
    this.label(middle, metres(apart(one, other)));
  }

  /** @param {Point} cursor [m] */
  cross(cursor) {
    this.context.strokeStyle = this.colour("text");
    this.context.lineWidth = 2;
    drawCross(this.context, this.view.drawn(cursor), 12);
  }

  /** A length that is easy to compare. @param {number} left [px] @param {number} low [px] @param {number} least [px] */
  scale(left, low, least) {
    if (this.small) return;
    const { context, view } = this;
    const bar = BARS.find((length) => length * view.scale >= least) ?? 100;
    context.strokeStyle = this.colour("soft");
    context.lineWidth = 2;
    const [right, tip] = [left + bar * view.scale, low - 5];
    const ends = [
      { x: left, y: tip },
      { x: left, y: low },
      { x: right, y: low },
      { x: right, y: tip },
    ];
    context.beginPath();
    trace(context, ends);
    context.stroke();
    context.fillStyle = this.colour("soft");
    context.font = fontOf(LABEL_PX);
    context.fillText(`${bar} m`, left + 6, low - 6);
  }

  /**
   * Words beside a point, readable on whatever is drawn there; with a line to the point where they stand lines away from it.
   * @param {Point} at [px]
   * @param {string} words
   * @param {number} [down] [px]; 0: across it
   */
  label({ x, y }, words, down = ABOVE) {
    if (this.small) return;
    const { context } = this;
    context.font = fontOf(LABEL_PX);
    const wide = context.measureText(words).width;
    const beside = [x + 13, x - 13 - wide, x + FARTHER_PX, x - FARTHER_PX - wide]; // farther off: the robot stands on it
    if (down) beside.push(x - wide / 2);
    else beside.unshift(x - wide / 2);
    const rows = [0, 1, 2, 3, 4, 5, 6].flatMap((far) => [ABOVE - far * LINE_PX, BELOW + far * LINE_PX]);
    const sides = [down, ...rows].flatMap((dy) => beside.map((left) => [left, y + dy]));
    const free = sides.find(
      ([left = 0, low = 0]) =>
        left >= this.inside.left &&
        left + wide <= this.inside.right &&
        !this.#written.some((one) => meet(one, { left, low, wide })),
    );
    if (!free) return;
    const [left = 0, low = 0] = free;
    this.#written.push({ left, low, wide });
    const near = Math.max(left - 3, Math.min(x, left + wide + 3));
    const edge = near === x ? (low > y ? 2 - LINE_PX : 3) : -LINE_PX / 3; // of the words, or beside their middle
    if (low - y < ABOVE || low - y > BELOW) this.#leader(x, y, near, low + edge);
    context.lineJoin = "round";
    context.lineWidth = 4;
    context.strokeStyle = this.colour("surface");
    context.strokeText(words, left, low);
    context.fillStyle = this.colour("text");
    context.fillText(words, left, low);
  }

  /** From a point to words that stand lines away. @param {number} x @param {number} y @param {number} toX @param {number} toY [px] */
  #leader(x, y, toX, toY) {
    const { context } = this;
    context.lineWidth = 1;
    context.strokeStyle = this.colour("soft");
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(toX, toY);
    context.stroke();
  }
}

/** Whether two lines of words lie on each other. @param {Line} one @param {Line} other */
const meet = (one, other) =>
  Math.abs(one.low - other.low) < LINE_PX && one.left < other.left + other.wide && other.left < one.left + one.wide;

/** @param {readonly number[]} values */
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

/** @param {Point} one @param {Point} other */
export const apart = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);
