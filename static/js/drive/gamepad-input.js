// Gamepads of this browser: reads them, drives and stops by them, and keeps their mappings.

import { remember, remembered } from "../ui/local-storage.js";
import { PRESETS } from "./drive.js";
import { InputLearner } from "./gamepad-learning.js";
import { assign, defaultMapping, isComplete, NEEDED, parseMapping } from "./gamepad-mapping.js";
import { inputName, padName } from "./gamepad-names.js";
import { GamepadReader } from "./gamepad-reader.js";

/** @typedef {import("../net/session.js").Session} Session */
/** @typedef {import("./drive.js").Drive} Drive */
/** @typedef {import("./keys.js").Velocity} Velocity */
/** @typedef {import("./gamepad-mapping.js").Pad} Pad */
/** @typedef {import("./gamepad-mapping.js").Mapping} Mapping */
/** @typedef {import("./gamepad-mapping.js").PadAction} PadAction */

const READ_MS = 20; // on a timer: a page that draws slowly must still see the deadman go
const STILL = { v: 0, w: 0 };
const UNFOCUSED = "The page does not have the focus. Click it, then press the button again.";
const COVERED = "Close the dialog to drive.";
const ELSEWHERE = "Open the page Drive to drive.";

export class GamepadInput {
  #session;
  #drive;
  #reader = new GamepadReader();
  /** @type {Map<string, Mapping>} */
  #mappings = new Map();
  /** @type {Map<number, string>} ids of the gamepads that were there at the last reading */
  #known = new Map();
  /** @type {readonly Pad[]} */
  #pads = [];
  #slow = false;
  /** @type {Velocity} */
  #velocity = STILL;
  /** @type {{index: number, learner: InputLearner, next: PadAction[]} | null} */
  #learning = null;
  #outcome = "";
  /** False while a page without driving controls is open. */
  drives = true;

  /**
   * @param {Session} session
   * @param {Drive} drive
   */
  constructor(session, drive) {
    this.#session = session;
    this.#drive = drive;
    setInterval(() => this.#read(performance.now()), READ_MS);
    addEventListener("gamepaddisconnected", () => this.#read(performance.now()));
    session.on("stopped", () => this.trip("Stopped. Let go, then press again."));
    session.on("lost", () => this.trip("The link was lost. Let go, then press again."));
  }

  /** False where the browser keeps gamepads from this page. */
  get available() {
    return connectedPads() !== null;
  }

  /** Gamepads that are connected. A browser hides one until a button of it is pressed. */
  get pads() {
    return this.#pads;
  }

  /** Index of the gamepad that drives, or null. */
  get active() {
    return this.#reader.active;
  }

  /** @returns {Velocity} requested by the gamepad, to show it on the page */
  get velocity() {
    return this.#velocity;
  }

  /** The reason when a deadman is held and nothing moves, else "". */
  get why() {
    return this.#reader.why;
  }

  /** How to drive by gamepad, in one sentence; "" without one. */
  get advice() {
    const [pad] = this.#pads;
    if (!pad) return "";
    const { deadman } = this.mappingOf(pad).inputs;
    if (!deadman || !isComplete(this.mappingOf(pad))) return "Gamepad: its layout is unknown. Menu, Gamepad.";
    return `Hold ${inputName(pad, deadman)} and push the stick.`;
  }

  /** The action that waits for its input, with what to do; `outcome` says how the last one ended. */
  get learning() {
    const learner = this.#learning?.learner;
    return { action: learner?.action ?? null, prompt: learner?.prompt ?? "", outcome: this.#outcome };
  }

  /** @param {Pad} pad @returns {Mapping} */
  mappingOf(pad) {
    const known = this.#mappings.get(pad.id);
    if (known) return known;
    const mapping = parseMapping(remembered(storedAs(pad), "")) ?? defaultMapping(pad);
    this.#mappings.set(pad.id, mapping);
    return mapping;
  }

  /**
   * Keep the mapping of all gamepads of this model, in this browser.
   * @param {Pad} pad
   * @param {Mapping} mapping
   */
  keep(pad, mapping) {
    this.trip("The mapping was changed. Let go, then press again.");
    this.#mappings.set(pad.id, mapping);
    remember(storedAs(pad), JSON.stringify(mapping));
  }

  /**
   * Learn the inputs of actions by pressing, one after the other. Nothing drives meanwhile.
   * @param {Pad} pad
   * @param {readonly PadAction[]} actions
   */
  learn({ index }, actions) {
    const [first, ...next] = actions;
    this.#outcome = "";
    this.#learning = first ? { index, learner: new InputLearner(first), next } : null;
  }

  /** @param {Pad} pad */
  setUp(pad) {
    this.learn(pad, NEEDED);
  }

  /** @param {string} [outcome] a sentence */
  stopLearning(outcome = "") {
    this.#learning = null;
    this.#outcome = outcome;
  }

  /**
   * Zero now, until every deadman is released and pressed again.
   * @param {string} why a sentence
   */
  trip(why) {
    this.#reader.trip(why);
    this.#follow(STILL, false, performance.now());
  }

  /** @param {number} now [ms] */
  #read(now) {
    this.#pads = connectedPads() ?? [];
    this.#greet();
    const { velocity, slow, stop, steps } = this.#reader.read(
      this.#pads,
      (pad) => this.mappingOf(pad),
      now,
      this.#obstacle(),
    );
    this.#follow(velocity, slow, now);
    if (steps) this.#drive.preset = Math.min(PRESETS.length, Math.max(1, this.#drive.preset + steps));
    if (stop) this.#stop();
    this.#learn(now);
  }

  /** A sentence when no gamepad may drive now, else "". */
  #obstacle() {
    if (document.visibilityState !== "visible" || !document.hasFocus()) return UNFOCUSED;
    if (!this.drives) return ELSEWHERE;
    if (document.querySelector("[role=dialog]:not([hidden])")) return COVERED;
    return this.#session.hello?.robot.drives === false ? "A recording cannot be driven." : "";
  }

  /**
   * @param {Velocity} velocity
   * @param {boolean} slow
   * @param {number} now [ms]
   */
  #follow(velocity, slow, now) {
    if (slow !== this.#slow) this.#drive.slow = slow;
    const changed = velocity.v !== this.#velocity.v || velocity.w !== this.#velocity.w;
    this.#slow = slow;
    this.#velocity = velocity;
    if (changed) this.#drive.gamepad(velocity, now);
    if (this.#drive.mustLetGo && (velocity.v !== 0 || velocity.w !== 0)) this.trip(this.#drive.why); // its sentence stays while the deadman is held
  }

  #stop() {
    if (this.#learning && this.#learning.learner.action !== "stop")
      this.stopLearning("STOP was pressed. The mapping was not changed.");
    this.#session.stop();
  }

  /** Say what came and what went. */
  #greet() {
    const { hello } = this.#session;
    if (!hello) return;
    for (const pad of this.#pads) {
      if (this.#known.get(pad.index) === pad.id) continue;
      this.#known.set(pad.index, pad.id);
      if (hello.robot.drives) this.#session.offer({ ...this.#greeting(pad), event: "show-gamepad" });
    }
    for (const [index, id] of this.#known) {
      if (this.#pads.some((pad) => pad.index === index)) continue;
      this.#known.delete(index);
      this.#session.complain(`${padName(id)} was disconnected. It drives nothing any more.`);
    }
  }

  /** @param {Pad} pad */
  #greeting(pad) {
    const { inputs } = this.mappingOf(pad);
    const name = padName(pad.id);
    if (!isComplete(this.mappingOf(pad)) || !inputs.deadman || !inputs.stop)
      return { text: `${name}: this browser does not know its layout. Set it up by pressing.`, words: "Set up" };
    const [deadman, stop] = [inputName(pad, inputs.deadman), inputName(pad, inputs.stop)];
    if (this.#session.hello?.you.role === "viewer")
      return { text: `${name}: you are watching, so it cannot drive. ${stop} is STOP.`, words: "Mapping" };
    return { text: `${name}: hold ${deadman} and push the stick to drive. ${stop} is STOP.`, words: "Mapping" };
  }

  /** @param {number} now [ms] */
  #learn(now) {
    const learning = this.#learning;
    if (!learning) return;
    const { index, learner, next } = learning;
    const pad = this.#pads.find((each) => each.index === index);
    if (!pad) {
      this.stopLearning("The gamepad was disconnected.");
      return;
    }
    const { input, failed } = learner.take(pad, now);
    if (failed) this.stopLearning("That does not come back to where it was. Let go of everything and try again.");
    if (!input) return;
    const { mapping, why } = assign(this.mappingOf(pad), learner.action, input);
    if (why) {
      this.stopLearning(why);
      return;
    }
    this.keep(pad, mapping);
    if (next.length) this.learn(pad, next);
    else this.stopLearning(isComplete(mapping) ? "Saved in this browser." : "Saved. Not all that is needed is set.");
  }
}

/** @param {Pick<Pad, "id">} pad */
const storedAs = ({ id }) => `gamepad ${id}`;

/** @returns {Pad[] | null} null where the browser keeps gamepads from this page */
function connectedPads() {
  try {
    if (!("getGamepads" in navigator)) return null;
    return navigator.getGamepads().flatMap((pad) => (pad?.connected ? [pad] : []));
  } catch {
    return null; // a permissions policy
  }
}
