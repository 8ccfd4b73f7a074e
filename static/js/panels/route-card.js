// Element <route-card>: the routes of the map, one in the making, and how the one under way goes.

import {
  addRoute,
  marksOf,
  removeRoute,
  routePicture,
  routeProgress,
  startRoute,
  steerRoute,
  troubleAt,
} from "../net/marks-api.js";
import { iconButton, isNew, make, nameField, numberField, onSubmit, write } from "../ui/element.js";
import { timeOfDay } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { refill } from "../ui/press.js";
import { inLanguage, t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";
import { remover } from "./place-list.js";

/** @import { Route, Stop } from "../net/marks-api.js" */
/** @import { RouteUnderWay } from "../net/messages.js" */
/** @import { RouteNote } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

const STEERS = /** @type {const} */ (["pause", "resume", "skip", "stop"]);
/** @type {Readonly<Record<string, string>>} */
const STEER_WORDS = {
  pause: t("route-card.pause"),
  resume: t("route-card.go_on"),
  skip: t("route-card.skip"),
  stop: t("route-card.end"),
};
/** @type {Readonly<Record<RouteUnderWay["state"], string>>} */
const STATES = {
  idle: "",
  driving: t("route-card.drives_to"),
  waiting: t("route-card.waits_at"),
  paused: t("route-card.paused_before"),
  ended: t("route-card.ended_at"),
};
/** @type {ReadonlyArray<readonly [Stop["action"], string]>} */
const ACTIONS = [
  [null, t("route-card.only_wait")],
  ["wait_for_continue", t("route-card.until_go_on")],
  ["come_here", t("route-card.come_here")],
  ["say", t("route-card.say")],
  ["take_a_picture", t("route-card.take_a_picture")],
  ["record", t("route-card.record")],
];
/** Which buttons make sense in which state. @type {Readonly<Record<string, readonly string[]>>} */
const MAY = {
  driving: ["pause", "skip", "stop"],
  waiting: ["pause", "resume", "skip", "stop"],
  paused: STEERS.slice(1),
};

/** A route that runs or stands, in words: "round drives to desk (1 of 2)". @param {RouteUnderWay} route */
export const routeWords = ({ name, stop, of, state, place }) =>
  t("route-card.name_doing_place", { name, doing: STATES[state], place, stop, of });

/** @type {Route} */
const NEW = { name: "", stops: [], loop: false };

/** What is said of a stop without a remark. @type {Readonly<Record<string, string>>} */
const NOTED = { done: t("route-card.reached"), skipped: t("route-card.left_out"), failed: t("state.failed") };

/** @param {RouteNote} note */
function noteRow({ at_s: at, place, state, remark, picture }) {
  const words = inLanguage(remark) || NOTED[state];
  const look = { src: routePicture(picture), alt: t("route-card.picture_at_place", { place }), loading: "lazy" };
  return make(
    "li.row.route-note",
    make("span.note", timeOfDay(at)),
    make("span.place-name", place),
    picture
      ? make("a", { href: routePicture(picture), target: "_blank" }, make("img.route-picture", look))
      : make("span", words ?? state),
  );
}

class RouteCard extends Panel {
  #now = make("p.route-now", { role: "status" });
  #why = make("p.note");
  #notes = make("ol.route-notes", { "aria-label": t("route-card.what_happened") });
  /** @type {number | null} when what was noted last was noted */
  #notedAt = null;
  /** @type {Map<string, HTMLButtonElement>} */
  #steers = new Map();
  #under = make("div.route-under", { hidden: true });
  #list = make("ul.places", { "aria-label": t("route-card.routes") });
  #empty = make("p.note", t("route-card.none_yet"));
  #new = make("button.button", t("route-card.new_route"));
  #name = nameField(t("route-card.name_of_the_route"));
  #stops = make("ol.route-stops", { "aria-label": t("route-card.stops") });
  #choice = make("select.field-box", { "aria-label": t("route-card.add_a_stop") });
  #loop = make("input", { type: "checkbox", onchange: () => (this.#hours.hidden = !this.#loop.checked) });
  #begins = make("input.field-box.route-wait", { type: "time", "aria-label": t("route-card.rounds_from") });
  #ends = make("input.field-box.route-wait", { type: "time", "aria-label": t("route-card.rounds_until") });
  #every = numberField(t("route-card.minutes_between_rounds"), { min: 0, max: 1440, value: 0 }, "route-wait");
  #hours = make(
    "div.row.route-acts",
    { hidden: true },
    make("label.inline", t("route-card.rounds_from"), this.#begins),
    make("label.inline", t("route-card.rounds_until"), this.#ends),
    make("label.inline", t("route-card.every"), this.#every, "min"),
  );
  #save = make("button.button.primary", { type: "submit" }, t("place-sheet.save"));
  #trouble = new TroubleLine();
  #form = make("form.route-form", { hidden: true });
  /** @type {Stop[]} of the route in the making */
  #made = [];
  #operates = false;
  #changes = ""; // name of the route that is changed; "": a new one is made
  #dragged = -1; // index of the stop that is dragged

  /** @override */
  build() {
    const steers = STEERS.map((act) => {
      const button = make("button.button", STEER_WORDS[act] ?? act);
      button.addEventListener("click", () => void this.#trouble.attempt(() => steerRoute(act)));
      this.#steers.set(act, button);
      return button;
    });
    this.#under.append(this.#now, this.#why, make("div.row.route-acts", ...steers), this.#notes);
    this.#form.append(
      this.#name,
      this.#stops,
      this.#choice,
      make("label.inline.place-turns", this.#loop, t("route-card.round_and_round")),
      this.#hours,
      this.#save,
    );
    this.append(
      make("div.inline.slam-head", make("h3", t("route-card.routes")), make("span.spring"), this.#new),
      this.#trouble.element,
      this.#empty,
      this.#list,
      this.#under, // below: its End does not come to where Start was pressed
      this.#form,
    );
    this.#new.addEventListener("click", () => {
      const shut = !this.#form.hidden && !this.#changes;
      if (this.#changes) this.#lay(NEW);
      if (shut) this.#form.hidden = true;
      else this.#openForm();
    });
    this.#choice.addEventListener("change", () => {
      if (this.#choice.value) this.#made.push({ place: this.#choice.value, wait_s: 0, action: null });
      this.#drawForm();
    });
    onSubmit(this.#form, () => void this.#keep());
    addEventListener("place-pressed", (event) => {
      if (this.#form.hidden || this.offsetParent === null) return;
      event.preventDefault(); // a press on the map adds a place to the route that is being made, and moves nothing
      const { detail: place } = /** @type {CustomEvent<string | null>} */ (event);
      this.#trouble.say(place ? "" : t("route-card.no_place_there"));
      if (place) this.#made.push({ place, wait_s: 0, action: null });
      this.#drawForm();
    });
    marksOf(this.session).addEventListener("change", () => this.#draw());
  }

  /** @override @param {View} view */
  show({ hello, state, up }) {
    this.#operates = hello !== null && hello.you.role !== "viewer" && hello.robot.drives;
    this.#new.hidden = !this.#operates;
    this.#draw();
    for (const button of this.querySelectorAll("button")) if (button !== this.#save) button.disabled = !up;
    const route = state?.route;
    const gone = route?.state === "ended" && !marksOf(this.session).routes.some(({ name }) => name === route.name);
    this.#under.hidden = !route || gone; // one of another map
    if (!route) return;
    write(this.#now, routeWords(route));
    write(this.#why, route.reason);
    if (this.offsetParent && route.noted_at_s !== this.#notedAt) void this.#readNotes(route.noted_at_s);
    for (const [act, button] of this.#steers)
      button.hidden = !(MAY[route.state] ?? []).includes(act) || (!this.#operates && act !== "stop");
  }

  /** What happened at each stop, the newest first. @param {number | null} notedAt */
  async #readNotes(notedAt) {
    this.#notedAt = notedAt;
    const { notes } = notedAt === null ? { notes: [] } : await routeProgress().catch(() => ({ notes: [] }));
    if (notedAt === this.#notedAt) refill(this.#notes, ...notes.map(noteRow).reverse());
  }

  #draw() {
    const { routes, places, zones } = marksOf(this.session);
    if (!isNew(this, routes, places, zones, this.#operates)) return;
    this.#empty.hidden = routes.length > 0;
    refill(this.#list, ...routes.map((route) => this.#row(route)));
    this.#drawForm();
  }

  /** @param {Route} route that is laid into the form */
  #lay({ name, stops, loop, begins = "", ends = "", every_min: every = 0 }) {
    [this.#changes, this.#name.value, this.#loop.checked] = [name, name, loop];
    [this.#begins.value, this.#ends.value, this.#every.value] = [begins, ends, String(every)];
    this.#made = stops.map((stop) => ({ ...stop }));
    this.#hours.hidden = !loop;
    this.#drawForm();
  }

  /** @param {Route} route */
  #row(route) {
    const { name, stops, loop } = route;
    const way = stops.map(({ place }) => place).join(" → ");
    const start = make("button.button", { "aria-label": t("route-card.start_name", { name }) }, t("route-card.start"));
    start.addEventListener("click", () => void this.#trouble.attempt(() => startRoute(name)));
    const away = remover(name, () => this.#trouble.attempt(() => removeRoute(name)));
    const does = stops.map(({ place, wait_s: wait, action }) => {
      const does = [wait > 0 && `${wait} s`, action && ACTIONS.find(([one]) => one === action)?.[1]].filter(Boolean);
      return does.length && `${place}: ${does.join(", ")}`;
    });
    const trouble = stops.map(({ place }) => troubleAt(place, marksOf(this.session))).filter(Boolean);
    const body = make(
      "div.place-body",
      make("p.place-name", name),
      make("p.note", loop ? t("route-card.way_again_and_again", { way }) : way),
      make("p.note", does.filter(Boolean).join(" · ")),
      trouble.length > 0 && make("p.note.route-trouble", [...new Set(trouble)].join(" ")),
    );
    const change = () => {
      this.#lay(route);
      this.#openForm();
    };
    const more = { title: t("place-list.change"), look: "small" };
    const edit = iconButton("pencil", t("route-card.change_name", { name }), change, more);
    return make("li.row.place", body, ...(this.#operates ? [start, edit, away] : []));
  }

  #openForm() {
    this.#form.hidden = false;
    this.#name.focus({ preventScroll: true });
    this.#form.scrollIntoView({ block: "nearest" });
  }

  #drawForm() {
    const { places } = marksOf(this.session);
    refill(
      this.#choice,
      make("option", { value: "" }, t("route-card.add_a_stop")),
      ...places.map(({ name }) => make("option", { value: name }, name)),
    );
    refill(this.#stops, ...this.#made.map((stop, index) => this.#stopRow(stop, index)));
    this.#save.disabled = this.#made.length === 0;
    if (!this.#form.hidden) this.#save.scrollIntoView({ block: "nearest" }); // a stop more has pushed it down
  }

  /** @param {Stop} stop @param {number} index */
  #stopRow(stop, index) {
    const { place } = stop;
    const bounds = { min: 0, max: 3600, step: "any", value: stop.wait_s };
    const wait = numberField(t("route-card.seconds_at_place", { place }), bounds, "route-wait");
    wait.addEventListener("input", () => (stop.wait_s = wait.valueAsNumber || 0));
    const action = make(
      "select.field-box",
      { "aria-label": t("route-card.action_at_place", { place }) },
      ...ACTIONS.map(([value, words]) => make("option", { value: value ?? "" }, words)),
    );
    const words = t("route-card.words_at_place", { place });
    const more = { maxlength: "280", value: stop.text ?? "", placeholder: "" };
    const text = nameField(words, more);
    text.hidden = stop.action !== "say";
    text.addEventListener("input", () => (stop.text = text.value));
    action.value = stop.action ?? "";
    action.addEventListener("change", () => {
      stop.action = /** @type {Stop["action"]} */ (action.value || null);
      text.hidden = stop.action !== "say";
    });
    const earlier = t("route-card.place_earlier", { place });
    const away = t("place-list.remove_name", { name: stop.place });
    const drop = () => {
      this.#made.splice(index, 1);
      this.#drawForm();
    };
    const row = make(
      "li.row.route-stop",
      { draggable: "true" },
      make("span.place-name", stop.place),
      iconButton("chevron", earlier, () => this.#move(index, index - 1), { title: earlier, look: "small turned" }),
      iconButton("close", away, drop, { title: away, look: "small" }),
      make("span.inline", t("route-card.wait"), wait, "s"),
      action,
      text,
      make("p.note.route-trouble", troubleAt(place, marksOf(this.session))),
    );
    row.addEventListener("dragover", (event) => event.preventDefault());
    row.addEventListener("dragstart", (event) => {
      this.#dragged = index;
      event.dataTransfer?.setData("text/plain", stop.place); // without it, Firefox drags nothing
    });
    row.addEventListener("drop", (event) => {
      event.preventDefault();
      this.#move(this.#dragged, index);
    });
    return row;
  }

  /** @param {number} from @param {number} to */
  #move(from, to) {
    if (from < 0 || to < 0 || from === to) return;
    this.#made.splice(to, 0, ...this.#made.splice(from, 1));
    this.#drawForm();
  }

  async #keep() {
    const name = this.#name.value.trim();
    if (!name) {
      this.#trouble.say(t("place-sheet.a_name_is_missing"));
      this.#name.focus();
      return;
    }
    const loop = this.#loop.checked;
    const [begins, ends] = loop ? [this.#begins.value, this.#ends.value] : ["", ""];
    const every = loop ? this.#every.valueAsNumber || 0 : 0;
    const replace = name === this.#changes;
    const made = { name, stops: this.#made, loop, begins, ends, every_min: every, replace };
    if (!(await this.#trouble.attempt(() => addRoute(made), this.#save))) return;
    this.#lay(NEW);
    this.#form.hidden = true;
    this.#new.scrollIntoView({ block: "nearest" }); // the form was long: the new route is above it
  }
}

customElements.define("route-card", RouteCard);
