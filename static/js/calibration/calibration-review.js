// Review step: precision, views, residuals and changes of a solution, and the decision to use it.
// Element <before-after>: one view as taken and undistorted, with a movable divider.

import { sentenceOf } from "../net/api.js";
import { cardHead, icon, isNew, make, mark, redraw, write } from "../ui/element.js";
import { sure } from "../ui/row-question.js";
import { inLanguage, t } from "../ui/texts.js";
import { takenBack, takesBack } from "./active-calibration.js";
import * as api from "./api.js";
import { GainsCard } from "./capture-cards.js";
import { ExportsCard, FieldsCard, FindingsCard, PosesCard, ValuesCard } from "./review-cards.js";
import { ViewsCard } from "./views-card.js";
import { WizardStep } from "./wizard-step.js";

/** @import { Calibration } from "./types.js" */

export class BeforeAfter extends HTMLElement {
  #before = make("img", { alt: t("before-after.as_the_camera_took_it"), draggable: "false" });
  #after = make("img.after", { alt: t("before-after.straightened"), draggable: "false" });
  #line = make("span.divide", { "aria-hidden": "true" });
  #slider = make("input", {
    type: "range",
    min: "0",
    max: "100",
    value: "50",
    "aria-label": t("before-after.straightened_from_here_on"),
  });
  #box = make(
    "div.both",
    this.#before,
    this.#after,
    this.#line,
    make("span.both-tag.is-left", t("before-after.as_taken")),
    make("span.both-tag.is-right", t("before-after.straightened")),
    this.#slider,
  );
  #which = make("p.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("before-after.before_and_after"), this.#which), this.#box);
    this.#slider.addEventListener("input", () => this.#place());
    this.#place();
  }

  /** @param {Calibration} calibration @param {string} name of the view to show */
  show({ id, size, solution, kind, progress }, name) {
    this.hidden = kind !== "camera" || !solution || !name;
    if (this.hidden) return;
    if (!isNew(this, id, name, progress.views, solution?.["rms_px"])) return;
    if (size) this.#box.style.aspectRatio = `${size[0]} / ${size[1]}`;
    write(this.#which, inLanguage(name));
    mark(this.#before, "src", api.thumbnail(id, name, "full"));
    mark(
      this.#after,
      "src",
      `${api.thumbnail(id, name, "corrected")}&of=${encodeURIComponent(String(solution?.["rms_px"]))}`,
    );
  }

  #place() {
    const at = `${this.#slider.value}%`;
    this.#after.style.clipPath = `inset(0 0 0 ${at})`;
    this.#line.style.left = at;
    mark(
      this.#slider,
      "aria-valuetext",
      t("before-after.value_straightened", { value: 100 - Number(this.#slider.value) }),
    );
  }
}

customElements.define("before-after", BeforeAfter);

class CalibrationReview extends WizardStep {
  #sign = icon("done");
  #title = make("h2.heading.review-title", { tabindex: "-1" });
  #words = make("p.review-words");
  #accept = make("button.button.primary.large");
  #force = make("button.button", { onclick: () => void this.#use(true) }, t("calibration-review.use_it_anyway"));
  #more = make("button.button", t("calibration-review.take_more_views"));
  #again = make(
    "button.button",
    { onclick: () => void this.model.request(api.solve) },
    t("calibration-review.solve_again"),
  );
  #undo = make("button.button");
  #next = make("a.button.primary.large", { href: "#new=laser" }, t("calibration-review.now_the_laser"));
  #says = make("p.review-says", { role: "alert" });
  #head = make(
    "header.card.review-head",
    make("span.review-sign", this.#sign),
    make("div.review-text", this.#title, this.#words, this.#says),
    make("div.row.review-buttons", this.#accept, this.#force, this.#next, this.#more, this.#again, this.#undo),
  );
  #values = new ValuesCard();
  #views = new ViewsCard();
  #fields = new FieldsCard();
  #both = new BeforeAfter();
  #precision = new GainsCard();
  #findings = new FindingsCard();
  #poses = new PosesCard();
  #exports = new ExportsCard();
  #selected = "";
  #refused = "";
  #using = false; // it is being put into use

  /** @override */
  build() {
    this.append(
      make(
        "div.review",
        this.#head,
        make("div.review-column", this.#values, this.#exports),
        make("div.review-column.is-wide", this.#both, this.#precision, this.#fields, this.#findings, this.#poses),
        make("div.review-column", this.#views),
      ),
    );
    const { model } = this;
    this.#accept.addEventListener("click", () => void this.#use(false));
    this.#more.addEventListener(
      "click",
      () => model.calibration && model.go({ at: "capture", id: model.calibration.id }),
    );
    this.#undo.addEventListener(
      "click",
      () => sure(this.#undo, t("calibration-review.press_again_to_take_it_back")) && void this.#takeBack(),
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
    const inUse = this.model.inUse?.[kind] ?? null;
    const older = !used && typeof calibration.accepted_s === "number";
    const good = progress.ready;
    const notUsed = used ? inLanguage(inUse?.["not_used"] ?? "") : "";
    const word = kind === "camera" ? "view" : "pose";
    mark(this.#head, "data-state", notUsed ? "open" : used ? "used" : good ? "good" : "open");
    redraw(this.#sign, notUsed ? "warning" : used || good ? "done" : "estimate");
    write(
      this.#title,
      used
        ? t(notUsed ? "calibration-review.accepted_not_used" : "calibration-review.in_use")
        : good
          ? t("calibration-review.good_enough_to_be_used")
          : solution
            ? t("calibration-review.not_yet_exact_enough")
            : t("calibration-review.no_solution_yet"),
    );
    const former = inUse?.["former"] ? KEPT : "";
    const foreign = solution && kind === "camera" ? FOREIGN[calibration.source] : "";
    write(
      this.#words,
      solving
        ? `${inLanguage(solving.words)} …`
        : `${notUsed || (this.#refused ? "" : inLanguage(progress.words))}${used ? former : older && !this.#using ? OTHER : foreign}`,
    );
    write(this.#says, may ? this.#refused : t("calibration-review.you_are_watching_only_an_operator"));
    write(this.#accept, t(this.#using ? "trouble-line.saving" : "calibration-review.use_this_calibration"));
    this.#accept.disabled = this.#force.disabled = this.#using;
    this.#accept.hidden = !may || used || !solution || this.#refused !== "";
    this.#force.hidden = !may || used || this.#refused === "" || !solution;
    mark(this.#accept, "class", `button large${good ? " primary" : ""}`);
    this.#again.hidden = !may || views.length < 4 || solving !== null;
    this.#undo.hidden = !may || !used;
    if (!this.#undo.dataset["asks"]) write(this.#undo, takesBack(inUse));
    this.#next.hidden = !may || !used || kind !== "camera" || calibration.source !== "robot";
    write(this.#more, t("calibration-review.take_more_words", { words: inLanguage(`${word}s`) }));
    mark(this.#more, "class", `button${!good && !used ? " primary large" : ""}`);
    this.#more.hidden = !may;

    const selected = views.some(({ name }) => name === this.#selected) ? this.#selected : (views[0]?.name ?? "");
    this.#values.show(calibration);
    this.#findings.show(calibration);
    this.#poses.show(calibration);
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
    [this.#refused, this.#using] = ["", true];
    this.draw();
    try {
      await api.accept(calibration.id, force);
      this.model.take(await api.read(calibration.id));
      await this.model.readLists();
      this.session.announce(
        inLanguage(this.model.inUse?.[calibration.kind]?.["not_used"] ?? "") ||
          t("calibration-review.the_calibration_is_in_use"),
      );
    } catch (refusal) {
      this.#refused = sentenceOf(refusal);
    } finally {
      this.#using = false;
      this.draw();
    }
  }

  async #takeBack() {
    const { calibration } = this.model;
    if (!calibration) return;
    const done = await this.model.tried(() => api.undo(calibration.kind));
    if (done === null) return;
    this.session.announce(takenBack(done[calibration.kind] ?? null));
    this.model.go({ at: "home" });
  }
}

const KEPT = t("calibration-review.the_former_one_is_kept_and");
/** @type {Readonly<Record<import("./types.js").Source, string>>} */
const FOREIGN = {
  robot: "",
  webcam: t("calibration-review.these_pictures_are_from_this_browser"),
  upload: t("calibration-review.use_it_only_where_the_pictures"),
};
const OTHER = t("calibration-review.another_solution_is_in_use");

customElements.define("calibration-review", CalibrationReview);
