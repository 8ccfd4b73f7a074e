// Element <fleet-answers>: who has answered the newest STOP ALL, how quickly, and who has not.

import { icon, iconButton, isNew, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { FleetSession } from "./fleet-session.js" */
/** @import { FleetStopState as Stop } from "../net/rest.js" */

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
    session.on("answered", () => this.#announce(session));
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

  /** @param {FleetSession} session */
  #announce(session) {
    const { fleet } = session;
    if (fleet?.stop) session.announce(summary(fleet.stop, 0));
    this.#show(session);
  }
}

/** @param {Stop} stop @param {number} ago [s] */
function summary(stop, ago) {
  const stand = stop.robots.filter((one) => one.acknowledged).length;
  const values = { stand, of: stop.robots.length, name: stop.by, age: age(ago) };
  return stop.kind === "halt" ? t("fleet.halt_summary", values) : t("fleet.stop_summary", values);
}

customElements.define("fleet-answers", FleetAnswers);
