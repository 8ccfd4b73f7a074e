// Elements of the fleet's bar: how many robots are how, STOP ALL, and what is wrong with the fleet itself.
// Element <fleet-answers>: who has answered the newest STOP ALL, how quickly, and who has not.

import { icon, iconButton, isNew, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { onTouch } from "../ui/press.js";
import { t } from "../ui/texts.js";
import { GROUPS, groupOf, standsStill } from "./words.js";

/** @import { FleetStopState as Stop } from "../net/rest.js" */
/** @import { FleetSession } from "./fleet-session.js" */

const MANY = 8; // robots, from which on one may search

export class FleetCounts extends HTMLElement {
  /** @type {Map<string, HTMLButtonElement>} */
  #chips = new Map();
  #search = make("input.field-box.fleet-search", { type: "search", "aria-label": t("fleet.search"), hidden: true });

  /** @param {FleetSession} session @param {(group: string, words: string) => void} filter */
  join(session, filter) {
    this.#search.placeholder = t("fleet.search");
    for (const [group] of GROUPS) {
      const chip = make("button.chip.fleet-count", { "data-group": group });
      chip.setAttribute("aria-pressed", "false");
      chip.addEventListener("click", () => {
        const pressed = chip.getAttribute("aria-pressed") === "true";
        for (const one of this.#chips.values()) one.setAttribute("aria-pressed", "false");
        chip.setAttribute("aria-pressed", String(!pressed));
        this.#tell(filter);
      });
      this.#chips.set(group, chip);
      this.append(chip);
    }
    this.append(this.#search);
    this.#search.addEventListener("input", () => this.#tell(filter));
    session.on("changed", () => this.#show(session));
  }

  /** @param {(group: string, words: string) => void} filter */
  #tell(filter) {
    const chosen = [...this.#chips].find(([, chip]) => chip.getAttribute("aria-pressed") === "true");
    filter(chosen?.[0] ?? "", this.#search.value.trim().toLowerCase());
  }

  /** @param {FleetSession} session */
  #show({ fleet }) {
    const robots = fleet?.robots ?? [];
    this.#search.hidden = robots.length < MANY;
    for (const [group, name] of GROUPS) {
      const count = robots.filter((robot) => groupOf(robot) === group).length;
      const chip = this.#chips.get(group);
      if (!chip) continue;
      write(chip, group === "help" && count === 1 ? t("fleet.needs_help") : t("fleet.count", { count, name }));
      mark(chip, "hidden", count === 0 && chip.getAttribute("aria-pressed") !== "true");
    }
  }
}

export class FleetStop extends HTMLElement {
  /** @param {FleetSession} session */
  join(session) {
    const stop = make(
      "button.stop",
      { "aria-keyshortcuts": "Escape", title: t("fleet.stop_all_says") },
      icon("stop"),
      make("span.stop-words", make("span.stop-word", t("fleet.stop_all"))),
    );
    const halt = make(
      "button.button.fleet-halt",
      { title: t("fleet.halt_all_says"), onclick: () => void session.all("halt") },
      icon("halt"),
      make("span", t("fleet.halt_all")),
    );
    this.append(halt, stop);
    onTouch(stop, () => void session.all("stop"));
    addEventListener("keydown", (event) => {
      if (event.key === "Escape" && !event.repeat) void session.all("stop");
    });
    session.on("changed", () => {
      mark(stop, "data-unlinked", !session.up);
      mark(stop, "data-still", session.up && session.fleet?.robots.every(standsStill) === true);
    });
  }
}

export class FleetBanner extends HTMLElement {
  #words = make("p", { role: "alert" });
  #halted = make("p", { role: "status" });
  #reset = make("button.button", t("fleet.reset_halt"));
  #says = make("p.note", t("fleet.reset_says"));
  #box = make("div.fleet-halted", icon("halt"), make("div", this.#halted, this.#says), this.#reset);

  /** @param {FleetSession} session */
  join(session) {
    this.append(this.#words, this.#box);
    this.#reset.addEventListener("click", () => void session.all("halt/reset"));
    const show = () => this.#show(session);
    session.on("changed", show);
    setInterval(show, 500);
    show();
  }

  /** @param {FleetSession} session */
  #show(session) {
    const { fleet, up, trouble, you, silence } = session;
    const lost = fleet !== null && !up ? t("fleet.no_answer", { age: age(silence) }) : "";
    const words = lost || trouble || fleet?.trouble || "";
    write(this.#words, words);
    mark(this.#words, "hidden", words === "");
    document.body.classList.toggle("is-lost", fleet !== null && !up);
    const halt = fleet?.halt ?? null;
    mark(this.#box, "hidden", halt === null);
    if (halt && fleet)
      write(this.#halted, t("fleet.halted_by", { name: halt.by, age: age(fleet.time_s - halt.since_s) }));
    mark(this.#reset, "hidden", you?.role === "viewer");
  }
}

customElements.define("fleet-counts", FleetCounts);
customElements.define("fleet-stop", FleetStop);
customElements.define("fleet-banner", FleetBanner);

/** @type {Readonly<Record<string, string>>} */
const LINKS = { live: t("fleet.link_live"), stale: t("fleet.link_stale"), gone: t("fleet.link_gone") };
const SHOWN_S = 60; // after a stop that everybody has answered

export class FleetAnswers extends HTMLElement {
  #icon = icon("stop");
  #head = make("strong");
  #missing = make("p.fleet-missing", { role: "alert" });
  #list = make("ul.fleet-times");
  #closed = 0; // Unix time of the stop that was put away

  /** @param {FleetSession} session */
  join(session) {
    const away = iconButton("close", t("fleet.put_away"), () => {
      this.#closed = session.fleet?.stop?.at_s ?? 0;
      this.hidden = true;
    });
    this.append(
      make("div.inline.fleet-answers-head", this.#icon, this.#head, make("span.spring"), away),
      this.#missing,
      this.#list,
    );
    session.on("changed", () => this.#show(session));
    session.on("answered", () => {
      if (session.fleet?.stop) session.announce(summary(session.fleet.stop, 0));
      this.#show(session);
    });
  }

  /** @param {FleetSession} session */
  #show({ fleet }) {
    const stop = fleet?.stop ?? null;
    const old = stop?.all === true && (fleet?.time_s ?? 0) - stop.at_s > SHOWN_S;
    this.hidden = stop === null || old || stop.at_s === this.#closed;
    if (!stop || !fleet) return;
    const missing = stop.robots.filter((one) => !one.acknowledged);
    redraw(this.#icon, missing.length ? "warning" : "done");
    mark(this, "data-missing", missing.length > 0);
    write(this.#head, summary(stop, fleet.time_s - stop.at_s));
    mark(this.#missing, "hidden", missing.length === 0);
    const names = missing.map((one) => `${one.name} (${LINKS[one.link] ?? one.link})`).join(", ");
    write(this.#missing, missing.length ? t(stop.asking ? "fleet.missing_asking" : "fleet.missing", { names }) : "");
    const rows = stop.robots
      .filter((one) => one.acknowledged)
      .toSorted((one, other) => (other.ms ?? 0) - (one.ms ?? 0))
      .map((one) => t("fleet.answer_ms", { name: one.name, ms: fixed(one.ms ?? 0, 0) }));
    if (isNew(this.#list, rows)) this.#list.replaceChildren(...rows.map((row) => make("li", row)));
  }
}

/** @param {Stop} stop @param {number} ago [s] */
function summary(stop, ago) {
  const stand = stop.robots.filter((one) => one.acknowledged).length;
  const values = { stand, of: stop.robots.length, name: stop.by, age: age(ago) };
  return stop.kind === "halt" ? t("fleet.halt_summary", values) : t("fleet.stop_summary", values);
}

customElements.define("fleet-answers", FleetAnswers);
