// Before it is used: how exact, from which views, what is left over, what changes; then the decision.

import { Refusal } from "../api.js";
import { icon, make, mark, redraw, write } from "../element.js";
import * as api from "./api.js";
import { BeforeAfter } from "./before-after.js";
import { ExportsCard } from "./exports-card.js";
import { FieldsCard } from "./fields-card.js";
import { FindingsCard } from "./findings-card.js";
import { GainsCard } from "./gains-card.js";
import { Room } from "./room.js";
import { sure } from "./sure.js";
import { ValuesCard } from "./values-card.js";
import { ViewsCard } from "./views-card.js";

/** @typedef {import("./shape.js").Calibration} Calibration */

class CalibrationReview extends Room {
  #sign = icon("done");
  #title = make("h2", { class: "review-title", tabindex: "-1" });
  #words = make("p", { class: "review-words" });
  #accept = make("button", { type: "button", class: "button primary large" }, "Use this calibration");
  #anyway = make("button", { type: "button", class: "button" }, "Use it anyway");
  #more = make("button", { type: "button", class: "button" }, "Take more views");
  #again = make("button", { type: "button", class: "button" }, "Solve again");
  #undo = make("button", { type: "button", class: "button" }, "Take the former one back");
  #next = make("a", { class: "button primary large", href: "#new=laser" }, "Now the laser");
  #says = make("p", { class: "review-says", role: "alert" });
  #head = make(
    "header",
    { class: "card review-head" },
    make("span", { class: "review-sign" }, this.#sign),
    make("div", { class: "review-told" }, this.#title, this.#words, this.#says),
    make(
      "div",
      { class: "review-buttons" },
      this.#accept,
      this.#anyway,
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
  #gains = new GainsCard();
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
        make("div", { class: "review-column is-wide" }, this.#both, this.#gains, this.#fields, this.#findings),
        make("div", { class: "review-column" }, this.#views),
      ),
    );
    const { bench } = this;
    this.#accept.addEventListener("click", () => void this.#use(false));
    this.#anyway.addEventListener("click", () => void this.#use(true));
    this.#again.addEventListener("click", () => void bench.wish(api.solve));
    this.#more.addEventListener(
      "click",
      () => bench.calibration && bench.go({ at: "capture", id: bench.calibration.id }),
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
    const { calibration, may } = this.bench;
    if (!calibration) return;
    const { kind, progress, views, solution, solving } = calibration;
    const { used } = this.bench;
    const older = !used && typeof calibration.accepted_s === "number";
    const good = progress.ready;
    const word = kind === "camera" ? "view" : "pose";
    mark(this.#head, "data-state", used ? "used" : good ? "good" : "open");
    redraw(this.#sign, used || good ? "done" : "estimate");
    write(
      this.#title,
      used ? "In use" : good ? "Good enough to be used" : solution ? "Not yet exact enough" : "No solution yet",
    );
    const former = calibration.in_use_compare ? KEPT : "";
    const foreign = solution && kind === "camera" ? FOREIGN[calibration.source] : "";
    write(this.#words, solving ? `${solving.words} …` : `${progress.words}${used ? former : older ? OTHER : foreign}`);
    write(this.#says, may ? this.#refused : "You are watching. Only an operator can decide.");
    this.#accept.hidden = !may || used || !solution;
    this.#anyway.hidden = !may || used || this.#refused === "" || !solution;
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
    this.#gains.hidden = kind === "camera";
    if (kind === "laser") this.#gains.show(calibration);
    this.#fields.hidden = kind === "laser";
    if (kind === "camera") this.#fields.show(calibration);
    this.#views.show(this.bench, calibration, selected);
  }

  /** @param {boolean} anyway overrule the refusal */
  async #use(anyway) {
    const { calibration } = this.bench;
    if (!calibration) return;
    this.#refused = "";
    try {
      await api.accept(calibration.id, anyway);
      this.session.announce("The calibration is in use.");
      this.bench.take(await api.read(calibration.id));
      await this.bench.readLists();
    } catch (refusal) {
      this.#refused = refusal instanceof Refusal ? refusal.message : "That did not work.";
      this.draw();
    }
  }

  async #takeBack() {
    const { calibration } = this.bench;
    if (!calibration) return;
    const told = await this.bench.tried(() => api.undo(calibration.kind));
    if (told === null) return;
    this.session.announce("The former calibration is in use again.");
    this.bench.go({ at: "home" });
  }
}

const KEPT = " The former one is kept and can be taken back.";
/** @type {Readonly<Record<import("./shape.js").Source, string>>} */
const FOREIGN = {
  robot: "",
  webcam: " These pictures are from this browser’s camera: use it only where that camera is the robot’s.",
  upload: " Use it only where the pictures are from the robot’s camera. Otherwise take the files away below.",
};
const OTHER = " What is in use is another solution than this one.";

customElements.define("calibration-review", CalibrationReview);
