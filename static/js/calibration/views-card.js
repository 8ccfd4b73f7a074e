// Element <views-card>: views of a session, largest error first, with a button to leave each out.

import { iconButton, isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { meter } from "../ui/meter.js";
import { inLanguage, t } from "../ui/texts.js";
import * as api from "./api.js";

/** @import { CalibrationModel } from "./calibration-model.js" */
/** @import { Calibration, ViewRow } from "./types.js" */

export class ViewsCard extends HTMLElement {
  #title = make("h2.card-title");
  #list = make("ul.views.rows");
  #empty = make("p.note");
  #note = make("p.note.views-note");
  /** @type {CalibrationModel | null} */
  #model = null;
  /** @type {(name: string) => void} */
  chosen = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(make("div.card-head", this.#title, make("span.spring"), this.#note), this.#empty, this.#list);
  }

  /**
   * @param {CalibrationModel} model
   * @param {Calibration} calibration
   * @param {string} [selected] a view shown elsewhere
   */
  show(model, calibration, selected = "") {
    this.#model = model;
    const { views, kind, id } = calibration;
    if (!isNew(this, views, id, model.may, selected)) return;
    const word = kind === "camera" ? "view" : "pose";
    write(this.#title, inLanguage(`${views.length} ${word}${views.length === 1 ? "" : "s"}`));
    const solved = views.some((view) => errorOf(view) !== null);
    write(this.#note, solved ? t("views-card.worst_first") : "");
    write(
      this.#empty,
      kind === "camera"
        ? t("views-card.every_view_that_counts_appears_here")
        : t("views-card.every_pose_that_counts_appears_here"),
    );
    this.#empty.hidden = views.length > 0;
    const worst = Math.max(...views.map((view) => errorOf(view) ?? 0), 1e-9);
    const rows = new Map([...this.#list.children].map((row) => [row.getAttribute("data-name"), row]));
    const held = this.contains(document.activeElement) ? document.activeElement : null;
    const focused = held?.closest("[data-name]")?.getAttribute("data-name") ?? "";
    this.#list.replaceChildren(
      ...views.map((view) => this.#row(view, worst, calibration, rows.get(view.name), selected)),
    );
    const again = [...this.#list.children].find((row) => row.getAttribute("data-name") === focused);
    /** @type {HTMLElement | null | undefined} */ (again?.querySelector(".view-keep"))?.focus({ preventScroll: true });
  }

  /**
   * @param {ViewRow} view
   * @param {number} worst error of them all
   * @param {Calibration} calibration
   * @param {Element | undefined} old the row it had: its picture is kept
   * @param {string} selected
   */
  #row(view, worst, { id, kind }, old, selected) {
    const source = api.thumbnail(id, view.name);
    const kept = old?.querySelector("img");
    const picture =
      kept?.src === source
        ? kept
        : make("img", { src: source, alt: "", loading: "lazy", decoding: "async", width: "80", height: "60" });
    const error = errorOf(view);
    const bar = meter("div.meter", { "aria-hidden": "true" });
    bar.set((error ?? 0) / worst);
    const why = view.dropped
      ? t("views-card.left_out_by_you")
      : view.used
        ? ""
        : inLanguage(view.reason) || t("views-card.not_in_the_solution_yet");
    const open = make(
      "button.row-open.view-open",
      {
        "aria-pressed": kind === "camera" ? String(view.name === selected) : null,
        onclick: () => this.chosen(view.name),
      },
      picture,
      make(
        "span.view-words",
        make("span.view-name", inLanguage(view.name)),
        make("span.view-error", error === null ? "" : inUnits(error, kind)),
        bar.element,
        why && make("span.note", why),
      ),
    );
    const action = view.dropped ? "restore" : "drop";
    const says = view.dropped ? t("views-card.take_back") : t("views-card.leave_out");
    const title = view.dropped ? t("views-card.take_it_back_in") : t("views-card.leave_it_out");
    const act = () => void this.#model?.request((session) => api.keep(session, view.name, action));
    const drawing = view.dropped ? "again" : "close";
    const keep = iconButton(drawing, `${says}: ${inLanguage(view.name)}`, act, { title, look: "small view-keep" });
    const row = make("li.view", { "data-name": view.name }, open, this.#model?.may && keep);
    mark(row, "data-dropped", view.dropped);
    mark(row, "data-unused", !view.used && !view.dropped && view.reason !== "");
    return row;
  }
}

/** @param {ViewRow} view @returns {number | null} [px] or [m] */
export const errorOf = (view) => view.rms_px ?? view.rms_m ?? null;

/** @param {number} error [px] or [m] @param {"camera" | "laser"} kind */
export const inUnits = (error, kind) => (kind === "camera" ? `${fixed(error, 2)} px` : `${fixed(1e3 * error, 1)} mm`);

customElements.define("views-card", ViewsCard);
