// Auto, dark, light: one button that walks through them.

import { icon, make, redraw } from "../element.js";
import { Panel } from "../panel.js";
import { choose, next, onTheme, theme } from "../theme.js";

class ThemeToggle extends Panel {
  #icon = icon("auto");
  #button = make("button", { type: "button", class: "icon-button" }, this.#icon);

  /** @override */
  build() {
    this.append(this.#button);
    this.#button.addEventListener("click", () => {
      choose(next());
      this.session.announce(`Theme: ${theme()}.`);
    });
    onTheme(() => this.#draw());
    this.#draw();
  }

  #draw() {
    redraw(this.#icon, theme());
    const says = `Theme: ${theme()}. Press for ${next()}.`;
    this.#button.setAttribute("aria-label", says);
    this.#button.title = says;
  }
}

customElements.define("theme-toggle", ThemeToggle);
