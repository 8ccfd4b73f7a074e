// Element <link-chip>: quality of the link: round trip, rate, age; details on a press.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

const WORDS = {
  connecting: t("link-chip.starting_up"),
  live: t("link-chip.live"),
  stale: t("link-chip.silent"),
  lost: t("link-chip.lost"),
};

const SENSORS = {
  wheels: t("link-chip.odometry"),
  laser: t("link-chip.laser"),
  camera: t("link-chip.camera"),
  microphones: t("link-chip.microphones"),
};
/** @type {Readonly<Record<string, string>>} */
const GATE = { disarmed: t("link-chip.disarmed"), armed: t("link-chip.armed"), halted: t("link-chip.halted") };
const STATES = { live: t("link-chip.delivers"), stale: t("link-chip.late"), lost: t("link-chip.lost") };

/** @param {import("../net/messages.js").SensorLine} sensor @returns {[string, string]} */
function sensorRow({ kind, name, state, age_s, rate_hz }) {
  const own = name && name !== kind && kind !== "microphones" ? ` ${name}` : "";
  return [
    `${SENSORS[kind]}${own}`,
    t("link-chip.states_age_old_fixed_hz", { states: STATES[state], age: age(age_s), fixed: fixed(rate_hz, 0) }),
  ];
}

class LinkChip extends Panel {
  #icon = icon("link");
  #text = make("span.link-text");
  #viewers = make("span.viewers");
  #button = make(
    "button.bar-chip",
    { "aria-label": t("link-chip.link") },
    this.#icon,
    this.#text,
    make("span.bar-word", t("link-chip.word")),
  );
  #rows = make("dl.pairs");
  #stopped = ""; // how quickly this page's newest STOP was answered
  #panel = make(
    "div",
    { role: "group", "aria-label": t("link-chip.link_in_detail") },
    make("h2.card-title", t("link-chip.link")),
    this.#rows,
  );

  /** @override */
  build() {
    this.append(this.#viewers, this.#button, this.#panel);
    this.session.on("stop-answered", (ms) => (this.#stopped = t("link-chip.answered_after_ms", { ms })));
    popover(this.#button, this.#panel, { opened: () => this.#detail(this.session.view) }); // as wide as it stays
  }

  /** @override @param {View} view */
  show(view) {
    const { link, state } = view;
    const old = link.is === "up" && link.age_s > 0.5;
    const trip = link.round_trip_ms === null ? "" : `${fixed(link.round_trip_ms, 0)} ms · `;
    const text =
      link.is !== "up"
        ? t("link-chip.no_link")
        : old
          ? t("link-chip.age_old", { age: age(link.age_s) })
          : `${trip}${fixed(link.rate_hz, 0)} Hz`;
    write(this.#text, text);
    redraw(this.#icon, link.is === "up" ? "link" : "unlinked");
    mark(this.#button, "data-tone", link.is !== "up" || old ? "stale" : null);
    mark(this.#button, "aria-label", t("link-chip.link_text", { text }));
    const others = (state?.viewers ?? 1) - 1;
    this.#viewers.hidden = !view.up || others < 1;
    write(this.#viewers, t("link-chip.others_watching", { others }));
    if (!this.#panel.hidden) this.#detail(view);
  }

  /** @param {View} view */
  #detail({ link, state, hello }) {
    /** @type {Array<[string, string]>} */
    const rows = [
      [
        t("link-chip.page_to_console_and_back"),
        link.round_trip_ms === null ? "–" : `${fixed(link.round_trip_ms, 0)} ms`,
      ],
      [t("link-chip.state"), t("link-chip.fixed_hz_age_old", { fixed: fixed(link.rate_hz, 1), age: age(link.age_s) })],
      [
        t("link-chip.robot"),
        state
          ? t("link-chip.words_fixed_frames_s", {
              words: WORDS[state.robot.link],
              fixed: fixed(state.robot.rate_hz, 0),
            })
          : "–",
      ],
      .../** @type {Array<[string, string]>} */ ((state?.robot.sensors ?? []).map(sensorRow)),
      ...(state?.robot.battery == null
        ? []
        : [/** @type {[string, string]} */ ([t("link-chip.battery"), `${fixed(100 * state.robot.battery, 0)} %`])]),
      [t("link-chip.without_a_word"), inLanguage(hello?.robot.failsafe ?? "") || "–"],
      ...(hello?.robot.lock
        ? [
            /** @type {[string, string]} */ ([
              "STOP",
              t("link-chip.also_closes_the_robot_s_lock", { lock: hello.robot.lock }),
            ]),
          ]
        : []),
      ...(this.#stopped ? [/** @type {[string, string]} */ ([t("link-chip.your_last_stop"), this.#stopped])] : []),
      [
        t("link-chip.gate"),
        state ? `${GATE[state.gate.state] ?? ""}${state.gate.reason ? ` (${state.gate.reason})` : ""}` : "–",
      ],
      [t("link-chip.pages_open"), String(state?.viewers ?? "–")],
      ["Beckon", hello?.version ?? "–"],
    ];
    while (this.#rows.children.length > rows.length * 2) this.#rows.lastElementChild?.remove();
    while (this.#rows.children.length < rows.length * 2) this.#rows.append(make("dt"), make("dd"));
    for (const [index, text] of rows.flat().entries()) write(/** @type {Element} */ (this.#rows.children[index]), text);
  }
}

customElements.define("link-chip", LinkChip);
