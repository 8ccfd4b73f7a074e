// Client model of the Connect page: what was found, the operator's choice of topics, and the robot file.

import { call, post } from "../net/api.js";
import * as recordings from "../net/recordings-api.js";
import { PageModel } from "../ui/page-model.js";
import { inLanguage, t } from "../ui/texts.js";
import { nameOf, openInstead, saveMap } from "./opening.js";

/** @import { FoundPart as Part, FoundRobot as Connection, WrittenFile as Written } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */
/** @typedef {"odometry" | "scan" | "image" | "camera_info" | "sound" | "cmd_vel" | "cmd_vel_type" | "battery" | "map" | "pose" | "frames" | "description"} Role */
/** @typedef {"robot" | "file" | "assumed"} Origin */
/** @typedef {{part: number, role: Role, topics: string[]}} Choice */

/** @param {string} url */
export const isRecording = (url) => url.startsWith("log:");

const ROOT = "api/robot";
const ASK_MS = 2000;

export class ConnectionModel extends PageModel {
  /** @type {Connection | null} what is shown; null until it was read */
  found = null;
  /** True while `found` is of another look than the console's own connection. */
  probed = false;
  whyNot = "";
  /** @type {string[]} names of the robot files that exist */
  files = [];
  /** @type {string[]} URLs of simulated robots and recordings that can be opened instead; none on a real robot */
  openedHere = [];
  /** @type {import("../net/rest.js").FoundAddresses | null} what answered when it was last asked */
  answers = null;
  /** @type {Map<string, Choice>} the operator's choice, by part and role */
  choices = new Map();
  /** True while topics were chosen on which nothing was heard yet. */
  changed = false;
  /** @type {Written | null} */
  written = null;
  #watched = ""; // of the state, what this page shows
  #driver = "";

  /** @param {Session} session */
  constructor(session) {
    super(session);
    session.on("hello", () => this.shown && this.#rests && void this.read());
    session.on("heard", () => this.#watch());
    this.poll(ASK_MS, () => this.shown && this.#rests);
  }

  /** @override @param {boolean} shown true while the page is open: what the console is connected to is read again and again */
  follow(shown) {
    this.shown = shown;
    if (shown && this.#rests) void this.read();
  }

  get #rests() {
    return !this.probed && !this.changed && !this.busy;
  }

  /** Who drives, where it is another one; "" otherwise. */
  get driver() {
    const { hello, state } = this.session;
    const lease = state?.lease;
    return lease?.holder && lease.holder_id !== hello?.you.id ? lease.holder : "";
  }

  /** True where this page has asked the driver for control. */
  get asked() {
    return this.session.state?.lease.asked_by_id === this.session.hello?.you.id;
  }

  #watch() {
    const watched = `${this.driver} ${this.asked}`;
    if (watched === this.#watched) return;
    if (!watched.startsWith(`${this.#driver} `)) this.forgive(); // what another driver was the reason for
    [this.#watched, this.#driver] = [watched, this.driver];
    this.tell();
  }

  /** True where what is shown is the robot that the console drives. */
  get own() {
    return this.found !== null && this.found.url === this.session.hello?.robot.url;
  }

  /** Show what the console is connected to. @override */
  read() {
    return this.reading(async () => {
      const { connection, why_not, files, opened_here } = await call(`${ROOT}/connection`);
      if (this.probed || this.changed) return;
      [this.found, this.whyNot, this.files, this.openedHere] = [connection, inLanguage(why_not), files, opened_here];
    });
  }

  async back() {
    this.probed = this.changed = false;
    this.choices.clear();
    this.written = null;
    this.forgive();
    await this.read();
  }

  /**
   * Choose topics; nothing is heard on them before the next look.
   * @param {number} part @param {Role} role @param {string[]} topics
   */
  choose(part, role, topics) {
    this.choices.set(`${part} ${role}`, { part, role, topics });
    this.changed = true;
    this.written = null;
    this.tell();
  }

  /** Connect to a robot, see what is there, and let go. @param {string} url */
  async look(url) {
    if (url !== this.found?.url) this.choices.clear();
    await this.during(t("connection-model.looking_at_url_that_takes_up", { url }), async () => {
      this.found = await post(`${ROOT}/probe`, { url, topics: [...this.choices.values()] });
      this.choices.clear();
      this.changed = false;
      this.probed = true;
      this.written = null;
      this.whyNot = "";
    });
  }

  /**
   * Open a recording or a simulated robot instead of this one; the console starts again with it.
   * @param {string} url
   * @param {boolean} save the map first
   */
  async open(url, save) {
    await this.during(t("connection-model.opening_url", { url: nameOf(url) }), async () => {
      if (save) await saveMap(this.session);
      await openInstead(this.session, url);
    });
  }

  /** Keep a recording from this computer, or make a sample; `openedHere` has its URL then. @param {File | string} what */
  async take(what) {
    const own = typeof what === "string";
    const doing = own
      ? t("connection-model.making_a_sample")
      : t("connection-model.taking_in_name", { name: what.name });
    let taken = "";
    await this.during(doing, async () => {
      taken = (await (own ? recordings.make(what) : recordings.take(what))).url;
      this.openedHere = [...new Set([...this.openedHere, taken])];
    });
    return taken;
  }

  /** Knock where robots may be. */
  async find() {
    await this.during(t("connection-model.knocking"), async () => {
      this.answers = await post(`${ROOT}/find`);
    });
  }

  /**
   * Write the robot file.
   * @param {Record<string, unknown>} confirmed name, limits and mountings
   * @param {boolean} replace
   */
  async write(confirmed, replace) {
    const found = this.found;
    if (!found) return;
    await this.during(t("connection-model.writing"), async () => {
      /** @type {Written} */
      const written = await post(`${ROOT}/file`, {
        ...confirmed,
        url: found.url,
        topics: confirmedTopics(found),
        replace,
      });
      this.written = written;
      this.files = [...new Set([...this.files, written.name])];
      this.session.announce(t("connection-model.name_is_written", { name: written.name }));
    });
  }
}

/**
 * True for the only part of a robot that has nothing to be chosen or said: the robot's own card says what it has.
 * @param {Part} part
 * @param {{url: string, parts: Part[]}} found
 */
export const isBare = (part, { url, parts }) =>
  parts.length === 1 &&
  part.up &&
  part.name === url &&
  part.findings.roles.length + part.findings.remarks.length + part.findings.faults.length === 0;

/** Roles whose absence at the next start is no reason to refuse the robot: they are named only where several could be it. */
const LOOSE = new Set(["camera_info", "battery", "map", "pose", "description"]);

/**
 * The topics as they are used now, as a choice that a robot file keeps.
 * @param {Connection} found
 * @returns {Choice[]}
 */
export function confirmedTopics(found) {
  return found.parts.flatMap(({ findings }, part) =>
    findings.roles
      .filter(({ role, used, candidates }) => {
        if (role === "frames") return false;
        return LOOSE.has(role) ? candidates.length > Number(used.length > 0) : used.length > 0 || candidates.length > 0;
      })
      .flatMap(({ role, used }) => {
        const topics = used.map(({ topic }) => topic);
        const [type = ""] = role === "cmd_vel" ? used.map((one) => one.type) : [];
        const typed = type ? [{ part, role: /** @type {Role} */ ("cmd_vel_type"), topics: [shortType(type)] }] : [];
        return [{ part, role, topics }, ...typed];
      }),
  );
}

/** @param {string} type "sensor_msgs/msg/LaserScan" → "LaserScan" */
export const shortType = (type) => type.split("/").at(-1) ?? type;

/** The file of a robot's name, as the console makes it. @param {string} name */
export const fileOf = (name) =>
  `${
    name
      .normalize("NFKD")
      .replace(/[^\p{ASCII}]/gu, "")
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-+|-+$/g, "") || "robot"
  }.toml`;
