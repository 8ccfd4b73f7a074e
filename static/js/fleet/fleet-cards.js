// Element <fleet-cards>: a card for each robot, who needs help first. A picture is asked for only while it is seen.

import { address } from "../net/api.js";
import { icon, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { onTouch, unlessPressed } from "../ui/press.js";
import { t } from "../ui/texts.js";
import { activityOf, groupOf, isOpen, linkOf, needOf, noticeOf, standsStill } from "./words.js";

/** @import { FleetSession } from "./fleet-session.js" */
/** @import { FleetRow as Robot } from "../net/rest.js" */

const PICTURE_MS = 500; // between two pictures of a robot
const SHARED_MS = 125; // of one picture among all that are seen

class Card {
  #picture = make("img.fleet-picture", { alt: "" });
  #none = make("div.fleet-no-picture", icon("camera"));
  #name = make("a.fleet-name");
  #kind = make("span.badge", { hidden: true }, t("fleet.simulated"));
  #link = make("span.fleet-link");
  #need = make("p.fleet-need");
  #activity = make("p.fleet-activity");
  #facts = make("p.fleet-facts");
  #notice = make("p.fleet-notice");
  #stop = make("button.fleet-card-stop", icon("stop"), t("fleet.stop"));
  #askedAt = -Infinity;
  #asking = false;
  #shown = false; // the newest picture came
  /** @type {Robot | null} */
  #robot = null;
  seen = false;
  element = make(
    "article.card.fleet-card",
    make("div.fleet-frame", this.#picture, this.#none, this.#link),
    make("div.fleet-words", make("h2", this.#name, this.#kind), this.#need, this.#activity, this.#facts, this.#notice),
    this.#stop,
  );

  /** @param {FleetSession} session */
  constructor(session) {
    onTouch(this.#stop, () => this.#robot && void session.stop(this.#robot));
  }

  /** @param {Robot} robot */
  show(robot) {
    this.#robot = robot;
    write(this.#name, robot.name);
    const open = isOpen(robot);
    mark(this.#name, "href", open ? robot.url : null);
    mark(this.#name, "title", open ? t("fleet.open_console", { name: robot.name }) : null);
    mark(this.element, "data-link", robot.link);
    mark(this.element, "data-group", groupOf(robot));
    mark(this.#kind, "hidden", !robot.simulated);
    write(this.#link, linkOf(robot));
    write(this.#need, needOf(robot));
    mark(this.#need, "hidden", robot.need === "");
    write(this.#activity, activityOf(robot));
    write(this.#facts, factsOf(robot));
    const notice = noticeOf(robot);
    write(this.#notice, notice);
    mark(this.#notice, "data-level", robot.notice?.level ?? null);
    mark(this.#notice, "hidden", notice === "");
    mark(this.#stop, "aria-label", t("fleet.stop_one", { name: robot.name }));
    mark(this.#stop, "data-still", standsStill(robot));
    this.#stop.disabled = !open;
    mark(this.#picture, "hidden", !this.#shown);
    mark(this.#none, "hidden", this.#shown);
  }

  /** @param {number} period [ms] */
  async look(period) {
    const robot = this.#robot;
    const now = performance.now();
    const wanted = robot?.picture && robot.link === "live" && robot.role !== null && this.seen;
    if (!robot || !wanted || this.#asking || now - this.#askedAt < period) return;
    [this.#asking, this.#askedAt] = [true, now];
    try {
      const { href } = address(`api/fleet/robots/${encodeURIComponent(robot.name)}/picture?of=${Math.round(now)}`);
      await new Promise((resolve, reject) => {
        this.#picture.onload = resolve;
        this.#picture.onerror = reject;
        this.#picture.src = href;
      });
      this.#picture.alt = t("fleet.picture_of", { name: robot.name });
      this.#shown = true;
    } catch {
      this.#shown = false; // the robot or the fleet does not answer; the card says so
    } finally {
      this.#asking = false;
    }
  }
}

/** @param {Robot} robot */
function factsOf({ operator, battery, pose, map, link }) {
  const facts = [
    operator ? t("fleet.driven_by", { name: operator }) : link === "gone" ? "" : t("fleet.nobody_drives"),
    battery === null || battery === undefined ? "" : t("fleet.battery", { percent: fixed(100 * battery, 0) }),
    pose ? t("fleet.pose", { x: fixed(pose.x_m, 1), y: fixed(pose.y_m, 1) }) : "",
    map?.name ? t("fleet.on_map", { name: map.name }) : "",
  ];
  return facts.filter(Boolean).join(" · ");
}

export class FleetCards extends HTMLElement {
  /** @type {Map<string, Card>} */
  #cards = new Map();
  /** @type {WeakMap<Element, Card>} */
  #of = new WeakMap();
  #filter = { group: "", words: "" };
  #empty = make("p.fleet-empty");
  #seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      const card = this.#of.get(target);
      if (card) card.seen = isIntersecting;
    }
  });
  /** @type {FleetSession | null} */
  #session = null;

  /** @param {FleetSession} session */
  join(session) {
    this.#session = session;
    this.append(this.#empty);
    session.on("changed", () => unlessPressed(this, () => this.show()));
    setInterval(() => this.#look(), SHARED_MS);
  }

  /** @param {string} group @param {string} words */
  filter(group, words) {
    this.#filter = { group, words };
    this.show();
  }

  show() {
    const session = this.#session;
    const fleet = session?.fleet;
    if (!session || !fleet) return;
    const { group, words } = this.#filter;
    const chosen = fleet.robots.filter(
      (robot) => (!group || groupOf(robot) === group) && (!words || robot.name.toLowerCase().includes(words)),
    );
    const names = new Set(fleet.robots.map((robot) => robot.name));
    for (const [name, card] of this.#cards)
      if (!names.has(name)) {
        this.#seen.unobserve(card.element);
        card.element.remove();
        this.#cards.delete(name);
      }
    /** @type {Element | null} */
    let last = null;
    for (const robot of fleet.robots) {
      const card = this.#cards.get(robot.name) ?? this.#made(session, robot.name);
      card.show(robot);
      card.element.hidden = !chosen.includes(robot);
      /** @type {Element | null} */
      const next = last ? last.nextElementSibling : this.firstElementChild;
      if (next !== card.element) this.insertBefore(card.element, next);
      last = card.element;
    }
    write(this.#empty, fleet.robots.length ? t("fleet.none_found") : t("fleet.no_robots"));
    mark(this.#empty, "hidden", chosen.length > 0);
    mark(this, "data-few", fleet.robots.length <= 3);
  }

  /** @param {FleetSession} session @param {string} name */
  #made(session, name) {
    const card = new Card(session);
    this.#cards.set(name, card);
    this.#of.set(card.element, card);
    this.#seen.observe(card.element);
    return card;
  }

  #look() {
    if (document.hidden || !this.#session?.up) return;
    const seen = [...this.#cards.values()].filter((card) => card.seen);
    const period = Math.max(PICTURE_MS, SHARED_MS * seen.length);
    for (const card of seen) void card.look(period);
  }
}

customElements.define("fleet-cards", FleetCards);
