// Gamepads of this browser: reads them, drives and stops by them, and keeps their mappings.

import { remember, remembered } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";
import { PRESETS } from "./drive.js";
import { InputLearner } from "./gamepad-learning.js";
import { assign, defaultMapping, isComplete, NEEDED, parseMapping } from "./gamepad-mapping.js";
import { inputName, padName } from "./gamepad-names.js";
import { GamepadReader } from "./gamepad-reader.js";

/** @import { Drive } from "./drive.js" */
/** @import { Mapping, Pad, PadAction } from "./gamepad-mapping.js" */
/** @import { Velocity } from "./keys.js" */
/** @import { Session } from "../net/session.js" */

const READ_MS = 20; // on a timer: a page that draws slowly must still see the deadman go
const STILL = { v: 0, w: 0 };
const UNFOCUSED = t("gamepad-input.the_page_does_not_have_the");
const COVERED = t("gamepad-input.close_the_dialog_to_drive");
const ELSEWHERE = t("gamepad-input.open_the_page_drive_to_drive");

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
  /** @type {(down: boolean) => void} the button to talk goes down or up */
  toTalk = () => undefined;
  #talks = false;

  /** @param {Session} session @param {Drive} drive */
  constructor(session, drive) {
    this.#session = session;
    this.#drive = drive;
    setInterval(() => this.#read(performance.now()), READ_MS);
    addEventListener("gamepaddisconnected", () => this.#read(performance.now()));
    session.on("stopped", () => this.trip(t("gamepad-input.stopped_let_go_then_press_again")));
    session.on("lost", () => this.trip(t("gamepad-input.the_link_was_lost_let_go")));
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
    if (!deadman || !isComplete(this.mappingOf(pad))) return t("gamepad-input.gamepad_its_layout_is_unknown_menu");
    return t("gamepad-input.hold_inputname_and_push_the_stick", { inputname: inputName(pad, deadman) });
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

  /** Keep the mapping of all gamepads of this model, in this browser. @param {Pad} pad @param {Mapping} mapping */
  keep(pad, mapping) {
    this.trip(t("gamepad-input.the_mapping_was_changed_let_go"));
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

  /** Zero now, until every deadman is released and pressed again. @param {string} why a sentence */
  trip(why) {
    this.#reader.trip(why);
    this.#follow(STILL, false, performance.now());
  }

  /** @param {number} now [ms] */
  #read(now) {
    this.#pads = connectedPads() ?? [];
    this.#greet();
    const { velocity, slow, stop, steps, talk } = this.#reader.read(
      this.#pads,
      (pad) => this.mappingOf(pad),
      now,
      this.#obstacle(),
    );
    this.#follow(velocity, slow, now);
    if (steps) this.#drive.preset = Math.min(PRESETS.length, Math.max(1, this.#drive.preset + steps));
    if (stop) this.#stop();
    if (talk !== this.#talks) this.toTalk(talk);
    this.#talks = talk;
    this.#learn(now);
  }

  /** A sentence when no gamepad may drive now, else "". */
  #obstacle() {
    if (document.visibilityState !== "visible" || !document.hasFocus()) return UNFOCUSED;
    if (!this.drives) return ELSEWHERE;
    if (document.querySelector("[role=dialog]:not([hidden])")) return COVERED;
    return this.#session.hello?.robot.drives === false ? t("gamepad-input.a_recording_cannot_be_driven") : "";
  }

  /** @param {Velocity} velocity @param {boolean} slow @param {number} now [ms] */
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
      this.stopLearning(t("gamepad-input.stop_was_pressed_the_mapping_was"));
    this.#session.stop();
  }

  /** Say what came and what went. */
  #greet() {
    const { hello } = this.#session;
    if (!hello) return;
    for (const pad of this.#pads) {
      if (this.#known.get(pad.index) === pad.id) continue;
      this.#known.set(pad.index, pad.id);
      if (hello.robot.drives) this.#session.tell("offer", { ...this.#greeting(pad), event: "show-gamepad" });
    }
    for (const [index, id] of this.#known) {
      if (this.#pads.some((pad) => pad.index === index)) continue;
      this.#known.delete(index);
      this.#session.complain(t("gamepad-input.padname_was_disconnected_it_drives_nothing", { padname: padName(id) }));
    }
  }

  /** @param {Pad} pad */
  #greeting(pad) {
    const { inputs } = this.mappingOf(pad);
    const name = padName(pad.id);
    if (!isComplete(this.mappingOf(pad)) || !inputs.deadman || !inputs.stop)
      return { text: t("gamepad-input.name_this_browser_does_not_know", { name }), words: t("gamepad-input.set_up") };
    const [deadman, stop] = [inputName(pad, inputs.deadman), inputName(pad, inputs.stop)];
    if (this.#session.hello?.you.role === "viewer")
      return {
        text: t("gamepad-input.name_you_are_watching_so_it", { name, stop }),
        words: t("gamepad-input.mapping"),
      };
    return {
      text: t("gamepad-input.name_hold_deadman_and_push_the", { name, deadman, stop }),
      words: t("gamepad-input.mapping"),
    };
  }

  /** @param {number} now [ms] */
  #learn(now) {
    const learning = this.#learning;
    if (!learning) return;
    const { index, learner, next } = learning;
    const pad = this.#pads.find((each) => each.index === index);
    if (!pad) {
      this.stopLearning(t("gamepad-input.the_gamepad_was_disconnected"));
      return;
    }
    const { input, failed } = learner.take(pad, now);
    if (failed) this.stopLearning(t("gamepad-input.that_does_not_come_back_to"));
    if (!input) return;
    const { mapping, why } = assign(this.mappingOf(pad), learner.action, input);
    if (why) {
      this.stopLearning(why);
      return;
    }
    this.keep(pad, mapping);
    if (next.length) this.learn(pad, next);
    else
      this.stopLearning(
        isComplete(mapping)
          ? t("gamepad-input.saved_in_this_browser")
          : t("gamepad-input.saved_not_all_that_is_needed"),
      );
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
