// Element <tab-card>: one card of tabs; each of its children with `data-tab` is a panel.

import { icon, make, mark, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @typedef {{panel: HTMLElement, tab: HTMLButtonElement, count: HTMLElement}} Tab */

export class TabCard extends Panel {
  /** @type {Map<string, Tab>} */
  #tabs = new Map();
  #list = make("div.tabs", { role: "tablist", "aria-label": t("tab-card.details") });
  #open = "";

  /** @override */
  build() {
    const panels = /** @type {HTMLElement[]} */ ([...this.querySelectorAll(":scope > [data-tab]")]);
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("tab-card.details"));
    for (const panel of panels) this.#add(panel);
    this.#list.append(...[...this.#tabs.values()].map(({ tab }) => tab));
    this.#list.addEventListener("keydown", (event) => this.#move(event));
    this.prepend(this.#list);
    addEventListener("open-view", (event) => this.open(/** @type {CustomEvent<string>} */ (event).detail));
    this.open(panels[0]?.dataset["tab"] ?? "");
  }

  /** Hide tabs without content: a recording has no commands, a robot may lack microphones. @override */
  show() {
    for (const { panel, tab, count } of this.#tabs.values()) {
      const parts = /** @type {HTMLElement[]} */ ([...panel.children]);
      mark(
        tab,
        "hidden",
        parts.every((part) => part.hidden),
      );
      const unseen = parts.map((part) => part.dataset["unseen"] ?? "").join("");
      mark(count, "hidden", unseen === "");
      write(count, unseen);
    }
    if (this.#tabs.get(this.#open)?.tab.hidden) this.open(this.#shown()[0] ?? "");
  }

  /** @param {string} name of a tab; another name changes nothing */
  open(name) {
    if (!this.#tabs.has(name)) return;
    this.#open = name;
    this.dataset["open"] = name;
    for (const [each, { panel, tab }] of this.#tabs) {
      mark(panel, "hidden", each !== name);
      mark(tab, "aria-selected", String(each === name));
      tab.tabIndex = each === name ? 0 : -1;
    }
    const { left, right } = this.#list.getBoundingClientRect();
    const tab = this.#tabs.get(name)?.tab.getBoundingClientRect();
    // not by scrollIntoView: in Chromium 150 the Tab key would go on from there, and not from the page's beginning
    if (tab) this.#list.scrollLeft += Math.min(tab.left - left, 0) + Math.max(tab.right - right, 0);
  }

  /** @param {HTMLElement} panel */
  #add(panel) {
    const name = panel.dataset["tab"] ?? "";
    const words = panel.dataset["name"] ?? name;
    const count = make("span.count", { hidden: true });
    const tab = make(
      "button.tab",
      { role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, onclick: () => this.open(name) },
      icon(panel.dataset["icon"] ?? name),
      make("span.tab-words", words),
      count,
    );
    tab.title = words;
    panel.id = `panel-${name}`;
    panel.tabIndex = 0; // it scrolls
    panel.setAttribute("role", "tabpanel");
    panel.setAttribute("aria-labelledby", tab.id);
    this.#tabs.set(name, { panel, tab, count });
  }

  /** Names of the tabs that can be opened, in their order. */
  #shown() {
    return [...this.#tabs].filter(([, { tab }]) => !tab.hidden).map(([name]) => name);
  }

  /** @param {KeyboardEvent} event */
  #move(event) {
    const shown = this.#shown();
    const at = shown.indexOf(this.#open);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: shown.length - 1 }[event.key];
    if (to === undefined || event.defaultPrevented) return; // after a press of the mouse the arrows drive
    event.preventDefault();
    const name = shown[(to + shown.length) % shown.length] ?? this.#open;
    this.open(name);
    this.#tabs.get(name)?.tab.focus();
  }
}

customElements.define("tab-card", TabCard);
