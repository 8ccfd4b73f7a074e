// HTTP client for what people marked on the map: named places, zones and routes. Read again whenever the console says that they changed.

import { t } from "../ui/texts.js";
import { address, call, post, send, sentenceOf } from "./api.js";

/** @import { Kind } from "../drive/suggest.js" */
/** @import { RouteProgress, ZoneRow as Zone } from "./rest.js" */
/** @import { Session } from "./session.js" */
/** @typedef {{name: string, x_m: number, y_m: number, heading_rad: number | null, outline_m?: Array<[number, number]>, wall_m?: number | null}} Place */

/** @typedef {"wait_for_continue" | "come_here" | "say" | "take_a_picture" | "record"} StopAction */
/** @typedef {{place: string, wait_s: number, action: StopAction | null, text?: string}} Stop */
/** @typedef {{name: string, stops: Stop[], loop: boolean, begins?: string, ends?: string, every_min?: number}} Route */

const PLACES = "api/places";
const ZONES = "api/zones";
const ROUTES = "api/routes";
const AGAIN_MS = 3000; // after which a reading that failed is repeated

/** @param {string} root @param {string} name */
const one = (root, name) => `${root}/${encodeURIComponent(name)}`;

/** @param {Place} place @returns {Promise<Place>} */
export const addPlace = (place) => post(PLACES, place);

/** @param {string} name @param {Array<[number, number]>} outline corners [m] @returns {Promise<Place>} */
export const addRoom = (name, outline) => post(PLACES, { name, outline_m: outline });

/** @param {string} name @param {Partial<Place>} change @returns {Promise<Place>} */
export const changePlace = (name, change) => send(one(PLACES, name), "PATCH", change);

/** @param {string} name */
export const removePlace = (name) => call(one(PLACES, name), { method: "DELETE" });

/** @param {Zone} zone @returns {Promise<Zone>} */
export const addZone = (zone) => post(ZONES, zone);

/** @param {string} name */
export const removeZone = (name) => call(one(ZONES, name), { method: "DELETE" });

/** @param {Route} route @returns {Promise<Route>} */
export const addRoute = (route) => post(ROUTES, route);

/** @param {string} name */
export const removeRoute = (name) => call(one(ROUTES, name), { method: "DELETE" });

/** @param {string} name @returns {Promise<RouteProgress>} */
export const startRoute = (name) => post(`${one(ROUTES, name)}/start`, {});

/** @returns {Promise<RouteProgress>} of the route that runs, or the last one, with what happened at its stops */
export const routeProgress = () => call("api/route");

/** The address of a picture that was taken at a stop. @param {string} name */
export const routePicture = (name) => address(one("api/route/pictures", name)).href;

/** @param {"pause" | "resume" | "skip" | "stop"} act @returns {Promise<RouteProgress>} */
export const steerRoute = (act) => post(`api/route/${act}`);

/**
 * Give every robot of one map the places, zones and routes that only others have; what it has under a name stays.
 * @param {string[]} roots of the consoles, "robots/r1/" @param {(root: string) => boolean} mayWrite
 * @returns {Promise<{added: number, refused: string[]}>} sentences of the consoles that took one not
 */
export async function shareMarks(roots, mayWrite) {
  const done = { added: 0, refused: /** @type {string[]} */ ([]) };
  for (const path of [PLACES, ZONES, ROUTES]) {
    // routes last: their stops are places; the distance of a place to a wall is no part of it
    const kind = path.replace("api/", "");
    /** @type {Array<Array<{name: string}>>} */
    const had = await Promise.all(roots.map(async (root) => (await call(root + path))[kind]));
    for (const [n, root] of roots.entries()) {
      const names = new Set(had[n]?.map(({ name }) => name.toLowerCase()));
      for (const mark of mayWrite(root) ? had.flat() : []) {
        if (names.has(mark.name.toLowerCase())) continue;
        names.add(mark.name.toLowerCase());
        await post(root + path, { ...mark, wall_m: undefined }).then(
          () => (done.added += 1),
          (refusal) => done.refused.push(`${mark.name}: ${sentenceOf(refusal)}`),
        );
      }
    }
  }
  return done;
}

/** @param {Place} place the words that send the robot there */
export const wordsTo = ({ name }) => `go to ${name.toLowerCase()}`;

/**
 * The places as rows of the vocabulary, for the completion of typed words.
 * @param {readonly Place[]} places
 * @returns {Kind[]}
 */
export const kindsOf = (places) =>
  places.map((place) => ({
    name: "stop_at",
    words: [wordsTo(place), `stop at ${place.name.toLowerCase()}`],
    numbers: [],
    example: wordsTo(place),
    summary: t("marks-api.drives_to_name", { name: place.name }),
  }));

/**
 * Why no route stops at a place; "" where it may.
 * @param {string} place its name
 * @param {{places: readonly Place[], zones: readonly Zone[]}} marks
 */
export function troubleAt(place, { places, zones }) {
  const there = places.find(({ name }) => name.toLowerCase() === place.toLowerCase());
  if (!there) return t("marks-api.no_place_is_called_so", { place });
  const zone = zones.find(({ kind, points_m }) => kind === "keep_out" && isInside(there, points_m));
  return zone ? t("marks-api.place_lies_in_zone", { place, zone: zone.name }) : "";
}

/** @param {{x_m: number, y_m: number}} point @param {readonly (readonly [number, number])[]} corners of a polygon [m] */
function isInside({ x_m: x, y_m: y }, corners) {
  let [bx, by] = corners.at(-1) ?? [0, 0];
  let odd = false; // sides that lie to the right of the point
  for (const [ax, ay] of corners) {
    if (ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) odd = !odd;
    [bx, by] = [ax, ay];
  }
  return odd;
}

/** The newest marks of the map in use; dispatches "change" when they are others. */
export class MapMarks extends EventTarget {
  /** @type {readonly Place[]} */
  places = [];
  /** @type {readonly Zone[]} */
  zones = [];
  /** @type {readonly Route[]} */
  routes = [];
  #revision = -1;
  #askedAt = -Infinity; // [ms]
  #busy = false;

  /** @param {Session} session */
  constructor(session) {
    super();
    session.on("hello", () => (this.#revision = -1));
    session.on("heard", ({ state }) => {
      if (state && state.map.marks !== this.#revision) void this.#read(state.map.marks);
    });
  }

  /** @param {number} revision */
  async #read(revision) {
    const now = performance.now();
    if (this.#busy || (revision === this.#revision && now - this.#askedAt < AGAIN_MS)) return;
    [this.#busy, this.#askedAt] = [true, now];
    try {
      const [places, zones, routes] = await Promise.all([call(PLACES), call(ZONES), call(ROUTES)]);
      [this.places, this.zones, this.routes] = [places.places, zones.zones, routes.routes];
      this.#revision = revision;
      this.dispatchEvent(new Event("change"));
    } catch {
      // asked again with one of the next states
    } finally {
      this.#busy = false;
    }
  }
}

/** @type {WeakMap<Session, MapMarks>} */
const known = new WeakMap();

/** The marks of a session: one reading for all panels. @param {Session} session @returns {MapMarks} */
export function marksOf(session) {
  const marks = known.get(session) ?? new MapMarks(session);
  known.set(session, marks);
  return marks;
}
