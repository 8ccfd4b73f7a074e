// Base class of the dialogs over the page. Not modal: STOP stays reachable, and Escape closes and stops.

import { cardHead, iconButton, make } from "./element.js";
import { Panel } from "./panel.js";
import { t } from "./texts.js";

export class Sheet extends Panel {
  #close = iconButton("close", t("sheet.close"), () => this.shut());
  /** @type {HTMLElement | null} */
  #cameFrom = null;

  /** Build the dialog, closed. @param {string} title @param {...(Node | string)} content */
  frame(title, ...content) {
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", title);
    this.append(make("div.card.sheet", cardHead(title, this.#close), ...content));
    this.addEventListener("click", (event) => event.target === this && event.detail < 2 && this.#leave(event));
    addEventListener("keydown", (event) => event.key === "Escape" && this.shut());
  }

  toggle() {
    if (!this.hasAttribute("hidden")) {
      this.shut();
      return;
    }
    this.#cameFrom = document.activeElement instanceof HTMLElement ? document.activeElement : null;
    this.hidden = false;
    this.#close.focus();
  }

  /** A press beside the dialog closes it. On a tool, a tab or the command line it is a press on that, too. @param {MouseEvent} event */
  #leave({ clientX, clientY }) {
    this.shut();
    const below = document
      .elementFromPoint(clientX, clientY)
      ?.closest("[role=toolbar] button, [role=tab], page-menu a, .words");
    if (below instanceof HTMLInputElement) below.focus();
    else if (below instanceof HTMLElement) below.click();
  }

  shut() {
    if (this.hidden) return;
    this.hidden = true;
    this.#cameFrom?.focus();
  }
}
