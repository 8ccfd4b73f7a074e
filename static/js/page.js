// Start of every page: theme, common panels, session, redrawing, and sign-in by a printed link.

import "./ui/theme.js";
import "./panels/banner-stack.js";
import "./panels/link-chip.js";
import "./panels/live-region.js";
import "./panels/login-view.js";
import "./panels/notice-toasts.js";
import "./panels/stop-button.js";
import "./panels/theme-toggle.js";
import { stopByKeys } from "./drive/stop-keys.js";
import { Session } from "./net/session.js";
import { Panel } from "./ui/panel.js";

const SHOW_MS = 200; // ages grow without news, and a browser that draws slowly must not keep quiet about it

/**
 * Join the panels of the document to a new session, keep them drawn, and sign in. Import the page's own panels first.
 *
 * The page stops the robot by keys, unless `begin` returns true because it has driving keys of its own.
 * @template [M=undefined]
 * @param {object} options
 * @param {(session: Session) => M} [options.model] what the page's own panels watch
 * @param {(session: Session, model: M) => boolean | void} [options.begin] called once, before the first message
 */
export function startPage({ model: create, begin }) {
  const session = new Session();
  const model = /** @type {M} */ (create?.(session));
  const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
  for (const panel of panels) {
    if ("watch" in panel && typeof panel.watch === "function") panel.watch(model);
    panel.join(session);
  }
  if (!begin?.(session, model)) stopByKeys(session);
  redraw(session, panels);
  addEventListener("hashchange", enterByLink);
  if (!enterByLink()) void session.begin();
}

/**
 * Draw the panels with every state, at most once per frame of the screen, and every `SHOW_MS` without one.
 * @param {Session} session
 * @param {Panel[]} panels
 */
function redraw(session, panels) {
  let shown = -1;
  let shownAt = -Infinity;

  function show() {
    [shown, shownAt] = [session.seen, performance.now()];
    const { view } = session;
    document.body.classList.toggle("is-lost", !view.up);
    for (const panel of panels) panel.show(view);
  }

  function beat() {
    requestAnimationFrame(beat);
    if (session.seen !== shown) show();
  }

  requestAnimationFrame(beat);
  setInterval(() => performance.now() - shownAt >= SHOW_MS && show(), SHOW_MS);
}

/** Use the token of a printed link at once, and remove it from the address. */
function enterByLink() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return false;
  history.replaceState(null, "", location.pathname + location.search);
  void (/** @type {import("./panels/login-view.js").LoginView} */ (document.querySelector("login-view")).enter(token));
  return true;
}
