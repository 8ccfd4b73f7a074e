// Element <own-navigation-card>: the robot's own map and pose, and goals for its own navigation; hidden without one.

import { call, post, send, sentenceOf } from "../net/api.js";
import { cardHead, make, mark, numberField, onSubmit, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { OwnNavigationState as OwnNavigation, PlanarPose as Pose } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

const PATH = "api/robot/navigation";
const PERIOD_MS = 1000; // between two looks
const WARNING = t("own-navigation-card.while_it_drives_beckon_s_gate");

/** @param {Pose} pose */
const inWords = ({ x_m, y_m, heading_rad }) =>
  `x ${fixed(x_m, 2)} m, y ${fixed(y_m, 2)} m, ${fixed((heading_rad * 180) / Math.PI, 0)}°`;

/** @param {string} name @param {string} unit */
function field(name, unit) {
  const input = numberField(name, { step: "any", value: 0, required: true });
  return { input, label: make("label", `${name} `, input, ` ${unit}`) };
}

class OwnNavigationCard extends Panel {
  #sentence = make("p.note");
  #pose = make("p.note");
  #goal = make("p", { role: "status", hidden: true });
  #trouble = make("p.note", { role: "alert", hidden: true });
  #layer = make("button.toggle", { "aria-pressed": "true" }, t("own-navigation-card.on_the_map"));
  #x = field("x", "m");
  #y = field("y", "m");
  #heading = field("heading", "°");
  #send = make("button.button.small", { type: "submit" }, t("own-navigation-card.let_the_robot_s_own_navigation"));
  #cancel = make("button.button.small", { hidden: true }, t("own-navigation-card.end_its_way"));
  #form = make("form.row.own-goal", this.#x.label, this.#y.label, this.#heading.label, this.#send);
  #operates = false;
  #there = false;
  /** @type {OwnNavigation | null} */
  #newest = null;

  /** @override */
  build() {
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("own-navigation-card.robot_s_own_navigation"));
    this.append(
      cardHead(t("own-navigation-card.robot_s_own_navigation"), this.#layer),
      this.#sentence,
      this.#pose,
      this.#goal,
      this.#form,
      this.#cancel,
      this.#trouble,
    );
    onSubmit(this.#form, () => void this.#ask(() => post(`${PATH}/goal`, this.#wanted())));
    this.#cancel.addEventListener("click", () => void this.#ask(() => call(`${PATH}/goal`, { method: "DELETE" })));
    this.#layer.addEventListener(
      "click",
      () => void this.#ask(() => send(`${PATH}/layer`, "PUT", { shown: !this.#newest?.shown })),
    );
    setInterval(() => this.#there && !document.hidden && void this.#ask(() => call(PATH), false), PERIOD_MS);
  }

  /** @override @param {View} view */
  show({ hello, up, permission }) {
    this.#there = up && (hello?.robot.capabilities.includes("navigate") ?? false);
    this.classList.toggle("is-old", !up);
    this.#operates = up && permission.may !== "no";
    this.hidden = this.#newest === null;
    this.#send.disabled = this.#layer.disabled = !this.#operates;
  }

  #wanted() {
    const heading = (Number(this.#heading.input.value) * Math.PI) / 180;
    return { x_m: Number(this.#x.input.value), y_m: Number(this.#y.input.value), heading_rad: heading };
  }

  /** @param {() => Promise<OwnNavigation>} request @param {boolean} aloud say what goes wrong */
  async #ask(request, aloud = true) {
    try {
      this.#draw(await request());
      if (aloud) this.#say("");
    } catch (trouble) {
      if (aloud) this.#say(sentenceOf(trouble));
    }
  }

  /** @param {string} sentence */
  #say(sentence) {
    write(this.#trouble, sentence);
    this.#trouble.hidden = !sentence;
  }

  /** @param {OwnNavigation} found */
  #draw(found) {
    this.#newest = found;
    const size = found.map
      ? t("own-navigation-card.its_map_fixed_by_fixed2_m", {
          fixed: fixed(found.map.width_m, 1),
          fixed2: fixed(found.map.height_m, 1),
        })
      : "";
    write(this.#sentence, size + inLanguage(found.sentence));
    write(
      this.#pose,
      found.pose ? t("own-navigation-card.it_believes_to_be_at_inwords", { inwords: inWords(found.pose) }) : "",
    );
    write(
      this.#goal,
      found.goal
        ? t("own-navigation-card.it_drives_to_inwords_warning", { inwords: inWords(found.goal), warning: WARNING })
        : "",
    );
    this.#goal.hidden = this.#cancel.hidden = found.goal === null;
    mark(this.#layer, "aria-pressed", String(found.shown));
    this.#layer.hidden = found.map === null;
    this.#form.hidden = !found.takes_goals;
    this.hidden = false;
  }
}

customElements.define("own-navigation-card", OwnNavigationCard);
