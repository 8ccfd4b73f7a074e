// Element <key-sheet>: dialog that lists the keys of the page.

import { make } from "../ui/element.js";
import { Sheet } from "../ui/sheet.js";
import { t } from "../ui/texts.js";

const KEYS = [
  [["Esc"], t("key-sheet.stop_everywhere_also_while_typing")],
  [[t("key-sheet.space")], t("key-sheet.stop_outside_text_boxes")],
  [["W", "A", "S", "D"], t("key-sheet.hold_to_drive_the_arrow_keys")],
  [["Shift"], t("key-sheet.slow_while_driving")],
  [["1", "…", "5"], t("key-sheet.speed")],
  [["V"], t("key-sheet.hold_to_talk")],
  [["/"], t("key-sheet.to_the_command_line")],
  [["↑", "↓"], t("key-sheet.in_the_command_line_earlier_commands")],
  [[t("key-sheet.enter")], t("key-sheet.send_press_the_button_in_focus")],
  [["?"], t("key-sheet.this_sheet")],
];

const RECORDING_KEYS = [
  [[t("key-sheet.space")], t("key-sheet.play_and_pause")],
  [["←", "→"], t("key-sheet.five_seconds_back_or_on")],
  [["Home", "End"], t("key-sheet.to_the_beginning_to_the_end")],
  [["Esc"], t("key-sheet.pause_also_while_typing")],
  [["?"], t("key-sheet.this_sheet")],
];

/** @param {typeof KEYS} list */
const rows = (list) =>
  list.flatMap(([keys, says]) => [
    make("dt", .../** @type {string[]} */ (keys).map((key) => (key === "…" ? "…" : make("kbd", key)))),
    make("dd", String(says)),
  ]);

export class KeySheet extends Sheet {
  #list = make("dl.keys", ...rows(KEYS));

  /** @override */
  build() {
    this.frame(t("key-sheet.keys"), this.#list, make("p.note", t("key-sheet.stop_is_a_software_stop_it")));
    this.session.on("hello", ({ robot }) => {
      const recording = robot.capabilities.includes("replay") && !robot.dry_run;
      this.#list.replaceChildren(...rows(recording ? RECORDING_KEYS : KEYS));
    });
  }
}

customElements.define("key-sheet", KeySheet);
