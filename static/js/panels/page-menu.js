// Element <page-menu>: the pages. A rail on a wide screen, a button with a list on a narrow one.

import { onlyWatched } from "../drive/permission.js";
import { PAGES } from "../shell/pages.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */
/** @import { PageRow } from "../shell/pages.js" */

const NARROW = matchMedia("(max-width: 1199px), (max-height: 539px)"); // as in css/shell.css

export class PageMenu extends Panel {
  #icon = icon("wheel");
  #name = make("span.pages-name");
  #button = make(
    "button.bar-chip.pages-button",
    { "aria-label": t("page-menu.pages") },
    this.#icon,
    this.#name,
    icon("chevron"),
  );
  #links = new Map(PAGES.map((row) => [row.path, link(row)]));
  #list = make("ul.pages-list", ...[...this.#links.values()].map((one) => make("li", one)));
  #settings = make("button.pages-link", icon("settings"), make("span", t("app-menu.settings")));
  #nav = make("nav.pages", { "aria-label": t("page-menu.pages") }, this.#list);

  /** @override */
  build() {
    this.append(this.#button, this.#nav);
    const { close } = popover(this.#button, this.#nav, { folds: () => NARROW.matches });
    this.#list.append(make("li", this.#settings));
    this.#settings.addEventListener("click", () =>
      this.dispatchEvent(new CustomEvent("show-settings", { bubbles: true })),
    );
    for (const one of [...this.#links.values(), this.#settings]) one.addEventListener("click", close);
    for (const one of this.#links.values()) one.addEventListener("click", () => this.#opening(one)); // at once: a page takes a moment the first time
    this.session.on("trouble", () => this.#opening(null));
    const lay = () => {
      this.#nav.classList.toggle("popover", NARROW.matches);
      this.#nav.hidden = NARROW.matches;
      this.#button.hidden = !NARROW.matches;
    };
    NARROW.addEventListener("change", lay);
    lay();
  }

  /** @param {HTMLElement | null} link that was pressed, and whose page is on its way */
  #opening(link) {
    for (const one of this.#links.values()) mark(one, "data-opening", one === link);
  }

  /** @param {PageRow} row the page that is open */
  open(row) {
    this.#opening(null);
    for (const [path, one] of this.#links) mark(one, "aria-current", path === row.path ? "page" : null);
    write(this.#name, row.name);
    redraw(this.#icon, row.icon);
    mark(this.#button, "aria-label", t("page-menu.pages_name", { name: row.name }));
  }

  /** @override @param {View} view */
  show({ hello }) {
    for (const { path, drives } of PAGES)
      mark(item(this.#links, path), "hidden", drives === true && onlyWatched(hello));
  }
}

/** @param {Map<string, HTMLElement>} links @param {string} path */
const item = (links, path) => /** @type {HTMLElement} */ (links.get(path)?.parentElement);

/** @param {PageRow} row */
const link = ({ path, name, icon: drawing }) =>
  make("a.pages-link", { href: path || "./" }, icon(drawing), make("span", name));

customElements.define("page-menu", PageMenu);
