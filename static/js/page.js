// Start of the page: theme, common panels, session, shell, redrawing, and sign-in by a printed link.

import "./panels/banner-stack.js";
import "./panels/link-chip.js";
import "./panels/notice-toasts.js";
import "./panels/page-menu.js";
import "./panels/record-button.js";
import "./panels/stop-button.js";
import "./panels/theme-toggle.js";
import "./ui/theme.js";
import { Session } from "./net/session.js";
import { enterByLink } from "./panels/login-view.js";
import { Shell } from "./shell/shell.js";
import { takeComma } from "./ui/decimal-comma.js";
import { Panel } from "./ui/panel.js";
import { isPressed } from "./ui/press.js";
import { writeTexts } from "./ui/texts.js";

const SHOW_MS = 200; // ages grow without news, and a browser that draws slowly must not keep quiet about it

/**
 * Join the panels of the document to a new session, keep them drawn, open the page of the address, and sign in.
 * Import the panels of the document first.
 * @param {(session: Session, shell: Shell) => void} begin called once, before the first message
 */
export function startPage(begin) {
  writeTexts(document);
  const session = new Session();
  /** @type {Panel[]} */
  const panels = [];

  /** @param {Document | Element} root @param {unknown} [model] what its panels watch */
  function adopt(root, model) {
    /** @type {Panel[]} */
    const found = [];
    for (const element of root.getElementsByTagName("*")) {
      if (!(element instanceof Panel)) continue; // the list is live: what a panel builds within itself comes next
      if ("watch" in element && typeof element.watch === "function") element.watch(model);
      element.join(session);
      found.push(element);
    }
    panels.push(...found);
    return found;
  }

  const shell = new Shell(session, adopt);
  adopt(document);
  begin(session, shell);
  redraw(session, panels, shell);
  addEventListener("keydown", takeComma);
  addEventListener("hashchange", enterByLink);
  for (const page of ["recordings", "maps"]) addEventListener(`show-${page}`, () => shell.go(page));
  addEventListener("pagehide", () => session.suspend());
  const enters = enterByLink();
  void shell.begin();
  if (!enters) void session.begin();
}

/**
 * Draw the panels with every state, at most once per frame of the screen, and every `SHOW_MS` without one.
 * @param {Session} session
 * @param {readonly Panel[]} panels those of a page come when it is opened
 * @param {Shell} shell
 */
function redraw(session, panels, shell) {
  let due = false;
  let shownAt = -Infinity;

  function show() {
    [due, shownAt] = [false, performance.now()];
    const { view } = session;
    document.body.classList.toggle("is-lost", !view.up);
    for (const panel of panels) if (shell.shows(panel) && !isPressed(panel)) panel.show(view);
  }

  session.on("heard", () => {
    if (!due) requestAnimationFrame(show);
    due = true;
  });
  setInterval(() => performance.now() - shownAt >= SHOW_MS && show(), SHOW_MS);
}
