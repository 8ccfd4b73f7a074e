// Element <recordings-list>: every recording, newest first: play, take away, a part or its film, rename, delete.

import { askToOpen } from "../connect/opening.js";
import { fileOf, filmOf, pictureOf } from "../net/recordings-api.js";
import { icon, iconButton, make, mark, onSubmit, write } from "../ui/element.js";
import { PagePanel } from "../ui/panel.js";
import { recorderOf } from "../ui/recorder.js";
import { confirmIn, questionIn } from "../ui/row-question.js";
import { t } from "../ui/texts.js";
import { askForPart } from "./part-form.js";
import { about, stateOf, urlOf } from "./recordings-model.js";

/** @import { View } from "../net/session.js" */
/** @import { FinishedRecording as Recording } from "../net/rest.js" */
/** @import { RecordingsModel } from "./recordings-model.js" */

const DRAWINGS = { runs: "recording", whole: "tape", cut: "warning", unfinished: "warning" };

/** @extends {PagePanel<RecordingsModel>} */
class RecordingsList extends PagePanel {
  #status = make("p.map-trouble", { role: "status", hidden: true });
  #watches = make("p.note", { hidden: true }, t("recordings-list.only_an_operator_plays"));
  #list = make("ul.maps", { "aria-label": t("recordings-list.recordings_newest_first") });
  #empty = make(
    "div.recordings-empty",
    { hidden: true },
    icon("tape"),
    make("p", t("recordings-list.nothing_is_recorded_yet")),
    make("p.note", t("recordings-list.press_record_and_drive")),
  );
  /** @type {Map<string, {row: HTMLElement, drawn: string}>} */
  #rows = new Map();
  /** @type {string | null} */
  #running = null;
  #may = false;

  /** @override */
  build() {
    this.append(this.#status, this.#watches, this.#empty, this.#list);
  }

  /** @override @param {View} view */
  show(view) {
    const may = view.up && this.model.may === true;
    const running = view.state?.recording?.name ?? null;
    if (may !== this.#may || running !== this.#running) {
      [this.#may, this.#running] = [may, running];
      this.draw();
    }
    const now = this.#list.querySelector("[data-state=runs] .recording-about");
    const { time, size } = recorderOf(view);
    if (now && running) write(now, [time, size].join(" · "));
  }

  /** @override */
  draw() {
    const { recordings, busy, trouble } = this.model;
    const does = busy || (recordings || trouble ? "" : t("recordings-list.reading"));
    write(this.#status, does || trouble);
    mark(this.#status, "data-tone", does ? "busy" : null);
    this.#status.hidden = !(does || trouble);
    if (!recordings) return;
    this.#empty.hidden = recordings.length > 0;
    this.#watches.hidden = this.model.may || recordings.length === 0;
    /** @type {Map<string, {row: HTMLElement, drawn: string}>} */
    const rows = new Map();
    for (const one of recordings) {
      const drawn = JSON.stringify([one, stateOf(one, this.#running), this.#may]);
      const before = this.#rows.get(one.name);
      rows.set(one.name, before?.drawn === drawn ? before : { row: this.#row(one), drawn }); // an open form stays
    }
    this.#rows = rows;
    const wanted = [...rows.values()].map(({ row }) => row);
    const same =
      wanted.length === this.#list.children.length && wanted.every((row, at) => row === this.#list.children[at]);
    if (!same) this.#list.replaceChildren(...wanted);
  }

  /** @param {Recording} one */
  #row(one) {
    const { name, note, cause } = one;
    const state = stateOf(one, this.#running);
    const picture = pictureOf(one);
    const acts = make("div.map-acts");
    const row = make(
      "li.row.map.recording",
      { "data-state": state, "data-recording": name },
      picture && state === "whole"
        ? make("img.map-preview", { src: picture, alt: "", width: "80", height: "60", loading: "lazy" })
        : icon(DRAWINGS[state]),
      make(
        "div.map-body",
        make("p.inline.map-name", name),
        make("p.note.recording-about", about(one)),
        cause && make("p.recording-cause", cause),
        note && make("p.recording-note", note),
      ),
      acts,
    );
    if (state === "runs" || state === "unfinished") return row;
    /** @param {string} drawing @param {string} says @param {() => void} then */
    const act = (drawing, says, then) => acts.append(iconButton(drawing, says, then, { title: says, look: "small" }));
    const says = t("recordings-list.play_name", { name });
    const play = { "aria-label": says, onclick: () => this.#play(row, one) };
    if (this.#may) acts.append(make("button.button", play, icon("play"), t("recordings-list.play")));
    const link = {
      href: fileOf(name),
      download: "",
      "aria-label": t("map-card.download_name", { name }),
      title: t("map-card.download"),
    };
    acts.append(make("a", { class: "icon-button small", ...link }, icon("download")));
    if (state === "whole" && one.seconds > 0)
      act("cut", t("recordings-list.part_name", { name }), () => this.#part(row, one));
    if (!this.#may) return row;
    act("pencil", t("recordings-list.change_name", { name }), () => this.#change(row, one));
    const sentence = t("recordings-list.delete_this_recording_for_good");
    const remove = () => void this.model.remove(name);
    act("trash", t("map-card.delete_name", { name }), () => confirmIn(row, sentence, t("map-card.delete"), remove));
    return row;
  }

  /** @param {HTMLElement} row @param {Recording} one */
  #play(row, one) {
    const question = questionIn(row, "div", { role: "group", hidden: true });
    askToOpen(question, this.session, {
      url: urlOf(one),
      open: (save) => void this.model.play(one, save),
      stay: () => focusOn(row),
    });
  }

  /** @param {HTMLElement} row @param {Recording} one */
  #part(row, { name, seconds }) {
    const form = questionIn(row, "form", { "aria-label": t("recordings-list.part_name", { name }) });
    askForPart(form, {
      seconds,
      may: this.#may,
      film: (part, kind) => filmOf(name, part, kind),
      cut: async (part) => (await this.model.cut(name, part)) && form.remove(),
      leave: () => close(form, row),
    });
  }

  /** @param {HTMLElement} row @param {Recording} one */
  #change(row, { name, note }) {
    const named = make("input.field-box", {
      value: name,
      maxlength: "80",
      required: true,
      autocomplete: "off",
      spellcheck: "false",
    });
    const noted = make("input.field-box", { value: note, maxlength: "2000", autocomplete: "off" });
    const form = questionIn(row, "form", { "aria-label": t("recordings-list.change_name", { name }) });
    const leave = make("button.button", { onclick: () => close(form, row) }, t("map-card.leave_it"));
    form.append(
      make("label", t("recordings-list.name"), named),
      make("label", t("recordings-list.note"), noted),
      make("button.button.primary", { type: "submit" }, t("map-card.save")),
      leave,
    );
    onSubmit(form, async () => {
      const fresh = { name: named.value.trim(), note: noted.value.trim() };
      if (!(await this.model.change(name, fresh))) return;
      form.remove();
      focusOn(this.#rows.get(fresh.name)?.row ?? null);
    });
    form.addEventListener("keydown", (event) => event.key === "Escape" && close(form, row));
    named.focus();
    named.select();
    form.scrollIntoView({ block: "nearest" });
  }
}

/** @param {HTMLElement} question @param {HTMLElement} row */
function close(question, row) {
  question.remove();
  focusOn(row);
}

/** @param {HTMLElement | null} row */
const focusOn = (row) => row?.querySelector("button")?.focus();

customElements.define("recordings-list", RecordingsList);
