// Element <login-view>: sign-in with the token that Beckon prints when it starts.

import { login, sentenceOf } from "../net/api.js";
import { icon, make, onSubmit, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

class LoginView extends Panel {
  #box = make("input.words", {
    id: "token",
    type: "password",
    autocomplete: "off",
    spellcheck: "false",
    autocapitalize: "off",
    required: true,
    maxlength: "400",
  });
  #enter = make("button.button.primary", { type: "submit" }, t("login-view.sign_in"));
  #says = make("p.login-says", { role: "alert" });

  /** @override */
  build() {
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("login-view.sign_in"));
    const form = make(
      "form.card.login",
      icon("mark"),
      make("h2.heading", t("login-view.sign_in_to_beckon")),
      make("p", t("login-view.beckon_printed_a_link_where_it")),
      make("label", { for: "token" }, t("login-view.token")),
      this.#box,
      this.#enter,
      this.#says,
    );
    this.append(form);
    onSubmit(form, () => void this.enter(this.#box.value.trim().replace(/^.*#t=/, "")));
    this.session.on("signed-out", () => this.#open());
  }

  /** @param {string} token */
  async enter(token) {
    this.#enter.disabled = true;
    write(this.#says, "");
    try {
      await login(token);
      this.#box.value = "";
      this.hidden = true;
      document.body.classList.remove("is-signed-out");
      await this.session.begin();
    } catch (refusal) {
      this.#open();
      write(this.#says, sentenceOf(refusal));
    } finally {
      this.#enter.disabled = false;
    }
  }

  #open() {
    this.hidden = false;
    document.body.classList.add("is-signed-out");
    this.#box.focus();
  }
}

/** Use the token of a printed link at once, and remove it from the address. @returns {boolean} whether there is one */
export function enterByLink() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return false;
  history.replaceState(null, "", location.pathname + location.search);
  void (/** @type {LoginView} */ (document.querySelector("login-view")).enter(token));
  return true;
}

customElements.define("login-view", LoginView);
