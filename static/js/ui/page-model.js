// What the models of the pages have in common: who listens, and who may change something.

import { call, post } from "../net/api.js";

/** @import { Session } from "../net/session.js" */

/** Client model of a page: its panels hear of every change. */
export class PageModel {
  /** @type {Set<() => void>} */
  #listeners = new Set();

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
  }

  /** True unless this user is a viewer. */
  get may() {
    return this.session.hello !== null && this.session.hello.you.role !== "viewer";
  }

  /** @param {() => void} listener called after each change */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  tell() {
    for (const listener of this.#listeners) listener();
  }
}

/**
 * Client model of a page of runs: one at a time, and one of them is looked at.
 * @template {{id: string, state: "running" | "done" | "cancelled" | "failed"}} Run
 */
export class RunsModel extends PageModel {
  /** @type {Run[] | null} newest first; null until they were read */
  runs = null;
  /** @type {string} of the one that is shown; "" for the newest */
  chosen = "";

  /** @param {Session} session @param {string} root of the requests about one */
  constructor(session, root) {
    super(session);
    this.root = root;
  }

  get running() {
    return this.runs?.find((run) => run.state === "running") ?? null;
  }

  get selected() {
    return this.runs?.find((run) => run.id === this.chosen) ?? this.runs?.[0] ?? null;
  }

  /** @param {string} id */
  choose(id) {
    this.chosen = id;
    this.tell();
  }

  async read() {}

  /** @param {object} request */
  begin(request) {
    return this.#tried(async () => this.choose((await post(this.root, request)).id));
  }

  /** @param {string} id */
  cancel(id) {
    return this.#tried(() => post(`${this.root}/${encodeURIComponent(id)}/cancel`));
  }

  /** @param {string} id */
  remove(id) {
    return this.#tried(() => call(`${this.root}/${encodeURIComponent(id)}`, { method: "DELETE" }));
  }

  /** @param {() => Promise<unknown>} act */
  async #tried(act) {
    await this.session.attempt(act);
    await this.read();
  }
}
