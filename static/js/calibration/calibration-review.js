// Review step: precision, views, residuals and changes of a solution, and the decision to use it.

import { sentenceOf } from "../net/api.js";
import { sure } from "../ui/confirm-button.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import * as api from "./api.js";
import { BeforeAfter } from "./before-after.js";
import { ExportsCard } from "./exports-card.js";
import { FieldsCard } from "./fields-card.js";
import { FindingsCard } from "./findings-card.js";
import { GainsCard } from "./precision-card.js";
import { ValuesCard } from "./values-card.js";
import { ViewsCard } from "./views-card.js";
import { WizardStep } from "./wizard-step.js";

/** @typedef {import("./types.js").Calibration} Calibration */

class CalibrationReview extends WizardStep {
  #sign = icon("done");
  #title = make("h2", { class: "review-title", tabindex: "-1" });
  #words = make("p", { class: "review-words" });
  #accept = make("button", { type: "button", class: "button primary large" }, "Use this calibration");
  #force = make("button", { type: "button", class: "button" }, "Use it anyway");
  #more = make("button", { type: "button", class: "button" }, "Take more views");
  #again = make("button", { type: "button", class: "button" }, "Solve again");
  #undo = make("button", { type: "button", class: "button" }, "Take the former one back");
  #next = make("a", { class: "button primary large", href: "#new=laser" }, "Now the laser");
  #says = make("p", { class: "review-says", role: "alert" });
  #head = make(
    "header",
    { class: "card review-head" },
    make("span", { class: "review-sign" }, this.#sign),
    make("div", { class: "review-text" }, this.#title, this.#words, this.#says),
    make(
      "div",
      { class: "review-buttons" },
      this.#accept,
      this.#force,
      this.#next,
      this.#more,
      this.#again,
      this.#undo,
    ),
  );
  #values = new ValuesCard();
  #views = new ViewsCard();
  #fields = new FieldsCard();
  #both = new BeforeAfter();
  #precision = new GainsCard();
  #findings = new FindingsCard();
  #exports = new ExportsCard();
  #selected = "";
  #refused = "";

  /** @override */
  build() {
    this.append(
      make(
        "div",
        { class: "review" },
        this.#head,
        make("div", { class: "review-column" }, this.#values, this.#exports),
        make("div", { class: "review-column is-wide" }, this.#both, this.#precision, this.#fields, this.#findings),
        make("div", { class: "review-column" }, this.#views),
      ),
    );
    const { model } = this;
    this.#accept.addEventListener("click", () => void this.#use(false));
    this.#force.addEventListener("click", () => void this.#use(true));
    this.#again.addEventListener("click", () => void model.request(api.solve));
    this.#more.addEventListener(
      "click",
      () => model.calibration && model.go({ at: "capture", id: model.calibration.id }),
    );
    this.#undo.addEventListener(
      "click",
      () => sure(this.#undo, "Press again to take it back") && void this.#takeBack(),
    );
    this.#views.chosen = (name) => {
      this.#selected = name;
      this.draw();
    };
  }

  /** @override */
  opened() {
    this.#selected = this.#refused = "";
    this.draw();
    this.#title.focus({ preventScroll: true });
  }

  /** @override */
  draw() {
    const { calibration, may } = this.model;
    if (!calibration) return;
    const { kind, progress, views, solution, solving } = calibration;
    const { used } = this.model;
    const older = !used && typeof calibration.accepted_s === "number";
    const good = progress.ready;
    const word = kind === "camera" ? "view" : "pose";
    mark(this.#head, "data-state", used ? "used" : good ? "good" : "open");
    redraw(this.#sign, used || good ? "done" : "estimate");
    write(
      this.#title,
      used ? "In use" : good ? "Good enough to be used" : solution ? "Not yet exact enough" : "No solution yet",
    );
    const former = calibration.active_compare ? KEPT : "";
    const foreign = solution && kind === "camera" ? FOREIGN[calibration.source] : "";
    write(this.#words, solving ? `${solving.words} …` : `${progress.words}${used ? former : older ? OTHER : foreign}`);
    write(this.#says, may ? this.#refused : "You are watching. Only an operator can decide.");
    this.#accept.hidden = !may || used || !solution;
    this.#force.hidden = !may || used || this.#refused === "" || !solution;
    mark(this.#accept, "class", `button large${good ? " primary" : ""}`);
    this.#again.hidden = !may || views.length < 4 || solving !== null;
    this.#undo.hidden = !may || !used;
    this.#next.hidden = !may || !used || kind !== "camera" || calibration.source !== "robot";
    write(this.#more, `Take more ${word}s`);
    mark(this.#more, "class", `button${!good && !used ? " primary large" : ""}`);
    this.#more.hidden = !may;

    const selected = views.some(({ name }) => name === this.#selected) ? this.#selected : (views[0]?.name ?? "");
    this.#values.show(calibration);
    this.#findings.show(calibration);
    this.#exports.show(calibration);
    this.#both.show(calibration, selected);
    this.#precision.hidden = kind === "camera";
    if (kind === "laser") this.#precision.show(calibration);
    this.#fields.hidden = kind === "laser";
    if (kind === "camera") this.#fields.show(calibration);
    this.#views.show(this.model, calibration, selected);
  }

  /** @param {boolean} force overrule the refusal */
  async #use(force) {
    const { calibration } = this.model;
    if (!calibration) return;
    this.#refused = "";
    try {
      await api.accept(calibration.id, force);
      this.session.announce("The calibration is in use.");
      this.model.take(await api.read(calibration.id));
      await this.model.readLists();
    } catch (refusal) {
      this.#refused = sentenceOf(refusal);
      this.draw();
    }
  }

  async #takeBack() {
    const { calibration } = this.model;
    if (!calibration) return;
    const done = await this.model.tried(() => api.undo(calibration.kind));
    if (done === null) return;
    this.session.announce("The former calibration is in use again.");
    this.model.go({ at: "home" });
  }
}

const KEPT = " The former one is kept and can be taken back.";
/** @type {Readonly<Record<import("./types.js").Source, string>>} */
const FOREIGN = {
  robot: "",
  webcam: " These pictures are from this browser’s camera: use it only where that camera is the robot’s.",
  upload: " Use it only where the pictures are from the robot’s camera. Otherwise take the files away below.",
};
const OTHER = " Another solution is in use.";

customElements.define("calibration-review", CalibrationReview);
