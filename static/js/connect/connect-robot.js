// Element <connect-robot>: the robot that is shown, and the URL of another one to look at.

import { icon, isNew, make, mark, onSubmit, redraw, write } from "../ui/element.js";
import { takeDrops } from "../ui/file-drop.js";
import { PagePanel } from "../ui/panel.js";
import { inLanguage, t } from "../ui/texts.js";
import { equipment } from "./connect-parts.js";
import { isBare, isRecording } from "./connection-model.js";
import { askToOpen } from "./opening.js";

/** @import { ConnectionModel } from "./connection-model.js" */

const SAMPLES = ["room", "floor", "people"];
const SERIAL = "serial:///dev/ttyUSB0+scip:///dev/ttyACM0";
/** Kinds of robots, what their URL begins with, and what is opened instead of looked at. */
const KINDS = /** @type {const} */ ([
  ["simulator", "cube", "sim:", t("connect-robot.simulator"), t("connect-robot.simulator_says")],
  ["recording", "tape", "log:", t("connect-robot.recording"), t("connect-robot.recording_says")],
  ["ros", "antenna", "foxglove://", t("connect-robot.ros"), t("connect-robot.ros_says")],
  ["serial", "link", SERIAL, t("connect-robot.serial"), t("connect-robot.serial_says")],
  ["own", "command", "py:", t("connect-robot.own"), t("connect-robot.own_says")],
]);
/** @type {Readonly<Record<string, string>>} pages of the docs */
const GUIDES = { recording: "play-a-recording", serial: "serial-robot", own: "write-your-own-driver" };

/** @extends {PagePanel<ConnectionModel>} */
class ConnectRobot extends PagePanel {
  #kind = ""; // that was pressed
  #tiles = new Map(KINDS.map(([kind, drawing, , name, says]) => [kind, tile(drawing, name, says)]));
  #title = make("h2", t("connect-robot.reading_what_was_found"));
  #state = icon("link");
  #about = make("span");
  #has = make("p", { hidden: true });
  #failsafe = make("p.connect-failsafe");
  #url = make("input.field-box.connect-input", {
    id: "connect-url",
    type: "text",
    autocomplete: "off",
    autocapitalize: "off",
    spellcheck: "false",
    placeholder: "foxglove://192.168.0.7:8765",
  });
  #look = make("button.button", { type: "submit" }, icon("eye"), t("connect-robot.look"));
  #open = make("button.button", { type: "submit" }, icon("play"), t("connect-robot.open"));
  #others = make("div.row.connect-others", { role: "group", "aria-label": t("connect-robot.open_instead") });
  #back = make("button.button.plain", icon("undo"), t("connect-robot.back_to_this_console_s_robot"));
  #status = make("p.note.connect-status", { role: "status" });
  #ask = make("button.button", { onclick: () => void this.session.lease("ask") }, t("connect-robot.ask_for_control"));
  #take = make("button.button", { onclick: () => void this.session.lease("take") }, t("connect-robot.take_over"));
  #driving = make("p", { role: "status" });
  #control = make("div.connect-question", this.#driving, this.#ask, this.#take);
  #question = make("div.connect-question", { role: "group", hidden: true });
  #guide = make("a.link", t("connect-robot.how_to"));
  #find = make("button.button", { onclick: () => void this.model.find() }, icon("antenna"), t("connect-robot.find"));
  #answers = make("div.row.connect-others", { role: "status", hidden: true });
  #samples = make("div.row.connect-others", { role: "group", "aria-label": t("connect-robot.samples") });
  /** @type {import("../net/rest.js").FoundAddresses | null} that are drawn */
  #asked = null;
  #filled = "";

  #file = make("input.visually-hidden", { type: "file", tabindex: "-1", "aria-hidden": "true" });
  #choose = make("button.button", { hidden: true }, icon("upload"), t("connect-robot.choose_a_file"));

  /** @override */
  build() {
    const form = make(
      "form.connect-look",
      make("label", { for: "connect-url" }, t("connect-robot.url_of_a_robot")),
      make("div.connect-line", this.#url, this.#look, this.#open),
      make("p.note", t("connect-robot.look_connects_listens_for_two_seconds"), this.#guide),
    );
    onSubmit(form, () => {
      const url = this.#url.value.trim();
      if (url) isOpened(url) ? this.#request(url) : void this.model.look(url);
    });
    this.#url.addEventListener("input", () => this.draw());
    this.#back.addEventListener("click", () => void this.model.back());
    for (const [kind, , begins] of KINDS)
      this.#tiles.get(kind)?.addEventListener("click", () => {
        this.#kind = this.#kind === kind ? "" : kind;
        this.#url.value = this.#kind && begins;
        this.draw();
        if (this.#kind) this.#url.focus();
      });
    this.#choose.addEventListener("click", () => this.#file.click());
    this.#file.addEventListener("change", () => void this.#takeIn(this.#file.files?.[0]));
    this.#samples.append(
      make("p.note", t("connect-robot.samples_say")),
      ...SAMPLES.map((sample) => {
        const button = make("button.button", icon("play"), t(`connect-robot.sample_${sample}`));
        button.addEventListener("click", () => void this.#takeIn(sample));
        return button;
      }),
    );
    const drops = /** @type {HTMLElement} */ (this.#tiles.get("recording"));
    takeDrops(
      drops,
      () => !this.#look.disabled,
      (files) => void this.#takeIn(files[0]),
    );
    const kinds = { class: "connect-tiles", role: "group", "aria-label": t("connect-robot.kinds") };
    this.append(
      make("div", kinds, ...this.#tiles.values()),
      make(
        "section.card.page-card",
        { "aria-label": t("connect-robot.robot") },
        this.#title,
        make("p.connect-state", this.#state, this.#about),
        this.#has,
        this.#failsafe,
        this.#control,
        form,
        this.#find,
        this.#answers,
        this.#choose,
        this.#file,
        this.#samples,
        this.#others,
        this.#question,
        this.#status,
        this.#back,
      ),
    );
    this.draw();
  }

  /** Open something else; where the map is not saved, ask first. @param {string} url */
  #request(url) {
    const open = (/** @type {boolean} */ save) => void this.model.open(url, save);
    askToOpen(this.#question, this.session, { url, open, stay: () => this.#url.focus() });
  }

  /** Keep a recording of this computer, or make a sample, then open it. @param {File | string | undefined} what */
  async #takeIn(what) {
    const url = what && (await this.model.take(what));
    this.#file.value = "";
    if (url) this.#request(url);
  }

  /** @override */
  draw() {
    const model = this.model;
    const { found } = model;
    if (found) {
      write(this.#title, inLanguage(found.name));
      const again = model.probed ? t("connect-robot.looked_at_again_the_console_keeps") : "";
      const whose = model.own
        ? again ||
          t(isRecording(found.url) ? "connect-robot.this_console_shows_it" : "connect-robot.this_console_drives_it")
        : t("connect-robot.only_looked_at_not_connected");
      write(this.#about, `${whose} · ${found.url}`);
      const [only] = found.parts;
      this.#has.hidden = !only || !isBare(only, found);
      if (only) write(this.#has, t("connect-robot.it_has", { equipment: equipment(only) }));
      const silent = found.parts.filter((part) => !part.up).map((part) => part.name);
      redraw(this.#state, silent.length ? "unlinked" : "link");
      this.#failsafe.hidden = isRecording(found.url);
      write(this.#failsafe, failsafe(inLanguage(found.failsafe)));
      if (this.#filled !== found.url) {
        this.#filled = found.url;
        this.#url.value = model.whyNot ? "" : found.url; // a simulator is not looked at
      }
    }
    this.#back.hidden = !model.probed && !model.changed;
    const opens = isOpened(this.#url.value.trim());
    [this.#look.hidden, this.#open.hidden] = [opens, !opens];
    const disabled = Boolean(model.busy) || !model.may || model.driver !== "";
    this.#look.disabled = this.#open.disabled = disabled;
    this.#control.hidden = !model.may || !model.driver;
    write(this.#driving, t("connect-robot.holder_drives_now", { holder: model.driver }));
    this.#ask.disabled = model.asked;
    this.#choose.hidden = this.#kind !== "recording" || !model.may;
    this.#choose.disabled = disabled;
    this.#samples.hidden = this.#choose.hidden || model.openedHere.length === 0;
    for (const button of this.#samples.querySelectorAll("button")) button.disabled = disabled;
    this.#find.hidden = !model.may || !["", "ros", "serial"].includes(this.#kind);
    this.#find.disabled = disabled;
    this.#drawAnswers(model.answers);
    this.#drawOthers(model, disabled);
    this.#url.disabled = !model.may;
    const why = model.may || !found ? "" : t("connect-robot.you_are_watching_only_an_operator");
    write(this.#status, model.busy || model.trouble || why);
    mark(this.#status, "data-tone", model.busy ? "busy" : model.trouble ? "fault" : null);
  }

  /** @param {import("../net/rest.js").FoundAddresses | null} answers */
  #drawAnswers(answers) {
    this.#answers.hidden = answers === null || this.#find.hidden;
    if (answers === this.#asked) return;
    this.#asked = answers;
    const { urls = [], looked_at: places = [] } = answers ?? {};
    const says = urls.length ? "connect-robot.these_answer" : "connect-robot.nobody_answers";
    const buttons = urls.map((url) =>
      make("button.button", { onclick: () => void this.model.look(url) }, icon("eye"), url),
    );
    this.#answers.replaceChildren(make("p.note", t(says, { places: places.join(", ") })), ...buttons);
  }

  /** @param {ConnectionModel} model @param {boolean} disabled */
  #drawOthers(model, disabled) {
    const begins = KINDS.find(([kind]) => kind === this.#kind)?.[2] ?? "";
    const urls = model.openedHere.filter((url) => url !== model.found?.url && url.startsWith(begins));
    if (!isNew(this, disabled, this.#kind, urls.join(" "))) return;
    for (const [kind, one] of this.#tiles) {
      mark(one, "aria-pressed", String(kind === this.#kind));
      one.disabled = !model.may;
    }
    mark(this.#guide, "href", `help#how-to/${GUIDES[this.#kind] ?? "connect-a-ros-robot"}.md`);
    const buttons = urls.map((url) => {
      const button = make("button.button", { onclick: () => this.#request(url) }, icon("play"), url);
      button.disabled = disabled;
      return button;
    });
    this.#others.hidden = urls.length === 0;
    this.#others.replaceChildren(make("p.note", t("connect-robot.open_instead_note")), ...buttons);
  }
}

/** @param {string} drawing @param {string} name @param {string} says */
const tile = (drawing, name, says) =>
  make(
    "button.connect-tile",
    { "aria-pressed": "false" },
    icon(drawing),
    make("span.connect-kind", name),
    make("span.note", says),
  );

/** True for a recording or a simulated robot, which are opened and not looked at. @param {string} url */
const isOpened = (url) => /^(log|sim):/.test(url);

/** What the robot does by itself without a word, as a sentence. @param {string} words */
function failsafe(words) {
  if (!words) return t("connect-robot.what_it_does_by_itself_when");
  return /^[A-Z]/.test(words) ? words : t("connect-robot.without_a_word_it_stops_by", { words });
}

customElements.define("connect-robot", ConnectRobot);
