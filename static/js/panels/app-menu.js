// Element <app-menu>: halt, keys, hints, HTTP interface, sign-out.

import { icon, make, mark } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { keep, recorderOf } from "../ui/recorder.js";
import { chooseLanguage, LANGUAGES, language, t } from "../ui/texts.js";
import { choose, next } from "../ui/theme.js";

/** @import { View } from "../net/session.js" */

class AppMenu extends Panel {
  #button = make(
    "button.icon-button",
    { "aria-label": t("app-menu.menu"), title: t("app-menu.menu") },
    icon("menu"),
    make("span.bar-word", t("app-menu.menu")),
  );
  #halt = item("halt", t("app-menu.halt"), t("app-menu.stops_the_robot_and_keeps_it"));
  #reset = item("undo", t("app-menu.reset_the_halt"), t("app-menu.the_reset_itself_does_not_move"));
  #keys = item("keys", t("app-menu.keys"), t("app-menu.every_key_of_this_page"));
  #gamepad = item("gamepad", t("app-menu.gamepad"), t("app-menu.its_buttons_and_sticks_and_what"));
  #signIns = item("qr", t("app-menu.phones_and_sign_ins"), t("app-menu.a_link_for_a_phone_or"));
  #tour = item("play", t("app-menu.tour"), t("app-menu.ninety_seconds_in_the_simulator_any"));
  #keep = item("keep", t("record-button.keep_what_just_happened"), t("app-menu.the_last_minutes_become_a_recording"));
  #hints = item("hints", t("app-menu.show_the_first_hints_again"), "");
  #theme = item("auto", t("theme-toggle.theme"), t("app-menu.dark_light_or_as_the_system"));
  #single = make("input.switch", { type: "checkbox", role: "switch" });
  #switch = make(
    "label.menu-item",
    icon("typed"),
    make(
      "span.menu-words",
      make("span", t("app-menu.single_key_shortcuts")),
      make("span.note", t("app-menu.w_a_s_d_space_digits")),
    ),
    this.#single,
  );
  #language = make(
    "select.field-box",
    { id: "language", onchange: () => chooseLanguage(this.#language.value) },
    ...Object.entries(LANGUAGES).map(([value, name]) => make("option", { value, lang: value }, name)),
  );
  #languageRow = make(
    "label.menu-item",
    { for: "language" },
    icon("globe"),
    make("span.menu-words", make("span", t("app-menu.language")), make("span.note", t("app-menu.language_says"))),
    this.#language,
  );
  #docs = make(
    "a.menu-item",
    { href: "docs", target: "_blank", rel: "noopener" },
    icon("book"),
    make("span.menu-words", t("app-menu.http_interface")),
  );
  #leave = item("leave", t("app-menu.sign_out"), "");
  #panel = make(
    "div.menu",
    { role: "group", "aria-label": t("app-menu.menu") },
    this.#halt,
    this.#reset,
    this.#keep,
    this.#languageRow,
    this.#theme,
    this.#signIns,
    this.#keys,
    this.#switch,
    this.#gamepad,
    this.#tour,
    this.#hints,
    this.#docs,
    this.#leave,
  );

  /** @override */
  build() {
    this.append(this.#button, this.#panel);
    mark(this.#halt, "data-tone", "fault");
    this.#theme.classList.add("menu-theme");
    const { close } = popover(this.#button, this.#panel);
    this.#language.value = language;
    this.#single.checked = remembered("single-keys", "on") === "on";
    this.#single.addEventListener("keydown", (event) => event.key === "Enter" && this.#single.click()); // Space stops
    this.#single.addEventListener("change", () => {
      remember("single-keys", this.#single.checked ? "on" : "off");
      this.dispatchEvent(new CustomEvent("single-keys", { detail: this.#single.checked, bubbles: true }));
    });
    /** @param {HTMLElement} row @param {() => void} act */
    const on = (row, act) =>
      row.addEventListener("click", () => {
        close();
        act();
      });
    on(this.#halt, () => this.session.halt());
    on(this.#reset, () => void this.session.resetHalt());
    on(this.#keep, () => void keep(this.session));
    on(this.#keys, () => this.dispatchEvent(new CustomEvent("show-keys", { bubbles: true })));
    on(this.#gamepad, () => this.dispatchEvent(new CustomEvent("show-gamepad", { bubbles: true })));
    on(this.#signIns, () => this.dispatchEvent(new CustomEvent("show-sign-ins", { bubbles: true })));
    on(this.#tour, () => dispatchEvent(new CustomEvent("show-tour")));
    on(this.#hints, () => this.dispatchEvent(new CustomEvent("show-hints", { bubbles: true })));
    on(this.#leave, () => void this.session.leave());
    this.#theme.addEventListener("click", () => choose(next())); // the menu stays open: there are three
  }

  /** @override @param {View} view */
  show(view) {
    const { hello, state, up } = view;
    const { holds, whyNotKept } = recorderOf(view);
    this.#keep.hidden = !holds;
    mark(this.#keep, "aria-disabled", whyNotKept ? "true" : null);
    const drives = hello?.robot.drives === true;
    this.#halt.hidden = !drives; // a row never changes under a finger, and a halt may always be tried
    this.#reset.hidden = !drives || hello?.you.role === "viewer";
    this.#reset.disabled = !up || state?.gate.state !== "halted";
    this.#hints.hidden = !drives || hello?.you.role === "viewer";
    this.#tour.hidden = this.#hints.hidden || !hello?.robot.capabilities.includes("simulate");
    this.#switch.hidden = this.#gamepad.hidden = !drives;
    this.#signIns.hidden = hello?.you.role !== "admin" || hello.you.id === "local";
    this.#leave.hidden = hello?.you.id === "local"; // no sign-in on this machine
  }
}

/** @param {string} drawing @param {string} name @param {string} says */
function item(drawing, name, says) {
  const words = make("span.menu-words", make("span.menu-name", name), says && make("span.note", says));
  return make("button.menu-item", icon(drawing), words);
}

customElements.define("app-menu", AppMenu);
