// What the models of the pages have in common: who listens, and who may change something.

import { call, post, sentenceOf } from "../net/api.js";

/** @import { Session } from "../net/session.js" */

export const AGAIN_MS = 2000; // after which what could not be read is read again

/** Client model of a page: its panels hear of every change. */
export class PageModel {
  shown = false; // the page is open
  busy = ""; // a sentence on what is being done
  #failed = ""; // why what was asked for last did not work; it stays until something else is asked for
  #unread = ""; // why what the page shows could not be read
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #again;
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

  /** A sentence on what went wrong; "" when nothing did. */
  get trouble() {
    return this.#failed || this.#unread;
  }

  async read() {}

  /** @param {boolean} shown true while the page is open */
  follow(shown) {
    this.shown = shown;
    if (shown) void this.read();
  }

  /** True while the page is linked and its window is seen. */
  get visible() {
    return this.session.hello !== null && document.visibilityState === "visible";
  }

  /** Read again and again while it is wanted. @param {number} period [ms] @param {() => boolean} wants */
  poll(period, wants) {
    setInterval(() => this.visible && wants() && void this.read(), period);
  }

  /** Read what the page shows; where it cannot be read, say why, and try again. @param {() => Promise<unknown>} act */
  async reading(act) {
    clearTimeout(this.#again);
    try {
      await act();
      this.#unread = "";
    } catch (refusal) {
      this.#unread = sentenceOf(refusal);
      clearTimeout(this.#again);
      this.#again = setTimeout(() => void (this.shown && this.read()), AGAIN_MS);
    }
    this.tell();
  }

  /**
   * Do what was asked for, and say why where it does not work.
   * @param {string} doing @param {() => Promise<unknown>} act
   * @returns {Promise<boolean>} whether it was done
   */
  async during(doing, act) {
    [this.busy, this.#failed] = [doing, ""];
    this.tell();
    try {
      await act();
    } catch (refusal) {
      this.#failed = sentenceOf(refusal);
    }
    this.busy = "";
    this.tell();
    return this.#failed === "";
  }

  forgive() {
    this.#failed = "";
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

  /** @param {Session} session @param {string} all path of what the page shows @param {string} root of the requests about one */
  constructor(session, all, root) {
    super(session);
    this.all = all;
    this.root = root;
    session.on("hello", () => this.shown && void this.read());
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

  /** @override */
  async read() {
    const before = this.running;
    await this.reading(async () => this.take(await call(this.all)));
    const after = before && this.runs?.find((run) => run.id === before.id);
    if (after && after.state !== "running") this.session.announce(this.endOf(after));
  }

  /** @param {any} answer with the runs */
  take({ runs }) {
    this.runs = runs;
  }

  /** What is announced at its end. @param {Run} _run */
  endOf(_run) {
    return "";
  }

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
