// WebSocket for speech: sends pieces of sound, receives transcripts.

import { socketAddress } from "../net/api.js";
import { inLanguage, t, translate } from "../ui/texts.js";

/** @import { AllRead, ListeningMessage as Listening, PartialTranscript as Partial } from "../net/messages.js" */
/** @import { Piece } from "./microphone.js" */
/**
 * A transcript, and what the page adds: `held`: the button was held, so it was surely meant for the robot; `overtaken`: a
 * STOP came after these words began, and nothing of them is offered.
 * @typedef {import("../net/messages.js").Transcript & {held?: boolean, overtaken?: boolean}} Transcript
 */

const HEADER_BYTES = 16;
const AUDIO_KIND = 2;
const REST = JSON.stringify({ kind: "rest" });
const BEFORE = 25; // pieces kept from before the press: half a second, in which the room's noise is learnt
const MOST_WAITING = 65536; // bytes; what a slow line holds up is dropped, not queued

export class Talk {
  /** @type {(transcript: Transcript) => void} */
  heard = () => undefined;
  /** @type {(words: string) => void} words so far of the sentence under way */
  heardSoFar = () => undefined;
  /** @type {(why: string) => void} reason of the end; "" when it was requested */
  ended = () => undefined;
  /** @type {() => void} all that was said has been read: no words of it come any more */
  wasRead = () => undefined;
  /** @type {(on: boolean, remark: string) => void} */
  turned = () => undefined;
  /** @type {WebSocket | null} */
  #socket = null;
  /** @type {{pcm: ArrayBuffer, at: number}[]} */
  #before = [];
  #speaking = false;
  /** Asked for while the socket opens: sent as soon as it is open; "" where nothing is. */
  #request = "";
  #number = 0;

  get speaking() {
    return this.#speaking;
  }

  /** Opens the socket, so that the first word finds it open. */
  open() {
    if (this.#socket) return;
    const socket = new WebSocket(socketAddress("ws/audio"));
    this.#socket = socket;
    socket.addEventListener("open", () => this.#request && this.#listen(socket, this.#request));
    socket.addEventListener("message", ({ data }) => this.#hear(JSON.parse(data)));
    socket.addEventListener("close", ({ reason, wasClean }) => {
      if (this.#socket !== socket) return;
      this.#socket = null;
      const lost = this.#speaking || this.#request !== "";
      this.#speaking = false;
      this.#request = "";
      this.wasRead();
      this.ended(reason || (lost || !wasClean ? t("audio-socket.the_link_for_sound_was_lost") : ""));
    });
  }

  close() {
    const socket = this.#socket;
    this.#socket = null;
    this.#speaking = false;
    this.#request = "";
    this.#before = [];
    socket?.close(1000);
  }

  /**
   * @param {"held" | "open"} mode
   * @param {number} seen number of the newest state
   * @param {string} [speaker] person in the simulated room from whose mouth it comes
   */
  begin(mode, seen, speaker = "") {
    const socket = this.#socket;
    if (!socket || this.#speaking) return false;
    this.#speaking = true;
    const request = JSON.stringify({ kind: "listen", mode, seen, speaker });
    if (socket.readyState === WebSocket.OPEN) this.#listen(socket, request);
    else this.#request = request;
    return true;
  }

  /** Begin a turn; one that was over before the socket was open ends at once, with its words. @param {WebSocket} socket @param {string} request */
  #listen(socket, request) {
    this.#request = "";
    socket.send(request);
    for (const { pcm, at } of this.#before) this.#send(pcm, at);
    this.#before = [];
    if (!this.#speaking) socket.send(REST);
  }

  /** @returns {boolean} true when there is speech to transcribe */
  rest() {
    if (!this.#speaking) return false;
    this.#speaking = false;
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(REST);
    return true;
  }

  /** Drop the sound from before the press: the robot itself was speaking. */
  forget() {
    this.#before = [];
  }

  /** @param {Piece} piece */
  add({ pcm, at }) {
    if (this.#speaking && this.#socket?.readyState === WebSocket.OPEN) this.#send(pcm, at);
    else {
      this.#before.push({ pcm, at });
      const most = this.#request ? 8 * BEFORE : BEFORE; // while the socket opens, speech is kept too
      if (this.#before.length > most) this.#before.shift();
    }
  }

  /** @param {ArrayBuffer} pcm @param {number} at [ms] */
  #send(pcm, at) {
    const socket = this.#socket;
    if (!socket) return;
    if (socket.bufferedAmount > MOST_WAITING) return;
    const message = new Uint8Array(HEADER_BYTES + pcm.byteLength);
    const header = new DataView(message.buffer);
    header.setUint8(0, AUDIO_KIND);
    header.setUint32(4, this.#number, true);
    header.setFloat64(8, at, true);
    message.set(new Uint8Array(pcm), HEADER_BYTES);
    this.#number += 1;
    socket.send(message);
  }

  /** @param {Transcript | Listening | Partial | AllRead} message */
  #hear(message) {
    if (message.kind === "transcript") {
      translate(message, "reason");
      this.heard(message);
    } else if (message.kind === "partial") this.heardSoFar(message.words);
    else if (message.kind === "read") this.wasRead();
    else {
      this.turned(message.on, message.on ? inLanguage(message.why) : "");
      if (!message.on && message.why) {
        this.#speaking = false;
        this.wasRead();
        this.ended(inLanguage(message.why));
      }
    }
  }
}
