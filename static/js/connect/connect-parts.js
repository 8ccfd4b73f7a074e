// Element <connect-parts>: the robot's parts; for a part with topics, which of them is what, to be chosen.

import { icon, isNew, make, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { PagePanel } from "../ui/panel.js";
import { speedsOffer } from "../ui/speeds-offer.js";
import { inLanguage, t } from "../ui/texts.js";
import { isBare, shortType } from "./connection-model.js";

/** @import { ConnectionModel, Role } from "./connection-model.js" */
/** @import { FoundPart as Part, TopicRole, UsedTopic as Used } from "../net/rest.js" */

/** @type {Record<Role, string>} */
const NAMES = {
  odometry: t("connect-parts.odometry"),
  scan: t("connect-parts.laser"),
  image: t("connect-parts.camera"),
  camera_info: t("connect-parts.camera_calibration"),
  sound: t("connect-parts.microphones"),
  cmd_vel: t("connect-parts.speeds_to_the_robot"),
  cmd_vel_type: "",
  battery: t("connect-parts.battery"),
  map: t("connect-parts.its_own_map"),
  pose: t("connect-parts.its_own_pose"),
  frames: t("connect-parts.mountings"),
  description: t("connect-parts.its_own_description"),
};
const TYPES = [t("connect-parts.twist"), "TwistStamped"];
const UNUSED = "";

/** @extends {PagePanel<ConnectionModel>} */
class ConnectParts extends PagePanel {
  #list = make("div.page-cards");
  #again = make("button.button.primary", icon("again"), t("connect-parts.look_again"));
  #changed = make(
    "div.row.connect-changed",
    make("p", t("connect-parts.other_topics_are_chosen_look_again")),
    this.#again,
  );
  /** @type {Map<string, {rate: HTMLElement, said: HTMLElement}>} cells that change with every reading */
  #cells = new Map();

  /** @override */
  build() {
    this.append(this.#list, this.#changed);
    this.#again.addEventListener("click", () => {
      const model = this.model;
      if (model?.found) void model.look(model.found.url);
    });
    this.draw();
  }

  /** @override */
  draw() {
    const model = this.model;
    this.#changed.hidden = !model.changed;
    this.#again.disabled = Boolean(model.busy);
    const { found } = model;
    if (!found) return;
    this.hidden = found.parts.every((part) => isBare(part, found));
    if (isNew(this, found.parts.map(lasting), model.may)) {
      this.#cells.clear();
      this.#list.replaceChildren(
        ...found.parts.flatMap((part, index) => (isBare(part, found) ? [] : this.#part(part, index))),
      );
    }
    for (const [index, { findings }] of found.parts.entries()) {
      for (const { role, used } of findings.roles) {
        for (const [place, one] of used.entries()) this.#refresh(`${index} ${role} ${place}`, one, role);
      }
    }
  }

  /** @param {string} key @param {Used} used @param {Role} role */
  #refresh(key, used, role) {
    const cells = this.#cells.get(key);
    if (!cells) return;
    write(cells.rate, rateOf(used, role));
    write(cells.said, [shortType(used.type), used.frame && `frame ${used.frame}`].filter(Boolean).join(" · "));
  }

  /** @param {Part} part @param {number} index */
  #part(part, index) {
    const { roles, remarks, faults, base_frame: base } = part.findings;
    const about = [equipment(part), base && t("connect-parts.base_frame_base", { base })].filter(Boolean).join(" · ");
    const missing = roles.map((one) => one.remark).filter(Boolean);
    const coded = faults.map(({ sentence, code }) => `${inLanguage(sentence)} (${code})`);
    const others = remarks.filter((one) => !faults.some(({ sentence }) => sentence === one));
    const said = [...coded, ...others, ...missing];
    const offers = this.model.own ? faults.map(({ code }) => this.#offer(code, roles)) : [];
    return make(
      "section.card.page-card",
      { "aria-label": part.name },
      make("h2.connect-part", part.name),
      make("p.note", part.up ? about : t("connect-parts.about_does_not_answer", { about })),
      roles.length > 0 && make("div.connect-roles", ...roles.flatMap((role) => this.#rows(role, index))),
      said.length > 0 &&
        make("ul.connect-remarks", ...said.map((text) => make("li", icon("info"), make("span", inLanguage(text))))),
      ...offers,
    );
  }

  /** The other type of the speeds than the one that is used. @param {string} code @param {TopicRole[]} roles */
  #offer(code, roles) {
    const sent = roles.find(({ role }) => role === "cmd_vel")?.used[0]?.type ?? "";
    const other = shortType(sent) === "Twist" ? "TwistStamped" : "Twist";
    return speedsOffer(this.session, { code, values: { other } });
  }

  /** @param {TopicRole} role @param {number} part */
  #rows(role, part) {
    const count = Math.min(role.most, Math.max(role.candidates.length, 1));
    const selects = Array.from({ length: count }, (_, place) => this.#select(role, part, place));
    return selects.map((select, place) => {
      const name = place === 0 ? NAMES[role.role] : `${NAMES[role.role]} ${place + 1}`;
      const cells = {
        rate: make("span.connect-rate", role.used[place] ? "" : "–"),
        said: make("span.note.connect-said"),
      };
      this.#cells.set(`${part} ${role.role} ${place}`, cells);
      const typed = role.role === "cmd_vel" && place === 0 && role.used[0] ? this.#type(role, part) : null;
      select?.addEventListener("change", () => {
        const topics = new Set(selects.map((one) => one?.value ?? UNUSED).filter((topic) => topic !== UNUSED));
        this.model.choose(part, role.role, [...topics]);
      });
      if (select) select.setAttribute("aria-label", name);
      return make(
        "div.connect-role",
        { "data-empty": !role.used[place] },
        make("span.connect-name", name),
        make(
          "div.connect-topic",
          select ?? make("span.connect-fixed", role.used[place]?.topic ?? t("connect-parts.none_found")),
          typed,
        ),
        cells.said,
        cells.rate,
      );
    });
  }

  /** @param {TopicRole} role @param {number} part @param {number} place */
  #select({ role, used, candidates }, part, place) {
    if (role === "frames" || candidates.length === 0) return null;
    const select = make(
      "select.field-box.connect-input",
      { disabled: !this.model.may },
      ...candidates.map(({ topic }) => make("option", { value: topic }, topic)),
      make("option", { value: UNUSED }, t("connect-parts.not_used")),
    );
    const chosen = this.model.choices.get(`${part} ${role}`)?.topics ?? used.map(({ topic }) => topic);
    select.value = chosen[place] ?? UNUSED;
    return select;
  }

  /** @param {TopicRole} role @param {number} part */
  #type({ used }, part) {
    const select = make(
      "select.field-box.connect-input.connect-type",
      { "aria-label": t("connect-parts.type_of_the_speeds"), disabled: !this.model.may },
      ...TYPES.map((name) => make("option", { value: name }, name)),
    );
    select.value = shortType(used[0]?.type ?? "");
    select.addEventListener("change", () => this.model.choose(part, "cmd_vel_type", [select.value]));
    return select;
  }
}

/** What a part has, in words. @param {Part} part */
export const equipment = (part) =>
  [
    part.drives && t("connect-parts.base"),
    ...part.lasers.map((name) => named(t("connect-parts.laser"), name, "laser")),
    ...part.cameras.map((name) => named(t("connect-parts.camera"), name, "camera")),
    ...part.microphones.map(() => t("connect-parts.microphones")),
  ]
    .filter(Boolean)
    .join(", ") || t("connect-parts.no_sensor");

/** @param {string} kind @param {string} name @param {string} usual the name of the only one */
const named = (kind, name, usual) => (name === usual ? kind : `${kind} ${name}`);

/** What of a part stays from one reading to the next. @param {Part} part */
const lasting = ({ findings, ...part }) => ({
  ...part,
  base: findings.base_frame,
  remarks: findings.remarks,
  faults: findings.faults,
  roles: findings.roles.map(({ used, ...role }) => ({ ...role, used: used.map(({ topic }) => topic) })),
});

/** @param {Used} used @param {Role} role */
function rateOf({ rate_hz: rate, age_s: old }, role) {
  if (role === "cmd_vel") return t("connect-parts.sent_while_driving");
  if (old === null) return t("connect-parts.nothing_came_yet");
  if (rate === null || role === "frames" || role === "description")
    return t("connect-parts.age_ago", { age: age(old) });
  return old > Math.max(1, 5 / rate)
    ? t("connect-parts.last_age_ago", { age: age(old) })
    : `${fixed(rate, rate < 9.95 ? 1 : 0)} Hz`;
}

customElements.define("connect-parts", ConnectParts);
