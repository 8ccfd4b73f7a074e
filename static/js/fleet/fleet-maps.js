// Element <fleet-maps>: robots on the one map that they share, and a saved map of one robot taken to another.

import { address, call, Refusal, sentenceOf } from "../net/api.js";
import { send } from "../net/edits-api.js";
import { plan } from "../net/maps-api.js";
import { shareMarks } from "../net/marks-api.js";
import { make, mark, onSubmit, write } from "../ui/element.js";
import { FloorView } from "../ui/floor-view.js";
import { colourOf, drawPlan, drawRobot, fresh } from "../ui/place-drawing.js";
import { overlap } from "../ui/placement.js";
import { t } from "../ui/texts.js";
import { groupOf, isOpen } from "./words.js";

/** @import { FleetSession } from "./fleet-session.js" */
/** @import { FleetRow as Robot } from "../net/rest.js" */
/** @import { Point } from "../ui/floor-view.js" */
/** @import { Box } from "../ui/placement.js" */
/** @typedef {{width: number, height: number}} Size [px] */

const PLAN_MS = 10_000; // between two looks at the walls
const MARGIN_PX = 28;
const RADIUS_PX = 9; // of a robot
const COLOURS = { help: "fault", working: "scene-pose", idle: "scene-pose", away: "faint" };

/** @param {Robot} robot @returns {string} the root of its console */
const rootOf = ({ name }) => `robots/${encodeURIComponent(name)}/`;

/** @param {Point} at its middle [px] @param {Size} size [px] @returns {Box} */
const boxAround = ({ x, y }, { width, height }) => ({
  left: x - width / 2,
  top: y - height / 2,
  right: x + width / 2,
  bottom: y + height / 2,
});

/**
 * Where a name stands: below its robot, or where it covers least of robots and names.
 * @param {Point} at of the robot [px] @param {Size} size of the name @param {Box[]} taken @param {number} width of the drawing
 */
function nameBeside({ x, y }, size, taken, width) {
  const [across, down] = [RADIUS_PX + 2 + size.width / 2, RADIUS_PX + 2 + size.height / 2];
  const ways = /** @type {const} */ ([
    [0, down],
    [0, -down],
    [across, 0],
    [-across, 0],
    [0, down + size.height],
    [0, -down - size.height],
  ]);
  const boxes = ways.map(([right, below]) => {
    const middle = Math.max(size.width / 2, Math.min(x + right, width - size.width / 2));
    return boxAround({ x: middle, y: y + below }, size);
  });
  /** @param {Box} box */
  const covered = (box) => taken.reduce((sum, other) => sum + overlap(box, other), 0);
  return boxes.reduce((best, box) => (covered(box) < covered(best) ? box : best));
}

/** One map, and the robots that go on in it. */
class SharedMap {
  #head = make("h2");
  #canvas = make("canvas.fleet-floor", { role: "img" });
  #spots = make("div.fleet-spots");
  #share = make("button.button", { type: "button", onclick: () => void this.#carry() }, t("fleet.share"));
  #says = make("p", { role: "status" });
  #foot = make("div.fleet-map-foot", this.#share, this.#says);
  element = make("section.card.fleet-map", this.#head, this.#canvas, this.#spots, this.#foot);
  /** @type {Robot[]} */
  #robots = [];
  /** @type {import("../net/maps-api.js").Plan | null} */
  #plan = null;
  #askedAt = -Infinity;
  /** @type {Map<string, HTMLAnchorElement>} the names beside the robots, by these */
  #spotOf = new Map();

  /** What people marked at one of these robots, for the others too. */
  async #carry() {
    const open = new Map(this.#robots.map((robot) => [rootOf(robot), robot]));
    this.#share.disabled = true;
    try {
      const { added, refused } = await shareMarks([...open.keys()], (root) => open.get(root)?.role !== "viewer");
      write(this.#says, [t("fleet.shared", { added }), ...refused].join(" "));
    } catch (refusal) {
      write(this.#says, sentenceOf(refusal));
    } finally {
      this.#share.disabled = false;
    }
  }

  /** @param {Robot[]} robots */
  show(robots) {
    this.#robots = robots.filter((robot) => robot.link === "live" && isOpen(robot));
    this.#foot.hidden = this.#robots.length < 2 || this.#robots.every(({ role }) => role === "viewer");
    const name = robots.find((robot) => robot.map?.name)?.map?.name ?? "";
    write(this.#head, t("fleet.on_one_map", { name }));
    this.#canvas.setAttribute("aria-label", t("fleet.map_from_above", { name }));
    void this.#look(this.#robots[0]);
    this.#draw(robots);
  }

  /** @param {Robot | undefined} robot who is asked for the walls */
  async #look(robot) {
    if (!robot || performance.now() - this.#askedAt < PLAN_MS) return;
    this.#askedAt = performance.now();
    this.#plan = await plan(rootOf(robot)).catch(() => this.#plan);
  }

  /** @param {Robot[]} robots */
  #draw(robots) {
    const [canvas, shown] = [this.#canvas, this.#plan];
    const context = fresh(canvas);
    this.#spots.hidden = !shown;
    if (!context || !shown) return;
    const view = FloorView.fitted(shown.extent, canvas.clientWidth, canvas.clientHeight, MARGIN_PX);
    /** @param {string} name */
    const colour = (name) => colourOf(canvas, name);
    drawPlan(context, view, shown, colour);
    const drawn = robots.map((robot) => {
      const { x_m: x, y_m: y, heading_rad: heading } = robot.pose ?? { x_m: 0, y_m: 0, heading_rad: 0 };
      const look = robot.link === "live" ? COLOURS[groupOf(robot)] : "faint";
      const at = view.drawn({ x, y });
      drawRobot(context, at, heading, { radius: RADIUS_PX, colour: colour(look), strength: 1 });
      const spot = this.#spotOf.get(robot.name) ?? make("a.fleet-spot", robot.name);
      if (!this.#spotOf.has(robot.name)) this.#spots.append(spot);
      this.#spotOf.set(robot.name, spot);
      mark(spot, "data-group", groupOf(robot));
      mark(spot, "href", isOpen(robot) ? robot.url : null);
      return { at, spot };
    });
    const named = drawn.map((one) => ({
      ...one,
      size: { width: one.spot.offsetWidth, height: one.spot.offsetHeight },
    }));
    const taken = drawn.map(({ at }) => boxAround(at, { width: 2 * RADIUS_PX, height: 2 * RADIUS_PX }));
    for (const { at, spot, size } of named) {
      const box = nameBeside(at, size, taken, canvas.clientWidth);
      taken.push(box);
      spot.style.left = `${box.left}px`;
      spot.style.top = `${canvas.offsetTop + box.top}px`;
    }
    const names = new Set(robots.map(({ name }) => name));
    for (const [name, spot] of this.#spotOf)
      if (!names.has(name)) {
        spot.remove();
        this.#spotOf.delete(name);
      }
  }
}

export class FleetMaps extends HTMLElement {
  /** @type {Map<string, SharedMap>} by the id of their axes */
  #maps = new Map();
  #from = picker(t("fleet.take_from"));
  #which = picker(t("fleet.take_which"));
  #to = picker(t("fleet.take_to"));
  #replace = make("input", { type: "checkbox" });
  #take = make("button.button.primary", { type: "submit" }, t("fleet.take"));
  #says = make("p", { role: "status" });
  #form = make(
    "form.fleet-take-form",
    ...[this.#from, this.#which, this.#to].map(({ label }) => label),
    make("label.fleet-take-check", this.#replace, t("fleet.take_replace")),
    this.#take,
  );
  #taking = make(
    "details.card.fleet-take",
    { hidden: true },
    make("summary", t("fleet.take_a_map")),
    make("p.note", t("fleet.take_says")),
    this.#form,
    this.#says,
  );

  /** @param {FleetSession} session */
  join(session) {
    this.append(this.#taking);
    session.on("changed", () => this.#show(session));
    this.#taking.addEventListener("toggle", () => void this.#list());
    this.#from.select.addEventListener("change", () => void this.#list());
    onSubmit(this.#form, () => void this.#carry());
  }

  /** @param {FleetSession} session */
  #show({ fleet }) {
    /** @type {Map<string, Robot[]>} */
    const groups = new Map();
    for (const robot of fleet?.robots ?? [])
      if (robot.map?.id && robot.pose && robot.need !== "lost")
        groups.set(robot.map.id, [...(groups.get(robot.map.id) ?? []), robot]);
    for (const [id, robots] of groups) if (robots.length < 2) groups.delete(id);
    for (const [id, map] of this.#maps)
      if (!groups.has(id)) {
        map.element.remove();
        this.#maps.delete(id);
      }
    for (const [id, robots] of groups) {
      const map = this.#maps.get(id) ?? new SharedMap();
      if (!this.#maps.has(id)) {
        this.#maps.set(id, map);
        this.insertBefore(map.element, this.#taking);
      }
      map.show(robots);
    }
    const open = (fleet?.robots ?? []).filter((robot) => robot.link === "live" && isOpen(robot));
    this.#taking.hidden = open.length < 2;
    offer(
      this.#from,
      open.map(({ name }) => name),
    );
    offer(
      this.#to,
      open.filter(({ role }) => role !== "viewer").map(({ name }) => name),
    );
    if (this.#to.select.value === this.#from.select.value && this.#to.select.selectedIndex >= 0)
      this.#to.select.selectedIndex = [...this.#to.select.options].findIndex(
        ({ value }) => value !== this.#from.select.value,
      );
  }

  async #list() {
    const name = this.#from.select.value;
    if (!name || !this.#taking.open) return;
    try {
      /** @type {{maps: Array<{name: string}>}} */
      const { maps } = await call(`robots/${encodeURIComponent(name)}/api/maps`);
      offer(
        this.#which,
        maps.map((map) => map.name),
      );
      this.#take.disabled = maps.length === 0;
      write(this.#says, maps.length ? "" : t("fleet.take_none", { name }));
    } catch (refusal) {
      write(this.#says, sentenceOf(refusal));
    }
  }

  async #carry() {
    const [from, map, to] = [this.#from, this.#which, this.#to].map(({ select }) => encodeURIComponent(select.value));
    this.#take.disabled = true;
    write(this.#says, t("fleet.take_runs"));
    try {
      const answer = await fetch(address(`robots/${from}/api/maps/${map}.zip`), { credentials: "same-origin" });
      if (!answer.ok) throw new Refusal(answer.status, t("api.answered", { status: answer.status }));
      const more = this.#replace.checked ? "&replace=true" : "";
      await send(`robots/${to}/api/maps/import?name=${map}${more}`, await answer.blob());
      const [name, robot] = [this.#which.select.value, this.#to.select.value];
      const link = make("a", { href: address(`robots/${to}/maps`).href }, t("fleet.take_open", { robot }));
      this.#says.replaceChildren(t("fleet.take_done", { name, robot }), " ", link);
    } catch (refusal) {
      write(this.#says, sentenceOf(refusal));
    } finally {
      this.#take.disabled = false;
    }
  }
}

/** @param {string} words of its label */
function picker(words) {
  const select = make("select.field-box", { "aria-label": words });
  return { select, label: make("label", make("span", words), select) };
}

/** Offer these choices; what was chosen stays. @param {{select: HTMLSelectElement}} picker @param {string[]} names */
function offer({ select }, names) {
  const sorted = names.toSorted((one, other) => one.localeCompare(other));
  if (sorted.join("\n") === [...select.options].map(({ value }) => value).join("\n")) return;
  const chosen = select.value;
  select.replaceChildren(...sorted.map((name) => make("option", { value: name }, name)));
  if (sorted.includes(chosen)) select.value = chosen;
}

customElements.define("fleet-maps", FleetMaps);
