// Element <voice-button>: push to talk (button, V, or a button of a gamepad), or an open microphone whose pauses end a sentence.

import { onlyWatched } from "../drive/permission.js";
import * as api from "../net/api.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { ModelOffer } from "../ui/model-offer.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { t } from "../ui/texts.js";
import { Talk } from "../voice/audio-socket.js";
import { Microphone } from "../voice/microphone.js";

/** @import { View } from "../net/session.js" */

const AFTER_MS = 180; // sound still on its way when the button is released belongs to the sentence
const OPEN_MS = 10 * 60 * 1000; // an open microphone closes by itself
const REST_MS = 60 * 1000; // an unused microphone is given back to the browser
const FLOOR_DB = -60;

const SWITCHES = /** @type {const} */ ([
  ["echoCancellation", t("voice-button.take_echoes_out"), t("voice-button.for_loudspeakers_next_to_the_microphone")],
  ["noiseSuppression", t("voice-button.take_noise_out"), t("voice-button.for_loud_rooms_it_costs_consonants")],
  ["autoGainControl", t("voice-button.level_automatically"), t("voice-button.for_quiet_microphones")],
]);

export class VoiceButton extends Panel {
  #icon = icon("microphone");
  #ring = make("span.voice-ring", { "aria-hidden": "true" });
  #button = make(
    "button.button.voice",
    { "aria-label": t("voice-button.hold_to_talk"), "aria-keyshortcuts": "V" },
    this.#ring,
    this.#icon,
  );
  #more = make("button.voice-more", { "aria-label": t("voice-button.microphone") }, icon("chevron"));
  #open = make("input.switch", { type: "checkbox", id: "voice-open" });
  #facts = make("p.note");
  #speaker = make("select.field-box", { id: "voice-speaker" });
  #speakerRow = make(
    "label.voice-row",
    { for: "voice-speaker", hidden: true },
    make("span", t("voice-button.in_the_simulator_you_speak_as")),
    this.#speaker,
  );
  /** @type {string[]} */
  #people = []; // in the simulated room
  #offer = new ModelOffer(
    api.recognizer,
    async () => {
      await api.fetchModel();
      this.#close(); // the next words are read with it
    },
    (act) => this.session.attempt(act),
  );
  #says = make("p.voice-says", { role: "status" });
  #panel = make(
    "div.voice-panel",
    { role: "group", "aria-label": t("voice-button.microphone") },
    make("h2.card-title", t("voice-button.microphone")),
    make("p.note", t("voice-button.hold_the_button_or_v_speak")),
    make(
      "label.voice-row",
      { for: "voice-open" },
      this.#open,
      make("span", t("voice-button.leave_it_open_pauses_end_a")),
    ),
    ...SWITCHES.map(([name, says, why]) => this.#cleaner(name, says, why)),
    this.#speakerRow,
    this.#facts,
    ...this.#offer.elements,
  );
  #microphone = new Microphone();
  #talk = new Talk();
  #held = false;
  #muted = false; // the robot speaks in this browser and must not hear itself
  /** @type {"held" | "open"} */
  #mode = "held";
  #listening = false;
  #stopped = false; // STOP was pressed since the button was
  #why = "";
  #shown = false; // this microphone's sound is shown in the status line
  #starting = false; // what reads the words is being started
  #soFar = ""; // words of the sentence under way
  #until = 0; // [ms] when an open microphone closes
  #used = 0; // [ms]

  /** @override */
  build() {
    const answers = this.querySelector("answer-button");
    if (answers) this.#panel.append(answers);
    this.append(this.#button, this.#more, this.#panel, this.#says);
    popover(this.#more, this.#panel, {
      opened: () => {
        this.#talk.open(); // so that the first word finds a worker
        this.#tellFacts();
        void this.#offer.show();
      },
    });
    this.#button.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.#button.setPointerCapture(event.pointerId);
      this.hold(true);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      this.#button.addEventListener(end, () => this.hold(false));
    this.#button.addEventListener("contextmenu", (event) => event.preventDefault());
    this.#button.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && !event.repeat) this.hold(true);
    });
    this.#button.addEventListener("keyup", (event) => event.key === "Enter" && this.hold(false));
    this.#open.addEventListener("change", () => void this.#leaveOpen(this.#open.checked));
    this.#microphone.changed = () => this.#draw();
    this.#microphone.heard = (piece) => {
      if (this.#muted) this.#talk.forget();
      else this.#talk.add(piece);
      this.#level();
    };
    this.#talk.turned = (on, remark) => {
      this.#listening = on;
      if (remark) this.session.complain(remark);
      this.#draw();
    };
    this.#talk.wasRead = () => this.session.tell("read", null);
    this.#talk.heard = (transcript) => this.session.transcribe({ ...transcript, held: this.#mode === "held" });
    this.#talk.heardSoFar = (words) => {
      this.#soFar = words.replace(/[.,!?\s]+$/, "");
      if (!this.#held && !this.#open.checked) this.session.tell("so-far", this.#soFar);
      this.#draw();
    };
    this.#talk.ended = (why) => {
      this.#held = this.#listening = false;
      this.#open.checked = false;
      this.#complain(why);
    };
    document.addEventListener("visibilitychange", () => {
      if (document.visibilityState === "hidden") this.#close();
    });
    this.session.on("stopped", () => {
      this.#stopped = true;
      this.hold(false);
    });
    this.session.on("speaking", (speaking) => {
      this.#muted = speaking;
      this.#draw();
    });
    addEventListener("room-people", (event) =>
      this.#offerSpeakers(/** @type {CustomEvent<import("../net/rest.js").PersonInRoom[]>} */ (event).detail),
    );
    this.#speaker.addEventListener("change", () => remember("voice.speaker", this.#speaker.value));
    setInterval(() => this.#expire(performance.now()), 1000);
    this.#draw();
  }

  /** @param {boolean} down */
  hold(down) {
    if (down === this.#held || this.#open.checked || this.hidden) return;
    this.#held = down;
    if (down) void this.#begin("held");
    else {
      if (this.#talk.speaking && !this.#stopped) this.session.tell("reading", this.#soFar);
      setTimeout(() => !this.#held && this.#talk.rest(), AFTER_MS);
    }
    this.#draw();
  }

  /** @override @param {View} view */
  show({ hello, state, up }) {
    const starting = state?.ears?.starting === true && this.#people.length > 0;
    if (starting !== this.#starting) {
      this.#starting = starting;
      this.#draw();
    }
    this.hidden = onlyWatched(hello);
    this.#button.disabled = !up;
    mark(this.#button, "data-halted", state?.gate.state === "halted"); // words move nothing then
    if (!up && this.#held) this.hold(false);
  }

  /** @param {"held" | "open"} mode */
  async #begin(mode) {
    this.#why = this.#soFar = "";
    this.#stopped = false;
    this.#mode = mode;
    this.#used = performance.now();
    this.session.tell("interrupt", null);
    this.#talk.open();
    if (!(await this.#microphone.open(cleaning()))) {
      this.#held = this.#open.checked = false;
      this.#complain(this.#microphone.why);
      return;
    }
    if (mode === "held" && !this.#held) return; // released while the browser asked
    this.#talk.begin(mode, this.session.seen, this.#people.length > 0 ? this.#speaker.value : "");
    this.#draw();
  }

  /** @param {import("../net/rest.js").PersonInRoom[]} people in the simulated room */
  #offerSpeakers(people) {
    const ids = people.map(({ id }) => id);
    if (ids.join("|") === this.#people.join("|")) return;
    this.#people = ids;
    const chosen = remembered("voice.speaker", "nearest");
    const offers = [
      ["nearest", t("voice-button.the_nearest_person_in_sight")],
      ...ids.map((id) => [id, id]),
      ["", t("voice-button.yourself_from_no_place")],
    ];
    this.#speaker.replaceChildren(...offers.map(([value, words]) => make("option", { value }, words)));
    this.#speaker.value = [...ids, "nearest", ""].includes(chosen) ? chosen : "nearest";
    this.#speakerRow.hidden = ids.length === 0;
  }

  /** @param {boolean} open */
  async #leaveOpen(open) {
    this.#until = performance.now() + OPEN_MS;
    if (open) await this.#begin("open");
    else this.#close();
    this.#draw();
  }

  #close() {
    this.#held = this.#listening = false;
    this.#open.checked = false;
    this.#talk.rest();
    this.#talk.close();
    this.#microphone.close();
  }

  /** @param {number} now [ms] */
  #expire(now) {
    if (this.#held || this.#microphone.state !== "on") return;
    if (this.#open.checked ? now > this.#until : now - this.#used > REST_MS) {
      if (this.#open.checked) this.session.complain(t("voice-button.the_microphone_was_open_for_ten"));
      this.#close();
    }
  }

  /** @param {string} name @param {string} says @param {string} why */
  #cleaner(name, says, why) {
    const box = make("input.switch", { type: "checkbox", id: `voice-${name}`, checked: isOn(name) });
    box.addEventListener("change", () => {
      remember(`voice.${name}`, String(box.checked));
      this.#close(); // takes effect when it is opened next
    });
    return make("label.voice-row", { for: `voice-${name}` }, box, make("span", says, make("span.note", ` ${why}`)));
  }

  #tellFacts() {
    const { sampleRate, echoCancellation } = this.#microphone.settings;
    const rate = typeof sampleRate === "number" ? `${sampleRate / 1000} kHz` : "";
    write(
      this.#facts,
      this.#microphone.state === "on"
        ? t("voice-button.on_join", {
            join: [rate, echoCancellation ? t("voice-button.echoes_taken_out") : t("voice-button.sound_untouched")]
              .filter(Boolean)
              .join(", "),
          })
        : this.#microphone.why || t("voice-button.off_the_browser_asks_before_it"),
    );
  }

  /** @param {string} why */
  #complain(why) {
    this.#why = why;
    if (why) this.session.announce(why);
    this.#draw();
  }

  #level() {
    const decibel = 20 * Math.log10(this.#microphone.level + 1e-6);
    const part = Math.max(0, Math.min(1, 1 - decibel / FLOOR_DB));
    this.#ring.style.setProperty("--level", part.toFixed(3));
    mark(this.#button, "data-clipped", this.#microphone.peak > 0.99);
    this.#tellHearing(part);
  }

  /** @param {number} level 0..1 */
  #tellHearing(level) {
    const shown = this.#held;
    if (shown || this.#shown) this.session.tell("hearing", shown ? { words: this.#soFar, level } : null);
    this.#shown = shown;
  }

  #draw() {
    const { state } = this.#microphone;
    const open = this.#open.checked;
    const speaking = this.#held || open;
    mark(this.#button, "data-state", state === "refused" || this.#why ? "refused" : speaking ? "on" : "off");
    mark(this.#button, "aria-pressed", String(speaking));
    redraw(this.#icon, state === "refused" ? "muted" : "microphone");
    if (!speaking) this.#ring.style.setProperty("--level", "0");
    if (!this.#held && this.#shown) this.#tellHearing(0);
    const hint =
      state === "asking" ? t("voice-button.allow_the_microphone_in_the_browser") : t("voice-button.starting");
    const words = speaking
      ? this.#listening && state === "on"
        ? this.#muted
          ? t("voice-button.muted_while_the_robot_speaks")
          : open
            ? t("voice-button.open_say_a_command")
            : this.#soFar
              ? `“${this.#soFar} …”`
              : this.#starting
                ? t("voice-button.getting_the_ears_ready")
                : t("voice-button.listening")
        : hint
      : "";
    write(this.#says, this.#why || words);
    mark(this.#says, "data-tone", this.#why ? "stale" : "live");
    const elsewhere = this.#held && this.#listening && state === "on" && !this.#muted && !this.#starting;
    this.#says.hidden = !(this.#why || words) || (elsewhere && !this.#why); // the status over the map says it
  }
}

/** Whether the browser cleans the sound that way. @param {string} name of a switch */
const isOn = (name) => remembered(`voice.${name}`, "false") === "true";

const cleaning = () =>
  /** @type {import("../voice/microphone.js").Cleaning} */ (
    Object.fromEntries(SWITCHES.map(([name]) => [name, isOn(name)]))
  );

customElements.define("voice-button", VoiceButton);
