// Shell: shows one page at a time without loading the document again; the link, the map and the camera stay.

import { make } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { PAGES, pageAt } from "./pages.js";

/** @import { Session } from "../net/session.js" */
/** @import { OpenPage, PageRow } from "./pages.js" */

/** Roles of the console while it is the page, a dock beside one, or no more than the status over one. */
const ROLES = /** @type {const} */ ({
  page: ["main", t("shell.robot_console")],
  dock: ["complementary", t("shell.map_and_camera")],
  status: ["region", t("shell.banners_and_status")],
});

export class Shell {
  #session;
  #console;
  #adopt;
  /** @type {Map<string, {main: HTMLElement, page: OpenPage, panels: Panel[]}>} pages that were opened before, by path */
  #built = new Map();
  /** @type {Map<string, string>} hash of each page when it was left */
  #hashes = new Map();
  /** @type {PageRow | null} */
  #current = null;
  #opening = 0;
  /** @type {Set<(row: PageRow) => void>} */
  #listeners = new Set();

  /**
   * @param {Session} session
   * @param {(root: Document | Element, model: unknown) => Panel[]} adopt joins the panels of a new page to the session
   */
  constructor(session, adopt) {
    this.#session = session;
    this.#adopt = adopt;
    this.#console = /** @type {HTMLElement} */ (document.querySelector(".console"));
    document.addEventListener("click", (event) => this.#follow(event));
    addEventListener("popstate", () => void this.#show(false));
    addEventListener("hashchange", () => this.#move());
    addEventListener("place-robot", () => this.go(""), true); // the large map is where it is placed
    session.on("hello", () => this.#entitle());
  }

  /** @param {(row: PageRow) => void} listener called at once, and whenever another page is shown */
  onPage(listener) {
    this.#listeners.add(listener);
    if (this.#current) listener(this.#current);
  }

  /** True for panels that no page hides now. @param {Panel} panel */
  shows(panel) {
    const owner = panel.closest("main.page");
    return owner === null || !owner.hasAttribute("hidden");
  }

  /** Show the page of the address for the first time. */
  begin() {
    const lost = new URLSearchParams(location.hash.slice(1)).get("nothing-at");
    if (lost) {
      history.replaceState(null, "", location.pathname);
      if (lost.endsWith("/settings")) dispatchEvent(new CustomEvent("show-settings"));
      else this.#session.complain(t("shell.nothing_at_path", { path: lost }));
    }
    return this.#show(false);
  }

  /** @param {string} path of a page; it opens where it was left */
  go(path) {
    if (path === this.#current?.path) return;
    history.pushState(null, "", (path || "./") + (this.#hashes.get(path) ?? ""));
    void this.#show(true);
  }

  /** The hash of the open page has changed. */
  #move() {
    if (!this.#current || pageAt(location.pathname) !== this.#current) return; // another page is being opened
    this.#hashes.set(this.#current.path, location.hash);
    this.#built.get(this.#current.path)?.page.moved?.();
  }

  /** Follow links between the pages without loading a document. @param {MouseEvent} event */
  #follow(event) {
    const [target] = event.composedPath();
    const link = target instanceof Element ? target.closest("a[href]") : null;
    const other = event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey;
    if (!(link instanceof HTMLAnchorElement) || other || event.defaultPrevented || link.target || link.download) return;
    const to = new URL(link.href);
    const folder = new URL("./", location.href);
    const near = to.origin === folder.origin && new URL("./", to).pathname === folder.pathname;
    const row = near ? pageAt(to.pathname) : null;
    if (!row || (row === this.#current && to.hash)) return; // within a page the browser follows by itself
    event.preventDefault();
    if (row === this.#current) {
      if (!location.hash) return;
      history.pushState(null, "", to.pathname); // back to its beginning
      this.#move();
    } else if (to.hash) {
      history.pushState(null, "", to.pathname + to.hash);
      void this.#show(true);
    } else this.go(row.path);
  }

  /** @param {boolean} focus true: the reader is taken to the heading of the page */
  async #show(focus) {
    const row = pageAt(location.pathname) ?? PAGES[0];
    if (!row || row === this.#current) return;
    const opening = ++this.#opening;
    if (row.load && !this.#built.has(row.path)) {
      const built = await this.#build(row, row.load).catch(() => null);
      if (opening !== this.#opening) return;
      if (built === null) {
        this.#session.complain(t("shell.the_page_name_could_not_be", { name: row.name }));
        history.replaceState(null, "", this.#current?.path || "./");
        return;
      }
    }
    this.#change(row, focus);
  }

  /** @param {PageRow} row @param {NonNullable<PageRow["load"]>} load */
  async #build(row, load) {
    const [module] = await Promise.all([load(), ...(row.styles ?? []).map(styled)]);
    const known = this.#built.get(row.path);
    if (known) return known; // it was asked for twice
    const page = module.create(this.#session);
    const main = make("main.page", { id: `page-${row.path}`, "aria-label": row.name, hidden: true });
    const heading = make("h1", { tabindex: "-1" }, row.name);
    const head = make("header.page-head", heading, row.says && make("p", row.says));
    main.append(make("div.page-frame", head, page.element));
    this.#console.after(main);
    const built = { main, page, panels: this.#adopt(main, page.model) };
    this.#built.set(row.path, built);
    return built;
  }

  /** @param {PageRow} row @param {boolean} focus */
  #change(row, focus) {
    const before = this.#built.get(this.#current?.path ?? "");
    before?.page.left?.();
    for (const panel of before?.panels ?? []) panel.pageLeft();
    this.#current = row;
    const after = this.#built.get(row.path);
    for (const { main } of this.#built.values()) main.hidden = main !== after?.main;
    const [role, name] = ROLES[row.path === "" ? "page" : row.docked ? "dock" : "status"];
    this.#console.setAttribute("role", role);
    this.#console.setAttribute("aria-label", name);
    for (const part of this.#console.querySelectorAll(".stage, camera-view"))
      part.toggleAttribute("inert", row.path !== ""); // a docked map is for looking
    document.body.dataset["page"] = row.path || "drive";
    document.body.toggleAttribute("data-docked", row.docked === true);
    this.#hashes.set(row.path, location.hash);
    after?.page.opened?.();
    for (const panel of after?.panels ?? []) panel.pageOpened();
    this.#entitle();
    for (const listener of this.#listeners) listener(row);
    if (!focus) return;
    after?.main.querySelector("h1")?.focus();
    this.#session.announce(`${row.name}.`);
  }

  #entitle() {
    const name = this.#current?.path ? this.#current.name : (this.#session.hello?.robot.name ?? "");
    document.title = name ? `${name} · Beckon` : "Beckon";
  }
}

/** @param {string} file of static/css */
function styled(file) {
  const link = make("link", { rel: "stylesheet", href: new URL(`../../css/${file}`, import.meta.url).href });
  return new Promise((resolve, reject) => {
    link.addEventListener("load", resolve);
    link.addEventListener("error", reject);
    document.head.append(link);
  });
}
