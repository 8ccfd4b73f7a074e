// Element <tour-guide>: ninety seconds in which the simulator shows what the robot does. Any key ends it.

import { call, obeyVoices, post, send } from "../net/api.js";
import * as room from "../net/room-api.js";
import { isNew, make, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { placed } from "../ui/placement.js";
import { t } from "../ui/texts.js";
import { Tour } from "../ui/tour.js";

/** @import { HistoryRow, PeopleState } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

const [CALLER, OTHER] = ["Ann", "Bob"];
const DRIVES_MS = 1800; // for which the key is held
const TURNS_MS = 1200; // before STOP

class TourGuide extends Panel {
  #title = make("h2.card-title");
  #text = make("p");
  #count = make("span.note");
  #end = make("button.button", { onclick: () => this.#tour?.end() }, t("tour-guide.end_the_tour"));
  #card = make(
    "div.tour.card",
    { role: "region", "aria-label": t("tour-guide.tour"), hidden: true },
    this.#title,
    this.#text,
    make("div.coach-foot", this.#count, make("span.spring"), this.#end),
  );
  /** @type {Tour | null} */
  #tour = null;
  #ownStop = false;
  /** @type {string | null} whom the robot came to before */
  #chosen = null;
  #at = ".over"; // selector of what the step shows
  #taught = ""; // id of the person whom the tour made known
  #chose = false; // the tour has chosen to whom the robot comes

  /** @override */
  build() {
    this.append(this.#card);
    addEventListener("show-tour", () => void this.#begin());
    addEventListener(
      "keydown",
      (event) => {
        if (!this.#tour || !event.isTrusted) return;
        this.#tour.end();
        this.session.stop();
      },
      true,
    );
    this.session.on("stopped", () => this.#ownStop || this.#tour?.end());
  }

  /** @override @param {View} view */
  show({ permission }) {
    if (this.#tour && permission.may === "no") this.#tour.end();
    if (!this.#card.hidden) this.#place();
  }

  /** Leave free what the step shows, STOP, and where there is room the camera as well. */
  #place() {
    const [target, stop, camera] = [this.#at, ".stop", "camera-view"].map((at) => box(at));
    const shown = target ?? box(".over");
    if (!shown || !stop) return;
    const { width, height } = this.#card.getBoundingClientRect();
    if (!isNew(this, shown, stop, camera, width, height, innerWidth, innerHeight)) return;
    const { left, top } = placed(
      shown,
      { width, height },
      { width: innerWidth, height: innerHeight },
      stop,
      camera ? [camera] : [],
    );
    this.#card.style.left = `${left}px`;
    this.#card.style.top = `${top}px`;
  }

  async #begin() {
    if (this.#tour) return;
    const tour = new Tour(this.#steps(), (stop, index, count) => {
      this.#at = stop.at;
      write(this.#title, stop.title);
      write(this.#text, stop.text);
      write(this.#count, t("tour-guide.index_of_count_any_key_ends", { index: index + 1, count }));
      this.#place();
      this.session.announce(`${stop.title}. ${stop.text}`);
    });
    this.#tour = tour;
    this.#card.hidden = false;
    dispatchEvent(new CustomEvent("open-view", { detail: "map" }));
    void this.session.attempt(() => obeyVoices(true)); // what reads words takes seconds to start
    const whole = await tour.run();
    await this.#forget();
    if (whole) await tour.pause(6000);
    this.#tour = null;
    this.#card.hidden = true;
  }

  /** @returns {import("../ui/tour.js").Stop[]} */
  #steps() {
    const start = this.session.state?.pose;
    const home = `stop at ${(start?.x_m ?? 0).toFixed(2)} and ${(start?.y_m ?? 0).toFixed(2)}`;
    return [
      {
        title: t("tour-guide.teach_it_a_person"),
        at: "camera-view",
        text: t("tour-guide.caller_shows_herself_to_the_camera", { caller: CALLER }),
        act: (tour) => this.#teach(tour),
      },
      {
        title: t("tour-guide.turn"),
        at: "command-chips",
        text: t("tour-guide.a_button_typed_words_or_a"),
        act: (tour) => this.#tell(tour, "turn left", "chip"),
      },
      {
        title: t("tour-guide.drive"),
        at: "drive-pad",
        text: t("tour-guide.hold_w_the_stick_or_a"),
        act: (tour) => this.#drive(tour),
      },
      {
        title: t("tour-guide.click"),
        at: ".over",
        text: t("tour-guide.click_the_floor_it_plans_a"),
        act: (tour) => this.#tell(tour, home, "click"),
      },
      {
        title: t("tour-guide.caller_calls", { caller: CALLER }),
        at: ".over",
        text: t("tour-guide.it_hears_from_where_turns_looks"),
        act: (tour) => this.#call(tour, CALLER, 2),
      },
      {
        title: t("tour-guide.other_calls", { other: OTHER }),
        at: ".over",
        text: t("tour-guide.he_is_not_caller_to_whom", { caller: CALLER }),
        act: (tour) => (this.#chose || this.#chosen ? this.#call(tour, OTHER, 1) : tour.pause(0)),
      },
      {
        title: t("tour-guide.stop"),
        at: ".stop",
        text: t("tour-guide.esc_space_or_the_red_button"),
        act: (tour) => this.#stop(tour),
      },
      {
        title: t("tour-guide.now_you"),
        at: ".over",
        text: t("tour-guide.press_a_button_click_the_floor"),
        act: async () => undefined,
      },
    ];
  }

  /** @param {Tour} tour @param {string} words @param {"chip" | "click"} source */
  async #tell(tour, words, source) {
    const answer = await this.session.say(words, source);
    const { id } = answer;
    if (answer.ok && id) await tour.until(() => this.#row(id)?.state !== "running" && this.#row(id) !== undefined);
  }

  /** @param {Tour} tour */
  async #drive(tour) {
    const press = (/** @type {string} */ type) =>
      document.body.dispatchEvent(new KeyboardEvent(type, { code: "KeyW", key: "w", bubbles: true }));
    press("keydown");
    await tour.pause(DRIVES_MS);
    press("keyup");
    await tour.until(() => Math.abs(this.session.state?.velocity.v_m_s ?? 0) < 0.02);
  }

  /**
   * Let someone call, and wait for what comes of it.
   * @param {Tour} tour
   * @param {string} who
   * @param {number} tries
   */
  async #call(tour, who, tries) {
    for (let left = tries; left > 0 && !tour.over; left -= 1) {
      const before = this.session.history[0]?.id ?? 0;
      if (!(await this.session.attempt(() => room.speak(who, "come here")))) return;
      /** @type {HistoryRow | undefined} */
      let row;
      await tour.until(() => {
        row = this.session.history.find(({ id, source }) => id > before && source === "ears");
        return row !== undefined && row.state !== "running";
      });
      if (row?.state === "done") return;
    }
  }

  /** @param {Tour} tour */
  async #stop(tour) {
    await this.session.say("turn left", "chip");
    await tour.pause(TURNS_MS);
    this.#ownStop = true;
    if (!tour.over) this.session.stop();
    await tour.pause(500);
    this.#ownStop = false;
  }

  /** Make the caller known, and come to her alone. @param {Tour} tour */
  async #teach(tour) {
    /** @type {PeopleState} */
    const before = await call("api/people");
    const known = before.people.find(({ name }) => name === CALLER);
    this.#chosen = before.chosen;
    const id = known?.id ?? (await this.#enroll(tour));
    if (!known) this.#taught = id;
    if (!id || tour.over) return;
    this.#chose = true;
    await this.#choose(id);
  }

  /** @param {Tour} tour @returns {Promise<string>} id; "" when it did not succeed */
  async #enroll(tour) {
    const enrollment = await post("api/people");
    const path = `api/people/${enrollment.id}`;
    await post(`${path}/demo`, { on: true, inhabitant: CALLER });
    /** @type {PeopleState | null} */
    let now = null;
    await tour.until(async () => {
      now = await call("api/people");
      return now?.enrollment?.demo !== true;
    });
    const { ready } = /** @type {PeopleState | null} */ (now)?.enrollment ?? { ready: false };
    if (ready && !tour.over && (await this.session.attempt(() => post(`${path}/finish`, { name: CALLER }))))
      return enrollment.id;
    await call(path, { method: "DELETE" }).catch(() => undefined); // it is over already
    return "";
  }

  /** Come to whom it came before, and forget whom only the tour made known. */
  async #forget() {
    const [taught, chose] = [this.#taught, this.#chose];
    [this.#taught, this.#chose] = ["", false];
    if (chose) await this.session.attempt(() => this.#choose(this.#chosen));
    if (taught) await this.session.attempt(() => call(`api/people/${taught}`, { method: "DELETE" }));
  }

  /** @param {string | null} id */
  #choose(id) {
    return send("api/people/chosen", "PUT", { id });
  }

  /** @param {number} id */
  #row(id) {
    return this.session.history.find((row) => row.id === id);
  }
}

/** @param {string} at selector @returns {DOMRect | undefined} its place, where it is shown */
function box(at) {
  const element = document.querySelector(at);
  return element?.getClientRects().length ? element.getBoundingClientRect() : undefined;
}

customElements.define("tour-guide", TourGuide);
