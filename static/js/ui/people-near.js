// Who is near the robot: in the simulator people who can be asked to speak, on a real robot the voices of the last minute.

import { post } from "../net/api.js";
import * as room from "../net/room-api.js";
import { icon, isNew, make, mark, onSubmit, write } from "./element.js";
import { inWords, metres } from "./format.js";
import { Near } from "./near.js";
import { t } from "./texts.js";

/** @import { Session, View } from "../net/session.js" */
/** @import { PersonInRoom } from "../net/rest.js" */

const ASK_MS = 2000;
const SENTENCES = ["come here", "follow me", "stop"];

export class PeopleNear extends HTMLElement {
  #session;
  #row = make("div.people-row", { role: "group", "aria-label": t("people-near.who_is_near") });
  #about = make("p.note", { hidden: true }, t("people-near.press_a_name"));
  #bubble = make("form.people-bubble", { hidden: true });
  #own = make("input.field-box", {
    type: "text",
    maxlength: "200",
    placeholder: t("people-near.own_words"),
    "aria-label": t("people-near.what_they_say"),
    autocomplete: "off",
  });
  #says = make("span.people-says");
  /** @type {PersonInRoom[]} */
  #people = [];
  #askedAt = -Infinity; // [ms]
  #near = new Near();
  #who = "";

  /** @param {Session} session */
  constructor(session) {
    super();
    this.#session = session;
    const own = make("button.button", { type: "submit" }, t("people-near.say"));
    this.#bubble.append(
      this.#says,
      ...SENTENCES.map((words) =>
        make("button.chip", { "data-says": words, onclick: () => void this.#speak(this.#who, words) }, words),
      ),
      make("button.chip", { onclick: () => void this.#walk() }, icon("follow_me"), t("people-near.walks_on")),
      make("span.people-own", this.#own, own),
    );
    onSubmit(this.#bubble, () => {
      const words = this.#own.value.trim();
      if (words) void this.#speak(this.#who, words);
      this.#own.value = "";
    });
    this.#bubble.addEventListener("keydown", (event) => event.key === "Escape" && this.#open(""));
    this.append(this.#about, this.#row, this.#bubble);
    addEventListener("person-press", (event) => {
      const { name } = /** @type {CustomEvent<{name: string}>} */ (event).detail; // pressed on the map
      if (!this.#people.some(({ id }) => id === name)) return;
      dispatchEvent(new CustomEvent("open-view", { detail: "voices" }));
      this.#open(name);
    });
    addEventListener("let-call", (event) => {
      const { words } = /** @type {CustomEvent<{words: string}>} */ (event).detail;
      const [first] = this.#people;
      if (first) void this.#speak(first.id, words);
    });
  }

  /** @param {View} view */
  show({ state, hello, up, permission }) {
    const simulated = hello?.robot.capabilities.includes("simulate") === true && state?.ears != null;
    const off = !up || permission.may === "no";
    if (!simulated && state) this.#tellNear(state, off || hello?.robot.drives !== true);
    this.#about.hidden = !simulated;
    if (simulated) this.hidden = this.#people.length === 0;
    if (!simulated || !state) return;
    const now = performance.now();
    if (up && !document.hidden && now - this.#askedAt > ASK_MS) {
      this.#askedAt = now;
      void room.people().then(
        (people) => {
          this.#people = people;
          dispatchEvent(new CustomEvent("room-people", { detail: people }));
        },
        () => undefined, // the link chip says that there is none
      );
    }
    const { x_m: x, y_m: y, heading_rad: heading } = state.pose;
    const rows = this.#people.map((one) => {
      const bearing = Math.atan2(one.y_m - y, one.x_m - x) - heading;
      const side = inWords(Math.atan2(Math.sin(bearing), Math.cos(bearing))).replace("to the ", "");
      return { id: one.id, where: `${metres(Math.hypot(one.x_m - x, one.y_m - y), 1)}, ${side}` };
    });
    this.#draw(rows, off);
  }

  /**
   * On a real robot: voices and people of the last minute, each of whom the robot can come to.
   * @param {import("../net/messages.js").State} state
   * @param {boolean} off
   */
  #tellNear(state, off) {
    const near = this.#near.saw(state);
    this.hidden = near.length === 0;
    if (isNew(this.#row, ...near.map(({ id }) => id))) {
      this.#row.replaceChildren(...near.map((one) => this.#sighting(one)));
    }
    for (const [index, button] of [...this.#row.querySelectorAll("button")].entries()) {
      const one = near[index];
      const note = button.querySelector(".note");
      if (one && note)
        write(note, t("people-near.inwords_age_s_ago", { inwords: inWords(one.azimuth), age: Math.round(one.age) }));
      button.disabled = off;
    }
  }

  /** @param {import("./near.js").Sighting} one */
  #sighting(one) {
    const button = make(
      "button.person-chip",
      { "data-near": one.id, title: t("people-near.come_to_this_one") },
      icon(one.seen ? "eye" : "voice"),
      make("span.person-name", one.seen ? t("people-near.seen") : t("people-near.voice")),
      make("span.note"),
    );
    button.addEventListener("click", () => {
      const towards_rad = this.#near.towards(one.id);
      if (towards_rad !== null)
        void this.#session.attempt(() => post("api/commands", { text: "come here", towards_rad }));
    });
    return button;
  }

  /** @param {{id: string, where: string}[]} rows @param {boolean} off */
  #draw(rows, off) {
    if (isNew(this.#row, ...rows.map(({ id }) => id))) {
      this.#row.replaceChildren(...rows.map(({ id }) => this.#person(id)));
      if (!rows.some(({ id }) => id === this.#who)) this.#open("");
    }
    for (const [index, button] of [...this.#row.querySelectorAll("button")].entries()) {
      const where = button.querySelector(".note");
      if (where) write(where, rows[index]?.where ?? "");
      button.disabled = off;
      mark(button, "aria-expanded", String(button.dataset["person"] === this.#who));
    }
    for (const button of this.#bubble.querySelectorAll("button")) button.disabled = off;
  }

  /** @param {string} id */
  #person(id) {
    return make(
      "button.person-chip",
      {
        "data-person": id,
        title: t("people-near.let_id_speak_to_the_robot", { id }),
        onclick: () => this.#open(this.#who === id ? "" : id),
      },
      icon("voice"),
      make("span.person-name", id),
      make("span.note"),
    );
  }

  /** @param {string} id "" for nobody */
  #open(id) {
    this.#who = id;
    this.#bubble.hidden = id === "";
    mark(this.#bubble, "aria-label", id ? t("people-near.what_id_says", { id }) : null);
    write(this.#says, t("people-near.id_says", { id }));
    if (id) this.scrollIntoView({ block: "nearest" });
  }

  async #walk() {
    const one = this.#people.find(({ id }) => id === this.#who);
    const pose = this.#session.state?.pose;
    if (one && pose) await this.#session.attempt(() => room.walk(one, pose));
  }

  /** @param {string} id @param {string} words */
  async #speak(id, words) {
    this.#session.announce(t("people-near.id_says_words", { id, words }));
    await this.#session.attempt(() => room.speak(id, words));
  }
}

customElements.define("people-near", PeopleNear);
