// Operator input: keys of the page and of the scene frame, stick, gamepad, and every event that must release them.

import { remembered } from "../ui/local-storage.js";
import { mayBegin } from "../ui/pending-command.js";
import { t } from "../ui/texts.js";
import { Drive, PERIOD_MS } from "./drive.js";
import { GamepadInput } from "./gamepad-input.js";
import { HeldKeys, intentionOf, scrolls, TALK, takesEnter, takesText } from "./keys.js";

/** @import { Velocity } from "./keys.js" */
/** @import { Session, View } from "../net/session.js" */

const ANYWHERE = new Set(["stop", "help", "begin"]); // act on every page

export class OperatorInput {
  #held = new HeldKeys();
  #session;
  #ahead = 0; // [ms] by which the console's monotonic clock is ahead of the page's
  singleKeys = remembered("single-keys", "on") === "on";
  /** False while a page without driving controls is open: only stop keys act there. */
  #drives = true;
  /** @type {() => void} */
  toWords = () => undefined;
  /** @type {() => void} */
  toHelp = () => undefined;
  /** @type {(down: boolean) => void} */
  toTalk = () => undefined;
  /** @type {(id: number) => void} */
  toBegin = () => undefined;
  /** @type {() => void} the stick lets its pointer go */
  toRest = () => undefined;

  /** @param {Session} session */
  constructor(session) {
    this.#session = session;
    this.drive = new Drive({
      send: (frame) => session.drive(frame),
      ask: () => void session.lease("acquire"),
      draw: drawPress,
      count: () => Math.round(this.#ahead + performance.now()),
      busy: () => dispatchEvent(new CustomEvent("page-busy")),
    });
    this.gamepad = new GamepadInput(session, this.drive);
    this.gamepad.toTalk = (down) => this.toTalk(down);
    setInterval(() => this.drive.tick(performance.now()), PERIOD_MS);
    session.on("stopped", () => this.drive.trip(t("operator-input.stopped_let_go_then_press_again")));
    session.on("lost", () => this.drive.trip(t("operator-input.the_link_was_lost_let_go")));
    session.on("hello", ({ robot, clock_ms }) => {
      this.#ahead = clock_ms - performance.now();
      this.drive.limits = { speed: robot.max_speed_m_s, turnRate: robot.max_turn_rate_rad_s };
    });
    document.addEventListener("visibilitychange", () => document.visibilityState === "hidden" && this.letGo());
    this.listenTo(window);
  }

  /** @returns {Velocity} requested by keys, to highlight them on the page */
  get keyVelocity() {
    return this.#held.velocity;
  }

  /** The reason when an input is held and nothing moves, else "". */
  get why() {
    return this.drive.why || this.gamepad.why;
  }

  /**
   * Capture the keys of a window before its own elements: this page, or the scene frame after each load.
   * @param {Window} place
   */
  listenTo(place) {
    place.addEventListener("keydown", (event) => this.#down(event), true);
    place.addEventListener("keyup", (event) => this.#up(event), true);
    place.addEventListener("pagehide", () => hasKeys(place) && this.letGo(), true);
    place.addEventListener("blur", ({ target }) => this.letGo(target === window), true);
    place.addEventListener("contextmenu", ({ target }) => opensMenu(target) && this.letGo(), true);
  }

  /** @param {Velocity} velocity */
  stick(velocity) {
    this.drive.stick(velocity, performance.now());
  }

  /** @param {boolean} [whole] false where another element has the focus now, as a press of the stick brings it there */
  letGo(whole = true) {
    this.#held.clear();
    this.toTalk(false);
    if (whole) {
      this.toRest();
      this.drive.slow = false;
    }
    this.gamepad.trip(t("operator-input.driving_was_interrupted_let_go_then"));
    this.drive.abandon();
  }

  /** @param {boolean} drives false while a page without driving controls is open */
  enable(drives) {
    if (this.#drives === drives) return;
    this.#drives = this.gamepad.drives = drives;
    this.letGo();
  }

  /** @param {View} view */
  show({ state, permission }) {
    const gate = state?.gate;
    if (!gate) return;
    this.drive.hear(
      { nonce: gate.nonce, epoch: gate.epoch, needNeutral: gate.need_neutral },
      permission,
      performance.now(),
    );
  }

  /** @param {KeyboardEvent} event */
  #down(event) {
    const [target] = event.composedPath();
    const typing = takesText(target);
    if (event.metaKey || event.ctrlKey || event.altKey) this.letGo(); // their combinations swallow the keyup
    const reading = document.querySelector("[role=dialog]:not([hidden])") !== null;
    const pending = mayBegin(this.#session.view);
    const waiting = pending !== null && !takesEnter(target);
    const recording = this.#session.hello?.robot.capabilities.includes("replay") === true;
    const where = { recording, typing, singleKeys: this.singleKeys, scrolling: scrolls(target), reading, waiting };
    const intention = intentionOf(event, where);
    if (!intention || !(this.#drives || ANYWHERE.has(intention.does))) return;
    const driving = intention.does === "drive" || intention.does === "slow" || intention.does === "preset";
    if (driving && this.#session.hello?.robot.drives === false) return; // a recording: the arrows belong to its slider
    if (intention.does === "slow") {
      this.drive.slow = true;
      return;
    }
    if (intention.does !== "stop" || event.key !== "Escape") event.preventDefault();
    if (intention.does === "drive" || event.key !== "Escape") event.stopImmediatePropagation();
    if (intention.does === "seek") this.#session.seekBy(intention.seconds); // a key that is held goes on
    if (event.repeat || intention.does === "seek") return;
    if (intention.does === "stop") this.#stop(event.key);
    else if (intention.does === "preset") this.drive.preset = intention.preset;
    else if (intention.does === "words") this.toWords();
    else if (intention.does === "help") this.toHelp();
    else if (intention.does === "talk") this.toTalk(true);
    else if (intention.does === "begin") pending && this.toBegin(pending.id);
    else {
      this.#held.press(event.code);
      this.drive.keys(this.#held.velocity, performance.now());
    }
  }

  /** Stop the robot. On a paused recording, Space plays it. @param {string} key */
  #stop(key) {
    const { hello, state, plays } = this.#session;
    const waits = hello?.robot.drives === false && state !== null && !plays && hello.you.role !== "viewer";
    if (waits && key === " ") void this.#session.playback({ action: "play" });
    else this.#session.stop();
  }

  /** @param {KeyboardEvent} event */
  #up(event) {
    if (event.key === "Shift") this.drive.slow = false;
    if (event.code === TALK) this.toTalk(false);
    if (event.code === "Space" && this.singleKeys && !takesText(event.composedPath()[0])) event.preventDefault();
    this.#held.release(event.code);
    this.drive.keys(this.#held.velocity, performance.now());
  }
}

/** False for a scene frame that goes while the page has the focus: its keys are seen as before. @param {Window} place */
const hasKeys = (place) => place === window || place.document.hasFocus();

/** False on the stick, which opens no menu: a thumb held still asks for one. @param {EventTarget | null} target */
const opensMenu = (target) => !(target instanceof Element && target.closest(".stick"));

function drawPress() {
  const [drawn = 1] = crypto.getRandomValues(new Uint32Array(1));
  return drawn || 1;
}
