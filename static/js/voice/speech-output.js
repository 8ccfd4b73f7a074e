// Speech output in this browser: the newest sentence wins; reports while it speaks.

import * as api from "../net/api.js";
import { t } from "../ui/texts.js";

/** @import { SpokenAnswer } from "../net/rest.js" */

const TAIL_MS = 300; // the room still sounds, and sound is on its way

export class SpeechOutput {
  /** @type {(speaking: boolean) => void} from before the first word until a moment after the last */
  changed = () => undefined;
  /** @type {(why: string) => void} */
  failed = () => undefined;
  /** @type {AudioContext | null} */
  #context = null;
  /** @type {AudioBufferSourceNode | null} */
  #source = null;
  /** @type {string[]} */
  #waiting = [];
  #busy = false;
  #speaking = false;
  #turn = 0; // counts sentences begun and broken off
  #tail = 0;

  get speaking() {
    return this.#speaking;
  }

  /** Enable playback: browsers require a press of a key or pointer, so call this from one. */
  wake() {
    this.#context ??= new AudioContext();
    if (this.#context.state === "suspended") void this.#context.resume().catch(() => undefined);
  }

  /** @param {string} text said after the sentence under way, instead of those that wait */
  say(text) {
    if (!text) return;
    this.#waiting = [text];
    void this.#go();
  }

  hush() {
    this.#waiting = [];
    this.#turn += 1;
    this.#source?.stop();
  }

  async #go() {
    if (this.#busy) return;
    this.#busy = true;
    for (let text = this.#waiting.shift(); text !== undefined; text = this.#waiting.shift()) await this.#one(text);
    this.#busy = false;
  }

  /** @param {string} text */
  async #one(text) {
    const turn = ++this.#turn;
    try {
      const said = await api.voice(text);
      this.wake();
      if (turn === this.#turn && this.#context?.state === "running") {
        this.#set(true);
        await this.#play(this.#context, said);
      }
      void api.hush(said.id).catch(() => undefined); // the console notices the end by itself
    } catch (refusal) {
      this.#source = null;
      this.failed(api.sentenceOf(refusal, t("speech-output.the_robot_s_voice_does_not")));
    }
    clearTimeout(this.#tail); // silence again, in a moment
    this.#tail = setTimeout(() => !this.#source && this.#set(false), TAIL_MS);
  }

  /** @param {AudioContext} context @param {SpokenAnswer} said */
  #play(context, { pcm, rate_hz }) {
    const bytes = Uint8Array.from(atob(pcm), (letter) => letter.charCodeAt(0));
    const samples = Float32Array.from(new Int16Array(bytes.buffer), (sample) => sample / 32768);
    const buffer = context.createBuffer(1, samples.length, rate_hz);
    buffer.copyToChannel(samples, 0);
    const source = context.createBufferSource();
    source.buffer = buffer;
    source.connect(context.destination);
    this.#source = source;
    return /** @type {Promise<void>} */ (
      new Promise((resolve) => {
        source.addEventListener("ended", () => {
          if (this.#source === source) this.#source = null;
          resolve();
        });
        source.start();
      })
    );
  }

  /** @param {boolean} speaking */
  #set(speaking) {
    if (speaking === this.#speaking) return;
    this.#speaking = speaking;
    this.changed(speaking);
  }
}
