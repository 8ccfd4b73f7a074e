// Element <command-chain>: what of a person the robot has by each sense while it comes or follows.

import { make, mark, write } from "../ui/element.js";
import { degrees, inWords, metres } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { SPOKEN } from "../ui/pending-command.js";
import { chainOf, LastVoice } from "../ui/sensed.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

const STEPS = /** @type {const} */ (["heard", "seen", "laser", "coming"]);

class CommandChain extends Panel {
  #voice = new LastVoice();
  #list = make("ol.chain", { "aria-label": t("command-chain.what_the_robot_has_of_the") });
  #steps = STEPS.map((step) => {
    const says = make("span.chain-says");
    const row = make("li.chain-step", { "data-step": step }, make("b", t(`command-chain.${step}`)), says);
    this.#list.append(row);
    return { row, says };
  });

  /** @override */
  build() {
    this.hidden = true;
    this.append(this.#list);
  }

  /** @override @param {View} view */
  show({ state }) {
    const voice = state ? this.#voice.saw(state) : null; // remembered before a command begins
    const chain = state ? chainOf(state, voice, this.session.kinds) : null;
    this.hidden = chain === null;
    if (!chain) return;
    const command = state?.command;
    const said = command && SPOKEN.includes(command.source) ? `“${command.heard_as}”` : "";
    const from = chain.heard ? `${inWords(chain.heard.azimuth)} ± ${degrees(chain.heard.sd)}` : "";
    const says = [
      [said, from].filter(Boolean).join(" · ") || t("command-chain.no_voice"),
      chain.seen === null
        ? t("command-chain.not_in_the_picture")
        : `${chain.seen.name} ${chain.seen.value === null ? t("command-chain.yes") : chain.seen.value.toFixed(2)}`.trim(),
      chain.laser === null ? t("command-chain.no_legs") : metres(chain.laser, 1),
      chain.left === null
        ? t("command-chain.looking")
        : t("command-chain.metres_to_go", { metres: metres(chain.left, 1) }),
    ];
    const lit = [chain.heard !== null, chain.seen !== null, chain.laser !== null, chain.left !== null];
    for (const [index, { row, says: words }] of this.#steps.entries()) {
      write(words, says[index] ?? "");
      mark(row, "data-lit", lit[index] === true);
    }
  }
}

customElements.define("command-chain", CommandChain);
