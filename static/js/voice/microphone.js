// Microphone of the browser: pieces of 20 ms at 16 kHz, and the reason when there is none.

import { t } from "../ui/texts.js";

/**
 * @typedef {object} Piece
 * @property {ArrayBuffer} pcm 320 samples of 16 bit
 * @property {number} at [ms] of its first sample, counted in sound
 * @property {number} rms of full scale
 * @property {number} peak
 */
/** @typedef {{echoCancellation: boolean, noiseSuppression: boolean, autoGainControl: boolean}} Cleaning */
/** @typedef {"off" | "asking" | "on" | "refused"} MicrophoneState */

const WORKLET = new URL("./sinc-worklet.js", import.meta.url);

/** Return the reason why this page cannot use a microphone, or "". */
export function whyNot() {
  if (!globalThis.isSecureContext) return t("microphone.browsers_give_the_microphone_only_to");
  if (!navigator.mediaDevices?.getUserMedia) return t("microphone.this_browser_has_no_access_to");
  if (typeof AudioWorkletNode === "undefined") return t("microphone.this_browser_cannot_process_sound_use");
  return "";
}

/** Sentence for an error of the browser. @param {unknown} trouble */
export function inWords(trouble) {
  const name = trouble instanceof DOMException ? trouble.name : "";
  if (name === "NotAllowedError") return t("microphone.the_microphone_was_refused_allow_it");
  if (name === "NotFoundError" || name === "OverconstrainedError")
    return t("microphone.there_is_no_microphone_plug_one");
  if (name === "NotReadableError") return t("microphone.another_program_holds_the_microphone_close");
  return t("microphone.the_microphone_does_not_work_here");
}

export class Microphone {
  /** @type {MicrophoneState} */
  state = "off";
  why = whyNot();
  level = 0; // rms of full scale, of the newest piece
  peak = 0;
  /** @type {Record<string, any>} what the track says of itself */
  settings = {};
  /** @type {(piece: Piece) => void} */
  heard = () => undefined;
  /** @type {() => void} */
  changed = () => undefined;
  /** @type {MediaStream | null} */
  #stream = null;
  /** @type {AudioContext | null} */
  #context = null;

  /**
   * Opens it; asks the person where the browser wants that.
   * @param {Cleaning} cleaning what the browser may do to the sound; all of it spoils directions and measurements
   * @returns {Promise<boolean>}
   */
  async open(cleaning) {
    if (this.state === "on" || this.state === "asking") return this.state === "on";
    this.why = whyNot();
    if (this.why) return this.#become("refused");
    this.#become("asking");
    try {
      const stream = await navigator.mediaDevices.getUserMedia({
        audio: { channelCount: 1, ...cleaning },
        video: false,
      });
      this.#stream = stream;
      const [track] = stream.getAudioTracks();
      this.settings = track?.getSettings() ?? {};
      track?.addEventListener("ended", () => this.#ended(t("microphone.the_microphone_was_unplugged_or_taken")));
      const context = new AudioContext();
      this.#context = context;
      await context.audioWorklet.addModule(WORKLET);
      if (context.state === "suspended") await context.resume();
      const worklet = new AudioWorkletNode(context, "sinc-worklet", { numberOfInputs: 1, numberOfOutputs: 1 });
      worklet.port.onmessage = ({ data }) => {
        [this.level, this.peak] = [data.rms, data.peak];
        this.heard(data);
      };
      context.createMediaStreamSource(stream).connect(worklet);
      worklet.connect(context.destination); // silent; some browsers run only what leads somewhere
      return this.#become("on");
    } catch (trouble) {
      this.close();
      this.why = inWords(trouble);
      return this.#become("refused");
    }
  }

  close() {
    for (const track of this.#stream?.getTracks() ?? []) track.stop();
    void this.#context?.close().catch(() => undefined);
    this.#stream = this.#context = null;
    this.level = this.peak = 0;
    this.#become("off");
  }

  /** @param {string} why */
  #ended(why) {
    this.close();
    this.why = why;
    this.#become("refused");
  }

  /** @param {MicrophoneState} state */
  #become(state) {
    this.state = state;
    if (state === "on") this.why = "";
    this.changed();
    return state === "on";
  }
}
