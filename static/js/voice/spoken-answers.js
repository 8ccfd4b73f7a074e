// Spoken answers to a command: confirmation, refusal, result.

/** @import { HistoryRow } from "../net/rest.js" */
/** @import { Transcript } from "./audio-socket.js" */

const LONGEST = 280; // characters; the rest is only written
const STOPS = "stop moving";

/** Turn words into a sentence for speech output. @param {string} words */
export function sentence(words) {
  const plain = words.trim().replace(/[“”]/g, "").replace(/−/g, "minus ").replace(/\s+/g, " ");
  if (!plain) return "";
  const cut = plain.length > LONGEST ? `${plain.slice(0, LONGEST).replace(/\s\S*$/, "")}.` : plain;
  const whole = cut.charAt(0).toUpperCase() + cut.slice(1);
  return /[.!?]$/.test(whole) ? whole : `${whole}.`;
}

/** @param {string} heardAs a command as it was understood */
export const accepted = (heardAs) => (heardAs === STOPS ? "Stopping." : sentence(heardAs));

/** @param {string} reason */
export const refused = (reason) => sentence(reason || "I did not understand that");

/** Sentence about the result of a command, or "". @param {HistoryRow} row */
export function ended({ state, name, remark }) {
  if (state === "done") return name === "stop_moving" ? "" : sentence(remark || "Done");
  if (state === "failed") return sentence(remark || "That did not work");
  return state === "refused" ? refused(remark) : "";
}

/** Answer to a transcript; "" for speech that was not a command. @param {Transcript} transcript */
export function answer({ final, accepted: taken, heard_as, words, reason, held, overtaken }) {
  if (taken) return accepted(heard_as);
  if (overtaken) return "";
  return final && (held || words) ? refused(reason) : "";
}

/**
 * The words that a route says at its stops, of notices that came after one.
 * @param {ReadonlyArray<{ id: number, text: string, cause?: string }>} notices
 * @param {number} known id of that one
 */
export const saidAtStops = (notices, known) =>
  notices.filter(({ id, cause }) => id > known && cause?.startsWith("say ")).map(({ text }) => text);

/**
 * Remove the suggestions of a refused transcript that a STOP followed, or that belongs to the sentence with the
 * STOP.
 * @param {Transcript} transcript
 * @param {number} now [ms]
 * @param {number} stoppedAt [ms]
 * @returns {Transcript}
 */
export function unlessStopped(transcript, now, stoppedAt) {
  const { accepted, delay_s, seconds } = transcript;
  if (accepted || now - (delay_s + seconds) * 1000 > stoppedAt) return transcript;
  return { ...transcript, suggestions: [], overtaken: true };
}
