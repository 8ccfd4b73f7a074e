// Element <hearing-card>: directions of voices, transcripts, and the microphone check.

import { onlyWatched } from "../drive/permission.js";
import * as api from "../net/api.js";
import { cardHead, icon, make, mark, write } from "../ui/element.js";
import { degrees, inWords } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { PeopleNear } from "../ui/people-near.js";
import { SoundRose } from "../ui/sound-rose.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */
/** @import { Transcript } from "../voice/audio-socket.js" */

const MOST_LINES = 6;
const CHECK = t("hearing-card.check_the_microphones");

class HearingCard extends Panel {
  #rose = new SoundRose();
  #where = make("p.hearing-where");
  #listen = make("button.toggle", { "aria-pressed": "false" }, t("hearing-card.listen"));
  #obey = make(
    "button.toggle",
    { "aria-pressed": "false", title: t("hearing-card.execute_commands_of_voices_in_the") },
    t("hearing-card.obey"),
  );
  #check = make("button", { onclick: () => void this.#examine() }, CHECK);
  #faults = make("ul.faults", { role: "status", hidden: true });
  #measure = make("a", { href: "hearing" }, t("hearing-card.how_well_does_it_hear_you"));
  #lines = make("ol.transcripts", { "aria-label": t("hearing-card.what_was_heard") });
  #checking = false;
  /** @type {PeopleNear | null} */
  #near = null;
  #none = make("p.note");

  /** @override */
  build() {
    this.#near = new PeopleNear(this.session);
    this.append(
      cardHead(t("hearing-card.what_it_hears"), this.#listen, this.#obey),
      this.#near,
      make("div.hearing", this.#rose, make("div.hearing-words", this.#where, this.#none, this.#lines)),
      make("div.hearing-foot", this.#check, this.#measure),
      this.#faults,
    );
    this.#obey.addEventListener("click", () => void this.#takeOn());
    this.#listen.addEventListener("click", () => void this.#toggle());
    this.session.on("transcript", (transcript) => this.#add(transcript));
  }

  /** @override @param {View} view */
  show(view) {
    const { state, hello, up, permission } = view;
    this.#near?.show(view);
    const ears = state?.ears ?? null;
    this.hidden = onlyWatched(hello) || (ears === null && this.#lines.childElementCount === 0);
    if (this.hidden) return;
    this.classList.toggle("is-old", !up);
    mark(this.#rose, "hidden", ears === null);
    this.#listen.hidden = this.#obey.hidden = this.#check.hidden = ears === null;
    this.#measure.hidden = !hello?.robot.capabilities.includes("simulate");
    this.#check.disabled = !up || permission.may === "no" || this.#checking;
    this.#listen.disabled = this.#obey.disabled = !up || permission.may === "no";
    mark(this.#obey, "aria-pressed", String(ears?.voice_control ?? false));
    if (!ears?.muted) mark(this.#listen, "aria-pressed", String(ears?.listening ?? false));
    this.#rose.show(ears);
    const [voice] = ears?.voices ?? [];
    const on = this.#listen.getAttribute("aria-pressed") === "true";
    const quiet = on ? silence(ears) : "";
    write(this.#where, voice ? describe(voice) : quiet);
    this.#where.hidden = this.#where.textContent === "";
    write(this.#none, hint(on, ears?.voice_control ?? false));
  }

  /** Check three seconds of sound for wiring faults. */
  async #examine() {
    if (!this.#faults.hidden) {
      this.#faults.hidden = true;
      write(this.#check, CHECK);
      return;
    }
    const simulated = this.session.hello?.robot.capabilities.includes("simulate") === true;
    this.#checking = true;
    write(
      this.#check,
      simulated ? t("hearing-card.the_simulated_person_speaks") : t("hearing-card.speak_for_three_seconds"),
    );
    await this.session.attempt(async () => {
      const { well, faults } = await api.checkArray(simulated);
      const rows = faults.map(({ sentence, serious }) => fault(sentence, serious ? "warning" : "info"));
      this.#faults.replaceChildren(
        ...(well ? [fault(t("hearing-card.every_channel_works_and_all_of"), "done")] : []),
        ...rows,
      );
      this.#faults.hidden = false;
    });
    this.#checking = false;
    write(this.#check, this.#faults.hidden ? CHECK : t("hearing-card.hide_the_result"));
  }

  async #toggle() {
    const on = this.#listen.getAttribute("aria-pressed") !== "true";
    await this.session.attempt(() => api.listen(on));
  }

  /** Switch voice control from the room on or off. */
  async #takeOn() {
    const on = this.#obey.getAttribute("aria-pressed") !== "true";
    await this.session.attempt(() => api.obeyVoices(on));
  }

  /** @param {Transcript} transcript */
  #add({ words, accepted, heard_as, reason, final }) {
    this.#none.hidden = true;
    const said = accepted ? heard_as : words;
    const line = make(
      "li.transcript",
      { "data-state": accepted ? "accepted" : "refused" },
      icon(accepted ? "done" : "refused"),
      make(
        "span",
        make("span.transcript-words", said ? `“${said}”` : t("hearing-card.not_understood")),
        reason && make("span.note", ` ${reason}`),
        !final && make("span.note", t("hearing-card.before_the_sentence_was_over")),
      ),
    );
    this.#lines.prepend(line);
    while (this.#lines.childElementCount > MOST_LINES) this.#lines.lastElementChild?.remove();
    this.session.announce(
      accepted
        ? t("hearing-card.heard_heardas", { heardas: heard_as })
        : t("hearing-card.heard_but_refused_reason", { reason }),
    );
  }
}

/** One finding of the self-check. @param {string} sentence @param {"warning" | "info" | "done"} kind */
const fault = (sentence, kind) => make("li.fault", { "data-kind": kind }, icon(kind), make("span", sentence));

/**
 * Sentence while the robot listens and hears no voice.
 * @param {import("../net/messages.js").HearingState | null} ears
 */
function silence(ears) {
  if (ears?.muted) return t("hearing-card.not_listening_while_the_robot_speaks");
  return ears?.starting
    ? t("hearing-card.hears_directions_of_voices_speech_recognition")
    : t("hearing-card.listening_no_voice");
}

/**
 * Hint before the first transcript.
 * @param {boolean} listening
 * @param {boolean} voice_control true when voices in the room give commands
 */
function hint(listening, voice_control) {
  if (!listening) return t("hearing-card.hold_the_microphone_v_and_speak");
  if (!voice_control) return t("hearing-card.hold_the_microphone_v_and_speak_2");
  return t("hearing-card.say_a_command_in_the_room");
}

/** Sentence about the direction of a voice. @param {import("../net/messages.js").VoiceHeard} voice */
function describe({ azimuth_rad, sd_heard_rad, ambiguity }) {
  return t("hearing-card.a_voice_inwords_degrees_value", {
    inwords: inWords(azimuth_rad),
    degrees: degrees(2 * sd_heard_rad, 0),
    value: ambiguity ? ` ${ambiguity}` : "",
  });
}

customElements.define("hearing-card", HearingCard);
