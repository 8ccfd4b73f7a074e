// Element <people-enrollment>: enrollment of a person: empty room, gestures, name.

import { action, say } from "../calibration/action.js";
import { takeDrops } from "../calibration/file-drop.js";
import { icon, make, mark, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { PeopleStage, prepared } from "./people-stage.js";
import { sketched } from "./person-outline.js";

/** @typedef {import("./enrollment-model.js").EnrollmentModel} EnrollmentModel */
/** @typedef {import("./enrollment-model.js").Enrollment} Enrollment */
/** @typedef {import("./people-stage.js").Source} Source */

const SOURCES = /** @type {const} */ ([
  ["robot", "camera", "The robot’s camera", "It looks up from the floor: some four metres away all of you is in it."],
  ["webcam", "webcam", "This device’s camera", "Stand back until all of you is in it."],
  ["upload", "upload", "Picture files", "First the empty room, then the person, all from the same fixed camera."],
]);
const DELAYS = /** @type {const} */ ([
  [0, "At once"],
  [3, "In 3 seconds"],
  [6, "In 6 seconds"],
  [10, "In 10 seconds"],
]);
const PRIVACY =
  "Only numbers are kept: how tall against how wide, and the shares of colours of head, torso and legs. The pictures stay in memory and are deleted when the enrollment ends.";

class PeopleEnrollment extends Panel {
  /** @type {EnrollmentModel | null} */
  #enrollments = null;
  #stage = new PeopleStage();
  #sources = SOURCES.map(([value, drawing, name, note]) => choice(value, drawing, name, note));
  #begin = make("button", { type: "button", class: "button primary large" }, "Begin");
  #whyNot = make("p", { class: "note", role: "status" });
  #intro = make(
    "section",
    { class: "card people-card", "aria-label": "Enroll a person" },
    make("h2", {}, "Teach the robot who you are"),
    make(
      "p",
      {},
      "Then the robot can come to you and follow you, and nobody else. This takes one picture of the empty room and at least three of you, with different gestures.",
    ),
    make("fieldset", { class: "people-sources" }, make("legend", {}, "Who takes the pictures?"), ...this.#sources),
    make("div", { class: "people-buttons" }, this.#begin),
    this.#whyNot,
    make("p", { class: "note" }, PRIVACY),
  );
  #advice = make("h2", { class: "people-advice" });
  #steps = make("ol", { class: "people-steps", "aria-label": "What is asked for" });
  #verdict = make("p", { class: "people-verdict", role: "alert" });
  #waits = make("p", { class: "people-waits", role: "status" });
  #take = action("camera", "Take it");
  #delay = make(
    "select",
    { "aria-label": "When" },
    ...DELAYS.map(([seconds, words]) => make("option", { value: String(seconds) }, words)),
  );
  #files = make("input", {
    type: "file",
    accept: "image/jpeg,image/png",
    multiple: true,
    class: "visually-hidden",
    id: "people-files",
  });
  #choose = make("label", { class: "button primary", for: "people-files" }, icon("upload"), "Choose pictures");
  #show = action("demo", "Show me");
  #retakeRoom = action("undo", "Retake the empty room");
  #cancel = action("close", "Cancel");
  #strip = make("ul", { class: "people-strip", "aria-label": "Pictures taken" });
  #name = make("input", {
    type: "text",
    id: "people-name",
    maxlength: "40",
    autocomplete: "off",
    placeholder: "Your name",
  });
  #keep = make("button", { type: "submit", class: "button primary large" }, "That is me");
  #naming = make(
    "form",
    { class: "people-naming" },
    make("label", { for: "people-name" }, "Who are you?"),
    this.#name,
    this.#keep,
  );
  #enrollment = make(
    "section",
    { class: "card people-card", "aria-label": "Enrollment" },
    this.#advice,
    this.#steps,
    this.#stage,
    make("div", { class: "people-text" }, this.#verdict, this.#waits),
    this.#naming,
    make(
      "div",
      { class: "people-buttons" },
      this.#take,
      this.#delay,
      this.#files,
      this.#choose,
      this.#show,
      this.#retakeRoom,
      this.#cancel,
    ),
    this.#strip,
    make("p", { class: "note" }, PRIVACY),
  );
  #counting = 0;
  #away = false; // another page is open: no camera
  #drawn = "";

  /** @param {EnrollmentModel} enrollments */
  watch(enrollments) {
    this.#enrollments = enrollments;
    enrollments.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    this.#take.classList.add("primary", "large");
    this.#delay.value = remembered("people.delay", "0");
    this.#delay.addEventListener("change", () => remember("people.delay", this.#delay.value));
    this.append(this.#intro, this.#enrollment);
    this.#begin.addEventListener("click", () => void this.#enrollments?.begin());
    this.#take.addEventListener("click", () => this.#press());
    this.#files.addEventListener("change", () => void this.#upload(this.#files.files ?? []));
    this.#show.addEventListener("click", () => void this.#enrollments?.showMe(!this.#enrollments.enrollment?.demo));
    this.#retakeRoom.addEventListener("click", () => this.#countDown("background"));
    this.#cancel.addEventListener("click", () => {
      this.#stop();
      void this.#enrollments?.cancel();
    });
    this.#naming.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#finish();
    });
    this.#name.addEventListener("input", () => this.#draw());
    for (const radio of this.#radios) radio.addEventListener("change", () => remember("people.source", radio.value));
    takeDrops(
      this.#stage,
      () => this.#source === "upload",
      (files) => void this.#upload(files),
    );
    this.#draw();
  }

  /** @override */
  show() {
    if (!this.#enrollment.hidden) this.#stage.draw();
    if (!this.#counting) this.#take.disabled = !this.#idle || !this.#stage.ready;
  }

  /** @override */
  pageOpened() {
    this.#away = false;
    this.#draw();
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
    return (this.#enrollments?.may ?? false) && !this.#enrollments?.busy && !this.#enrollments?.enrollment?.demo;
  }

  #draw() {
    const enrollments = this.#enrollments;
    if (!enrollments?.state) return;
    const { enrollment, state } = enrollments;
    const others = enrollment !== null && !enrollments.mine;
    this.#intro.hidden = enrollments.mine;
    this.#enrollment.hidden = !enrollments.mine;
    this.#offer(state.camera);
    this.#begin.disabled = !enrollments.may || enrollments.busy || others;
    write(
      this.#whyNot,
      !enrollments.may
        ? "You are watching. Only an operator can enroll people."
        : others
          ? `${enrollment.who} is enrolling a person now.`
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
    write(this.#advice, enrollment.advice);
    const words = enrollment.trouble || (newest?.words ?? "");
    const waits =
      enrollment.waits ||
      (enrollment.demo ? "The simulated person shows the gesture." : this.#enrollments?.busy ? "One moment…" : "");
    write(this.#verdict, words);
    write(this.#waits, waits);
    mark(this.#verdict, "data-tone", enrollment.trouble || (newest && !newest.good) ? "stale" : "live");
    this.#take.hidden = this.#delay.hidden = upload;
    if (!this.#counting) say(this.#take, enrollment.background ? "Take it" : "Take the empty room", "camera");
    this.#take.disabled = !this.#counting && (!this.#idle || !this.#stage.ready);
    this.#choose.hidden = !upload;
    this.#show.hidden = !simulated || this.#source !== "robot";
    this.#show.disabled = this.#enrollments?.busy === true;
    say(this.#show, enrollment.demo ? "Enough shown" : "Show me", "demo");
    this.#retakeRoom.hidden = !enrollment.background || upload;
    this.#retakeRoom.disabled = !this.#idle;
    this.#naming.hidden = !enrollment.ready;
    this.#keep.disabled = !this.#idle || this.#name.value.trim() === "";
    const key = JSON.stringify([
      enrollment.id,
      enrollment.background,
      enrollment.next,
      enrollment.pictures.map((one) => one.number),
    ]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    const have = new Set(enrollment.pictures.map((one) => one.gesture));
    const steps = [
      ["empty", "Empty room", enrollment.background],
      ...enrollment.gestures.map((name) => [name, NAMES[name] ?? name, have.has(name)]),
    ];
    const now = steps.findIndex(([, , done]) => !done);
    this.#steps.replaceChildren(
      ...steps.map(([, name, done], index) =>
        make(
          "li",
          { "data-done": Boolean(done), "aria-current": index === now ? "step" : null },
          done ? icon("done") : make("span", { class: "step-dot" }),
          String(name),
        ),
      ),
    );
    this.#strip.replaceChildren(...enrollment.pictures.map((one) => this.#thumb(enrollment, one)));
  }

  /** @param {Enrollment} enrollment @param {import("./enrollment-model.js").Judged} one */
  #thumb(enrollment, one) {
    const name = NAMES[one.gesture] ?? "More";
    const away = make(
      "button",
      { type: "button", class: "icon-button", "aria-label": `Leave out: ${name}`, title: "Leave out" },
      icon("trash"),
    );
    away.addEventListener("click", () => void this.#enrollments?.drop(one.number));
    return make("li", {}, sketched(enrollment.id, one, name), make("span", { class: "thumb-foot" }, name, away));
  }

  #press() {
    if (this.#counting) this.#stop();
    else this.#countDown(this.#enrollments?.enrollment?.background ? "picture" : "background");
  }

  /** @param {"background" | "picture"} what */
  #countDown(what) {
    if (this.#counting || !this.#idle) return;
    let left = Number(this.#delay.value);
    const beat = () => {
      if (left <= 0) {
        this.#stop();
        if (this.#stage.ready) void this.#enrollments?.take(what, this.#stage.snapshot());
        else this.session.complain("There was no picture to take. Check that the camera runs, and try again.");
        return;
      }
      this.#stage.count(String(left));
      left -= 1;
    };
    if (left > 0) {
      this.#counting = window.setInterval(beat, 1000);
      say(this.#take, "Wait, not yet", "close");
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
      const what = this.#enrollments?.enrollment?.background ? "picture" : "background";
      const taken = picture !== undefined && (await this.#enrollments?.take(what, picture));
      if (!taken && what === "background") break; // otherwise a picture of a person would become the empty room
    }
    this.#files.value = "";
  }

  async #finish() {
    const name = this.#name.value.trim();
    if (!(await this.#enrollments?.finish(name))) return;
    this.#name.value = "";
    this.session.announce(`${name} is enrolled.`);
  }
}

const NAMES = /** @type {Readonly<Record<string, string>>} */ ({
  down: "Arms down",
  out: "Arms out",
  wave: "Waving",
  side: "Sideways",
});

/**
 * @param {string} value
 * @param {string} drawing
 * @param {string} name
 * @param {string} note
 */
function choice(value, drawing, name, note) {
  const radio = make("input", { type: "radio", name: "people-source", value });
  return make(
    "label",
    { class: "people-source" },
    radio,
    icon(drawing),
    make("span", {}, make("span", {}, name), make("span", { class: "note" }, note)),
  );
}

customElements.define("people-enrollment", PeopleEnrollment);
