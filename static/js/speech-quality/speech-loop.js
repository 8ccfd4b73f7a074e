// Entry point of the page of `beckon speech-quality --live --browser`: plays the sound, records it, shows the figures.

import { Microphone } from "../voice/microphone.js";

const AFTER_MS = 500; // of recording after the sound
const RAW = { echoCancellation: false, noiseSuppression: false, autoGainControl: false };

const begin = /** @type {HTMLButtonElement} */ (document.getElementById("begin"));
const state = /** @type {HTMLElement} */ (document.getElementById("state"));
const figures = /** @type {HTMLElement} */ (document.getElementById("figures"));

/** @param {HTMLAudioElement} sound */
const played = (sound) =>
  new Promise((resolve, reject) => {
    sound.addEventListener("ended", resolve, { once: true });
    sound.addEventListener("error", () => reject(new Error("The sound cannot be played here.")), { once: true });
    sound.play().catch(reject);
  });

async function run() {
  const microphone = new Microphone();
  /** @type {ArrayBuffer[]} */
  const pieces = [];
  microphone.heard = ({ pcm }) => pieces.push(pcm);
  if (!(await microphone.open(RAW))) throw new Error(microphone.why);
  try {
    state.textContent = "Playing and recording…";
    await played(new Audio("orig.wav"));
    await new Promise((resolve) => setTimeout(resolve, AFTER_MS));
  } finally {
    microphone.close();
  }
  state.textContent = "The words are read…";
  const answer = await fetch("rev", { method: "POST", body: new Blob(pieces) });
  if (!answer.ok) throw new Error(await answer.text());
  const lines = /** @type {string[]} */ (await answer.json());
  figures.replaceChildren(...lines.map((line) => Object.assign(document.createElement("li"), { textContent: line })));
  state.textContent = "Done. The terminal has the same figures.";
}

begin.addEventListener("click", () => {
  begin.disabled = true;
  run()
    .catch((trouble) => (state.textContent = trouble instanceof Error ? trouble.message : "It did not work."))
    .finally(() => (begin.disabled = false));
});
begin.disabled = false; // enabled once this script answers it
