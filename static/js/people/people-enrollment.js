// Element <people-enrollment>: enrollment of a person: empty room, gestures, name.

import { action, icon, iconButton, isNew, make, mark, nameField, onSubmit, say, write } from "../ui/element.js";
import { takeDrops } from "../ui/file-drop.js";
import { remember, remembered } from "../ui/local-storage.js";
import { PagePanel } from "../ui/panel.js";
import { sure } from "../ui/row-question.js";
import { inLanguage, t } from "../ui/texts.js";
import { PeopleStage, prepared, sketched } from "./people-stage.js";

/** @import { EnrollmentState as Enrollment } from "../net/rest.js" */
/** @import { EnrollmentModel } from "./enrollment-model.js" */
/** @import { Source } from "./people-stage.js" */

const SOURCES = /** @type {const} */ ([
  ["robot", "camera", t("people-enrollment.the_robot_s_camera"), t("people-enrollment.it_looks_up_from_the_floor")],
  ["webcam", "webcam", t("people-enrollment.this_device_s_camera"), t("people-enrollment.stand_back_until_all_of_you")],
  ["upload", "upload", t("people-enrollment.picture_files"), t("people-enrollment.first_the_empty_room_then_the")],
]);
const DELAYS = /** @type {const} */ ([
  [0, t("people-enrollment.at_once")],
  [3, t("people-enrollment.in_3_seconds")],
  [6, t("people-enrollment.in_6_seconds")],
  [10, t("people-enrollment.in_10_seconds")],
]);
const PRIVACY = t("people-enrollment.only_numbers_are_kept_how_tall");

/** @extends {PagePanel<EnrollmentModel>} */
class PeopleEnrollment extends PagePanel {
  #stage = new PeopleStage();
  #sources = SOURCES.map(([value, drawing, name, note]) => choice(value, drawing, name, note));
  #begin = make("button.button.primary.large", t("people-enrollment.begin"));
  #whyNot = make("p.note", { role: "status" });
  #intro = make(
    "section.card.page-card",
    { "aria-label": t("people-enrollment.enroll_a_person") },
    make("h2", t("people-enrollment.teach_the_robot_who_you_are")),
    make("p", t("people-enrollment.then_the_robot_can_come_to")),
    make("fieldset.people-sources", make("legend", t("people-enrollment.who_takes_the_pictures")), ...this.#sources),
    make("div.row.people-buttons", this.#begin),
    this.#whyNot,
    make("p.note", PRIVACY),
  );
  #advice = make("h2.people-advice");
  #steps = make("ol.people-steps", { "aria-label": t("people-enrollment.what_is_asked_for") });
  #verdict = make("p.people-verdict", { role: "alert" });
  #waits = make("p.inline.people-waits", { role: "status" });
  #take = action("camera", t("people-enrollment.take_it"), () => {
    if (this.#counting) this.#stop();
    else this.#countDown(this.model.enrollment?.background ? "picture" : "background");
  });
  #delay = make(
    "select.field-box",
    { "aria-label": t("people-enrollment.when"), onchange: () => remember("people.delay", this.#delay.value) },
    ...DELAYS.map(([seconds, words]) => make("option", { value: String(seconds) }, words)),
  );
  #files = make("input.visually-hidden", {
    type: "file",
    accept: "image/jpeg,image/png",
    multiple: true,
    id: "people-files",
  });
  #choose = make(
    "label.button.primary",
    { for: "people-files" },
    icon("upload"),
    t("people-enrollment.choose_pictures"),
  );
  #show = action("demo", t("people-enrollment.show_me"), () => this.#showMe());
  #who = make("select.field-box", { "aria-label": t("people-enrollment.who_shows_themselves") });
  #turnLeft = action("turn_left", t("people-enrollment.turn_left"), () => void this.session.say("turn left", "chip"));
  #turnRight = action(
    "turn_right",
    t("people-enrollment.turn_right"),
    () => void this.session.say("turn right", "chip"),
  );
  #retakeRoom = action("undo", t("people-enrollment.retake_the_empty_room"), () => this.#countDown("background"));
  #cancel = action("close", t("people-enrollment.cancel"));
  #strip = make("ul.people-strip", { "aria-label": t("people-enrollment.pictures_taken") });
  #name = nameField(t("people-enrollment.your_name"), { id: "people-name" });
  #keep = make("button.button.primary.large", { type: "submit" }, t("people-enrollment.that_is_me"));
  #naming = make(
    "form.row.people-naming",
    make("label", { for: "people-name" }, t("people-enrollment.who_are_you")),
    this.#name,
    this.#keep,
  );
  #enrollment = make(
    "section.card.page-card",
    { "aria-label": t("people-enrollment.enrollment"), hidden: true },
    this.#advice,
    this.#steps,
    this.#stage,
    make("div.people-text", this.#verdict, this.#waits),
    this.#naming,
    make(
      "div.row.people-buttons",
      this.#take,
      this.#delay,
      this.#files,
      this.#choose,
      this.#who,
      this.#show,
      this.#turnLeft,
      this.#turnRight,
      this.#retakeRoom,
      this.#cancel,
    ),
    this.#strip,
    make("p.note", PRIVACY),
  );
  #counting = 0;
  #away = false; // another page is open: no camera

  /** @override */
  build() {
    this.#take.classList.add("primary", "large");
    this.#delay.value = remembered("people.delay", "0");
    this.append(this.#intro, this.#enrollment);
    this.#begin.addEventListener("click", () => void this.model.begin());
    this.#files.addEventListener("change", () => void this.#upload(this.#files.files ?? []));
    this.#cancel.addEventListener("click", () => {
      this.#stop();
      const { length: count } = this.model.enrollment?.pictures ?? [];
      if (count > 0 && !sure(this.#cancel, t("people-enrollment.press_again_to_delete_pictures", { count }))) return;
      void this.model.cancel();
    });
    onSubmit(this.#naming, () => void this.#finish());
    this.#name.addEventListener("input", () => this.draw());
    for (const radio of this.#radios) radio.addEventListener("change", () => remember("people.source", radio.value));
    takeDrops(
      this.#stage,
      () => this.#source === "upload",
      (files) => void this.#upload(files),
    );
    this.draw();
  }

  /** @override */
  show() {
    if (!this.#enrollment.hidden) this.#stage.draw();
    if (!this.#counting) this.#take.disabled = !this.#idle || !this.#stage.ready;
  }

  /** @override */
  pageOpened() {
    this.#away = false;
    this.draw();
  }

  /** @override */
  pageLeft() {
    this.#away = true;
    this.#stop();
    this.#stage.close();
  }

  get #radios() {
    return this.#sources.map((one) => /** @type {HTMLInputElement} */ (one.querySelector("input")));
  }

  /** @returns {Source} */
  get #source() {
    return /** @type {Source | undefined} */ (this.#radios.find((radio) => radio.checked)?.value) ?? "webcam";
  }

  get #idle() {
    return this.model.may && !this.model.busy && !this.model.enrollment?.demo;
  }

  /** @override */
  draw() {
    const enrollments = this.model;
    if (!enrollments?.state) return;
    const { enrollment, state } = enrollments;
    const others = enrollment !== null && !enrollments.mine;
    const begins = enrollments.mine && this.#enrollment.hidden;
    this.#intro.hidden = enrollments.mine;
    this.#enrollment.hidden = !enrollments.mine;
    this.#offer(state.camera);
    this.#begin.disabled = !enrollments.may || enrollments.busy !== "" || others;
    write(
      this.#whyNot,
      !enrollments.may
        ? t("people-enrollment.you_are_watching_only_an_operator")
        : others
          ? t("people-enrollment.who_is_enrolling_a_person_now", { who: enrollment.who })
          : "",
    );
    this.#whyNot.hidden = this.#whyNot.textContent === "";
    if (!enrollments.mine || !enrollment) {
      this.#stop();
      this.#stage.close();
      this.#stage.judge("", null);
      return;
    }
    if (!this.#away) this.#stage.open(this.#source, this.session);
    this.#stage.judge(enrollment.id, enrollment.newest);
    this.#drawEnrollment(enrollment, state.simulated);
    if (begins) this.#enrollment.scrollIntoView(); // its buttons are below what is known of people
  }

  /** @param {boolean} camera true when the robot has one */
  #offer(camera) {
    const radios = this.#radios;
    const robot = /** @type {HTMLInputElement} */ (radios[0]);
    robot.disabled = !camera;
    if (radios.some((radio) => radio.checked && !radio.disabled)) return;
    const wanted = remembered("people.source", "robot");
    const first =
      radios.find((radio) => radio.value === wanted && !radio.disabled) ?? radios.find((radio) => !radio.disabled);
    if (first) first.checked = true;
  }

  /** @param {Enrollment} enrollment @param {boolean} simulated */
  #drawEnrollment(enrollment, simulated) {
    const upload = this.#source === "upload";
    const { newest } = enrollment;
    write(this.#advice, inLanguage(enrollment.advice));
    const words = inLanguage(enrollment.trouble || (newest?.words ?? ""));
    const waits =
      enrollment.waits ||
      (enrollment.demo ? t("people-enrollment.the_simulated_person_shows_the_gesture") : this.model.busy);
    write(this.#verdict, words);
    write(this.#waits, waits);
    mark(this.#verdict, "data-tone", enrollment.trouble || (newest && !newest.good) ? "stale" : "live");
    this.#take.hidden = this.#delay.hidden = upload;
    if (!this.#counting)
      say(
        this.#take,
        enrollment.background ? t("people-enrollment.take_it") : t("people-enrollment.take_the_empty_room"),
        "camera",
      );
    this.#take.disabled = !this.#counting && (!this.#idle || !this.#stage.ready);
    this.#choose.hidden = !upload;
    this.#show.hidden = !simulated || this.#source !== "robot";
    this.#show.disabled = this.model.busy !== "";
    this.#who.hidden = this.#show.hidden || enrollment.demo || this.#offerInhabitants(enrollment.id) === 0;
    this.#turnLeft.hidden = this.#turnRight.hidden = this.#show.hidden || enrollment.demo || !enrollment.trouble;
    say(this.#show, enrollment.demo ? t("people-enrollment.enough_shown") : t("people-enrollment.show_me"), "demo");
    this.#retakeRoom.hidden = !enrollment.background || upload;
    this.#retakeRoom.disabled = !this.#idle;
    this.#naming.hidden = !enrollment.ready;
    this.#keep.disabled = !this.#idle || this.#name.value.trim() === "";
    if (
      !isNew(
        this,
        enrollment.id,
        enrollment.background,
        enrollment.next,
        enrollment.pictures.map((one) => one.number),
      )
    )
      return;
    const have = new Set(enrollment.pictures.map((one) => one.gesture));
    const steps = [
      ["empty", t("people-enrollment.empty_room"), enrollment.background],
      ...enrollment.gestures.map((name) => [name, NAMES[name] ?? name, have.has(name)]),
    ];
    const now = steps.findIndex(([, , done]) => !done);
    this.#steps.replaceChildren(
      ...steps.map(([, name, done], index) =>
        make(
          "li",
          { "data-done": Boolean(done), "aria-current": index === now ? "step" : null },
          done ? icon("done") : make("span.step-dot"),
          String(name),
        ),
      ),
    );
    this.#strip.replaceChildren(...enrollment.pictures.map((one) => this.#thumb(enrollment, one)));
  }

  /**
   * Who is not known yet is chosen first, in every enrollment.
   * @param {string} id of the enrollment
   * @returns {number} people in the simulated room who can show themselves
   */
  #offerInhabitants(id) {
    const inhabitants = this.model.inhabitants;
    if (!isNew(this.#who, id, inhabitants)) return inhabitants.length;
    const known = new Set(this.model.state?.people.map(({ name }) => name));
    this.#who.replaceChildren(
      ...inhabitants.map((name) => make("option", { value: name }, name)),
      make("option", { value: "" }, t("people-enrollment.someone_new")),
    );
    this.#who.value = inhabitants.find((name) => !known.has(name)) ?? "";
    return inhabitants.length;
  }

  #showMe() {
    const on = !this.model.enrollment?.demo;
    const inhabitant = this.#who.hidden ? "" : this.#who.value;
    if (on) this.#name.value = inhabitant;
    void this.model.showMe(on, inhabitant);
  }

  /** @param {Enrollment} enrollment @param {import("../net/rest.js").JudgedPictureState} one */
  #thumb(enrollment, one) {
    const name = NAMES[one.gesture] ?? t("people-enrollment.more");
    const title = t("people-enrollment.leave_out");
    const drop = () => void this.model.drop(one.number);
    const away = iconButton("trash", t("people-enrollment.leave_out_name", { name }), drop, { title });
    return make("li", sketched(enrollment.id, one, name), make("span.thumb-foot", name, away));
  }

  /** @param {"background" | "picture"} what */
  #countDown(what) {
    if (this.#counting || !this.#idle) return;
    let left = Number(this.#delay.value);
    const beat = () => {
      if (left <= 0) {
        this.#stop();
        if (this.#stage.ready) void this.model.take(what, this.#stage.snapshot());
        else this.session.complain(t("people-enrollment.there_was_no_picture_to_take"));
        return;
      }
      this.#stage.count(String(left));
      left -= 1;
    };
    if (left > 0) {
      this.#counting = window.setInterval(beat, 1000);
      say(this.#take, t("people-enrollment.wait_not_yet"), "close");
    }
    beat();
  }

  #stop() {
    clearInterval(this.#counting);
    this.#counting = 0;
    this.#stage.count("");
  }

  /** @param {Iterable<File>} files */
  async #upload(files) {
    for (const file of files) {
      const picture = await prepared(file).catch((/** @type {Error} */ wrong) => this.session.complain(wrong.message));
      const what = this.model.enrollment?.background ? "picture" : "background";
      const taken = picture !== undefined && (await this.model.take(what, picture));
      if (!taken && what === "background") break; // otherwise a picture of a person would become the empty room
    }
    this.#files.value = "";
  }

  async #finish() {
    const name = this.#name.value.trim();
    if (!(await this.model.finish(name))) return;
    this.#name.value = "";
    this.session.announce(t("people-enrollment.name_is_enrolled", { name }));
    document.querySelector("people-known")?.scrollIntoView(); // who it is now comes first there
  }
}

const NAMES = /** @type {Readonly<Record<string, string>>} */ ({
  down: t("people-enrollment.arms_down"),
  out: t("people-enrollment.arms_out"),
  wave: t("people-enrollment.waving"),
  side: t("people-enrollment.sideways"),
});

/**
 * @param {string} value
 * @param {string} drawing
 * @param {string} name
 * @param {string} note
 */
function choice(value, drawing, name, note) {
  const radio = make("input", { type: "radio", name: "people-source", value });
  return make("label.people-source", radio, icon(drawing), make("span", make("span", name), make("span.note", note)));
}

customElements.define("people-enrollment", PeopleEnrollment);
