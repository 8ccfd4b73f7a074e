// Element <scene-view>: the 3-D map in a frame; the server interprets clicks in it.

import { address, isPressed, socketAddress } from "../net/api.js";
import { icon, make } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { fallBack, isChosen, mapKind, mapShown, onMapKind, prove } from "../ui/map-choice.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { isDark, onTheme } from "../ui/theme.js";

/** @import { View } from "../net/session.js" */

const DRAWN_MS = 15_000; // after which the frame is shown in any case where it was chosen
const SLOW_HZ = 8; // pictures a second below which the flat map serves better
const PROOF_PICTURES = 3; // in a row that have to come as fast before the 3-D map is shown
const PROOF_MS = 2000; // in which they have to
const TRIAL_MS = 5000; // over which they are counted, after as long to come to rest, and when the robot first moves
const TOUCH = matchMedia("(pointer: coarse)").matches;
const LAYERS = [
  ["pose", t("scene-view.robot"), t("scene-view.estimated_pose_the_ellipse_is_two")],
  ["ghost", t("scene-view.wheels_alone"), t("scene-view.pose_by_dead_reckoning_alone")],
  ["convex", t("scene-view.outer_corner"), t("scene-view.a_landmark_the_ellipse_is_two")],
  ["concave", t("scene-view.inner_corner"), t("scene-view.a_landmark_the_ellipse_is_two")],
  ["used", t("scene-view.used_corner"), t("scene-view.a_ray_to_every_corner_of")],
  ["refused", t("scene-view.rejected_corner"), t("scene-view.a_corner_of_the_newest_sweep")],
  ["closure", t("scene-view.closure"), t("scene-view.a_place_that_was_recognised_an")],
  ["room", t("scene-view.room"), t("scene-view.the_map_is_made_of_rooms")],
  ["scan", t("scene-view.laser"), t("scene-view.the_newest_sweep")],
  ["voice", t("scene-view.voice"), t("scene-view.direction_of_a_voice_two_standard")],
  ["plan", t("scene-view.way_and_goal"), t("scene-view.where_the_robot_is_going")],
  ["preview", t("scene-view.pending_command"), t("scene-view.preview_of_a_spoken_command_before")],
  ["wall", t("scene-view.wall"), t("scene-view.seen_occupied")],
  ["own", t("scene-view.robot_s_own_map"), t("scene-view.what_the_robot_s_own_navigation")],
  ["free", t("scene-view.free_floor"), t("scene-view.seen_free_what_is_not_drawn")],
];

export class SceneView extends Panel {
  #frame = make("iframe.scene", { title: t("scene-view.3_d_map"), id: "scene" });
  #hint = make(
    "p.scene-hint",
    { "aria-hidden": "true" },
    icon("click"),
    t("scene-view.value_the_floor_to_go_there", { value: TOUCH ? t("scene-view.tap") : t("scene-view.click") }),
  );
  #legend = make(
    "details.legend",
    make("summary", make("span", t("scene-view.legend")), icon("chevron")),
    make(
      "ul",
      ...LAYERS.map(([layer, name, says]) =>
        make("li", { title: says, "data-row": layer }, make("span.swatch", { "data-layer": layer }), name),
      ),
    ),
  );
  #tab = "";
  #goes = false;
  #loadedAt = Infinity; // [ms]
  #byKeys = false;
  #proving = false;
  #moved = false; // since it was loaded: it draws more then, and is tried once more
  /** @type {(inner: Window) => void} */
  #then = () => undefined;

  /** @override */
  build() {
    this.#legend.open = remembered("legend", "shut") === "open";
    this.#legend.addEventListener("toggle", () => remember("legend", this.#legend.open ? "open" : "shut"));
    this.hidden = mapKind() !== "3-D";
    this.classList.toggle("is-behind", mapShown() !== "3-D");
    this.append(this.#frame, this.#legend, this.#hint);
    this.#frame.addEventListener("load", () => this.#loaded());
    this.addEventListener("pointerenter", () => this.#hint.classList.toggle("is-shown", this.#goes));
    this.addEventListener("pointerleave", () => this.#hint.classList.remove("is-shown"));
    addEventListener("keydown", (event) => (this.#byKeys = event.key === "Tab"), true);
    addEventListener("pointerdown", () => (this.#byKeys = false), true);
    onTheme(() => this.#load());
    onMapKind(() => this.#load());
    addEventListener(
      "page-busy",
      () => this.hidden || isChosen() || fallBack(t("map-choice.the_3_d_map_kept_the_page")),
    );
    this.session.on("hello", ({ tab }) => {
      this.#tab = tab;
      this.#load();
    });
  }

  /** @param {(inner: Window) => void} then called with the window of the frame after each load, so that the page receives its keys */
  whenLoaded(then) {
    this.#then = then;
  }

  /** @override @param {View} view */
  show({ state, hello, up, permission }) {
    if (this.hidden) return;
    this.#reveal("own", hello?.robot.capabilities.includes("navigate") ?? false);
    this.#reveal3d();
    this.#tryMoving(state);
    this.#goes = up && hello?.robot.drives === true && permission.may !== "no" && !state?.floor.lost;
    this.classList.toggle("is-old", !up);
    const { floor } = state ?? {};
    this.#reveal("closure", (floor?.closures_count ?? 0) > 0);
    this.#reveal("preview", (state?.pending_command ?? null) !== null);
    this.#reveal("room", (floor?.submaps.length ?? 0) > 1);
    if (isPressed(state?.command?.source)) this.#hint.classList.add("is-known");
  }

  /** Show a legend row only while its layer has content. @param {string} layer @param {boolean} there */
  #reveal(layer, there) {
    const row = /** @type {HTMLElement | null} */ (this.#legend.querySelector(`[data-row="${layer}"]`));
    if (row && row.hidden === there) row.hidden = !there;
  }

  /**
   * Count the pictures of a while, and give up the 3-D map when they are few and nobody chose it.
   * @param {Window} inner of the frame that was loaded
   * @param {number} since [ms]
   * @param {number} pictures
   */
  #count(inner, since, pictures) {
    const unseen = document.hidden || this.hidden || this.clientWidth === 0;
    if (unseen || isChosen() || !this.classList.contains("is-drawn")) return;
    const passed = performance.now() - since;
    if (passed < TRIAL_MS) inner.requestAnimationFrame(() => this.#count(inner, since, pictures + 1));
    else if ((1000 * pictures) / passed < SLOW_HZ) fallBack(tooSlow((1000 * pictures) / passed));
  }

  /** @param {import("../net/messages.js").State | null} state */
  #tryMoving(state) {
    const inner = this.#frame.contentWindow;
    const { v_m_s: v, w_rad_s: w } = state?.velocity ?? { v_m_s: 0, w_rad_s: 0 };
    if (!inner || this.#moved || (v === 0 && w === 0) || performance.now() - this.#loadedAt < TRIAL_MS) return;
    this.#moved = true;
    this.#count(inner, performance.now(), 0);
  }

  /** Show the frame once it draws, and fast enough where nobody chose it: until then the flat map stands there. */
  #reveal3d() {
    if (this.classList.contains("is-drawn")) return;
    const inner = this.#frame.contentWindow;
    const drawn = this.#frame.contentDocument?.querySelector("canvas") ?? null;
    const late = performance.now() - this.#loadedAt > DRAWN_MS;
    if (isChosen() && (drawn || late)) this.#unveil();
    else if (drawn && inner && !this.#proving) {
      this.#proving = true;
      const now = performance.now();
      inner.requestAnimationFrame(() => this.#prove(inner, now, [now]));
    }
  }

  #unveil() {
    this.classList.add("is-drawn");
    prove();
  }

  /**
   * Wait for some pictures in a row that come fast enough, and give up the 3-D map when they do not come in time.
   * @param {Window} inner of the frame that was loaded
   * @param {number} since [ms]
   * @param {readonly number[]} pictures when they came [ms]
   */
  #prove(inner, since, pictures) {
    const now = performance.now();
    const came = [...pictures, now].slice(-PROOF_PICTURES - 1);
    const fast = came.length > PROOF_PICTURES && now - (came[0] ?? 0) < (1000 * PROOF_PICTURES) / SLOW_HZ;
    const unseen = document.hidden || this.hidden || this.clientWidth === 0;
    if (unseen)
      this.#proving = false; // nothing is drawn that nobody sees: again later
    else if (fast || isChosen()) this.#unveil();
    else if (now - since > PROOF_MS) fallBack(tooSlow(1000 / (now - (came.at(-2) ?? since))));
    else inner.requestAnimationFrame(() => this.#prove(inner, since, came));
  }

  #load() {
    this.hidden = mapKind() !== "3-D";
    this.classList.toggle("is-behind", mapShown() !== "3-D");
    if (this.hidden && this.#frame.src) this.#frame.src = "about:blank"; // it draws nothing that nobody sees
    if (!this.#tab || this.hidden) return;
    const query = new URLSearchParams({ websocket: socketAddress(`scene/ws/${this.#tab}`) });
    if (isDark()) query.set("darkMode", "");
    const url = `${address("scene/").href}?${query}`;
    if (this.#frame.src === url) return;
    this.classList.remove("is-drawn");
    this.#proving = false;
    this.#frame.src = url;
  }

  #loaded() {
    const inner = this.#frame.contentWindow;
    if (!this.#frame.src || !inner || this.hidden) return;
    this.#loadedAt = performance.now();
    this.#moved = false;
    setTimeout(() => this.#count(inner, performance.now(), 0), TRIAL_MS);
    inner.addEventListener("focus", () => this.classList.toggle("is-focused", this.#byKeys));
    inner.addEventListener("blur", () => this.classList.remove("is-focused"));
    this.#then(inner);
  }
}

/** @param {number} rate pictures a second */
function tooSlow(rate) {
  const few = rate < 1.5 ? t("map-choice.1_picture") : t("map-choice.rate_pictures", { rate: Math.round(rate) });
  return t("map-choice.the_3_d_map_is_too", { few });
}

customElements.define("scene-view", SceneView);
