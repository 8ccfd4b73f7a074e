// Base classes of the panels: custom elements that are built once and then show views, or the model of their page.

import { unlessPressed } from "./press.js";

/** @import { Session, View } from "../net/session.js" */

export class Panel extends HTMLElement {
  /** @type {Session | null} */
  #session = null;

  /** @returns {Session} */
  get session() {
    if (!this.#session) throw new Error(`<${this.localName}> was used before it was given a session.`);
    return this.#session;
  }

  /** @param {Session} session */
  join(session) {
    this.#session = session;
    this.build();
  }

  /** Draw what stays and listen. Called once. */
  build() {}

  /** Called at most once per animation frame, and at least five times a second. @param {View} _view */
  show(_view) {}

  /** The page of this panel is shown, again or for the first time. Panels of the console itself are not called. */
  pageOpened() {}

  /** Another page is shown. */
  pageLeft() {}
}

/**
 * A panel that is drawn whenever the model of its page changes.
 * @template {import("./page-model.js").PageModel} Model
 */
export class PagePanel extends Panel {
  /** @type {Model | null} */
  #model = null;

  /** @returns {Model} */
  get model() {
    if (!this.#model) throw new Error(`<${this.localName}> was used before it was given a model.`);
    return this.#model;
  }

  /** @param {Model} model */
  watch(model) {
    this.#model = model;
    model.onChange(() => this.changed());
  }

  changed() {
    unlessPressed(this, () => this.draw());
  }

  draw() {}
}
