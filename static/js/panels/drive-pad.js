// Element <drive-pad>: stick, keys, speed presets and the reason why driving is not possible.

import { PRESETS, SLOW } from "../drive/drive.js";
import { response } from "../drive/response.js";
import { icon, make, mark, write } from "../ui/element.js";
import { speed, turnRate } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { commandSpeed } from "../ui/to-go.js";

/** @import { OperatorInput } from "../drive/operator-input.js" */
/** @import { View } from "../net/session.js" */

const DEAD = 0.12; // of the radius: dead zone of a resting thumb
const KNOB = 26; // [px] of the radius that the knob needs

export class DrivePad extends Panel {
  #knob = make("span.knob");
  #stick = make(
    "div.stick",
    { role: "application", tabindex: "0", "aria-label": t("drive-pad.drive_stick_hold_w_a_s") },
    ...["up", "left", "down", "right"].map((way, index) =>
      make("span.way", { "data-way": way }, icon("arrow"), make("kbd", "WASD".charAt(index))),
    ),
    this.#knob,
  );
  #presets = make(
    "div.presets",
    { role: "group", "aria-label": t("drive-pad.speed") },
    ...PRESETS.map((_, index) => make("button.preset", { "data-preset": String(index + 1) }, String(index + 1))),
  );
  #less = make("button.button", { "aria-label": t("drive-pad.slower") }, "−");
  #more = make("button.button", { "aria-label": t("drive-pad.faster") }, "+");
  #preset = make("span.top-preset");
  #top = make("span.top-hand");
  #most = make("span.top-most"); // the same where it has half the room
  #commanded = make("span.top-command", { hidden: true });
  #moving = make("span.moving");
  #turning = make("span.note.turning");
  #why = make("p.drive-why");
  /** @type {OperatorInput | null} */
  #operatorInput = null;
  /** @type {number | null} */
  #pointer = null;
  #said = "";

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("drive-pad.drive"));
    this.append(
      this.#stick,
      make(
        "div.drive-side",
        make("p.drive-figures", this.#moving, this.#turning),
        this.#presets,
        make("div.stepper", this.#less, this.#more),
        make("span.top-speed", this.#preset, this.#top, this.#most, this.#commanded),
        this.#why,
      ),
    );
  }

  /** @param {OperatorInput} operatorInput */
  hold(operatorInput) {
    this.#operatorInput = operatorInput;
    /** @param {number} preset */
    const set = (preset) => {
      operatorInput.drive.preset = Math.min(PRESETS.length, Math.max(1, preset));
    };
    for (const button of this.#presets.querySelectorAll("button")) {
      button.addEventListener("click", () => set(Number(button.dataset["preset"])));
    }
    this.#less.addEventListener("click", () => set(operatorInput.drive.preset - 1));
    this.#more.addEventListener("click", () => set(operatorInput.drive.preset + 1));
    operatorInput.toRest = () => this.#release();
    const stick = this.#stick;
    stick.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || this.#pointer !== null) return;
      this.#pointer = event.pointerId;
      stick.setPointerCapture(event.pointerId);
      this.#follow(event);
    });
    stick.addEventListener("pointermove", (event) => event.pointerId === this.#pointer && this.#follow(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      stick.addEventListener(
        end,
        (event) => event instanceof PointerEvent && event.pointerId === this.#pointer && this.#release(),
      );
    }
    stick.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** @override @param {View} view */
  show({ hello, state, permission, up }) {
    const operatorInput = this.#operatorInput;
    if (!operatorInput || !hello || !state) return;
    const { drive } = operatorInput;
    if (this.#pointer === null) this.#followGamepad(operatorInput.gamepad.velocity);
    const velocity = operatorInput.keyVelocity;
    const lit = { up: velocity.v > 0, down: velocity.v < 0, left: velocity.w > 0, right: velocity.w < 0 };
    for (const way of this.#stick.querySelectorAll(".way")) {
      mark(way, "data-lit", lit[/** @type {keyof typeof lit} */ (way.getAttribute("data-way"))] && !drive.mustLetGo);
    }
    mark(this.#stick, "data-engaged", drive.engaged);
    mark(this.#stick, "data-off", !up || permission.may === "no");
    for (const button of this.#presets.querySelectorAll("button")) {
      mark(button, "aria-pressed", String(Number(button.dataset["preset"]) === drive.preset));
      button.disabled = hello.you.role === "viewer";
    }
    const top = (PRESETS[drive.preset - 1] ?? 0) * hello.robot.max_speed_m_s;
    write(this.#preset, drive.slow ? t("drive-pad.slow") : t("drive-pad.speed_preset", { preset: drive.preset }));
    const most = speed(drive.slow ? SLOW * top : top).replace(" ", "\u00a0");
    write(this.#top, t("drive-pad.up_to", { speed: most }));
    write(this.#most, t("drive-pad.at_most", { speed: most }));
    const command = commandSpeed(state, hello.robot.cruise_m_s);
    this.#commanded.hidden = command === null;
    if (command !== null)
      write(this.#commanded, t("drive-pad.by_command", { speed: speed(command).replace(" ", "\u00a0") }));
    this.#less.disabled = drive.preset === 1;
    this.#more.disabled = drive.preset === PRESETS.length;
    write(this.#moving, up ? speed(state.velocity.v_m_s) : "–");
    write(this.#turning, up ? turnRate(state.velocity.w_rad_s) : "");
    const forbidden = permission.may === "no" && up ? permission.why : "";
    this.#explain(drive.why || forbidden || operatorInput.why, operatorInput.gamepad.advice);
  }

  /** @param {string} why @param {string} advice how to drive by gamepad, when there is one */
  #explain(why, advice) {
    write(this.#why, why || advice || t("drive-pad.hold_to_drive_shift_is_slow"));
    mark(this.#why, "data-tone", why ? "stale" : null);
    if (why && why !== this.#said) this.session.announce(why);
    this.#said = why;
  }

  /** @param {PointerEvent} event */
  #follow(event) {
    const box = this.#stick.getBoundingClientRect();
    const reach = box.width / 2 - KNOB;
    const x = (event.clientX - box.left - box.width / 2) / reach;
    const y = (event.clientY - box.top - box.height / 2) / reach;
    const far = Math.hypot(x, y);
    const [u, v] = far > 1 ? [x / far, y / far] : [x, y];
    this.#place(u * reach, v * reach);
    this.#operatorInput?.stick({ v: response(-v, DEAD), w: response(-u, DEAD) });
  }

  /** @param {import("../drive/keys.js").Velocity} velocity */
  #followGamepad({ v, w }) {
    const reach = v || w ? this.#stick.clientWidth / 2 - KNOB : 0;
    this.#place(-w * reach, -v * reach);
  }

  #release() {
    this.#pointer = null;
    this.#place(0, 0);
    this.#operatorInput?.stick({ v: 0, w: 0 });
  }

  /** @param {number} x [px] @param {number} y [px] */
  #place(x, y) {
    this.#knob.style.translate = `${x}px ${y}px`;
  }
}

customElements.define("drive-pad", DrivePad);
