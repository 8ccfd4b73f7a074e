// Element <theme-toggle>: button that switches between auto, dark and light.

import { icon, make, redraw } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { choose, next, onTheme, theme } from "../ui/theme.js";

class ThemeToggle extends Panel {
  #icon = icon("auto");
  #button = make("button.icon-button", this.#icon, make("span.bar-word", t("theme-toggle.theme")));

  /** @override */
  build() {
    this.append(this.#button);
    this.#button.addEventListener("click", () => {
      choose(next());
      this.session.announce(t("theme-toggle.theme_theme", { theme: theme() }));
    });
    onTheme(() => this.#draw());
    this.#draw();
  }

  #draw() {
    redraw(this.#icon, theme());
    const says = t("theme-toggle.theme_theme_press_for_next", { theme: theme(), next: next() });
    this.#button.setAttribute("aria-label", says);
    this.#button.title = says;
  }
}

customElements.define("theme-toggle", ThemeToggle);
