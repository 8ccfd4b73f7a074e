// How every page begins: with the token of a printed link, or as who is known already.

/**
 * Begins the session, and enters again when a link with a token is followed later.
 * @param {import("./session.js").Session} session
 */
export function enter(session) {
  addEventListener("hashchange", enterByLink);
  if (!enterByLink()) void session.begin();
}

/** The token of the printed link: used at once, and wiped from the address before anything else can see it. */
function enterByLink() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return false;
  history.replaceState(null, "", location.pathname + location.search);
  void (/** @type {import("./panels/login-view.js").LoginView} */ (document.querySelector("login-view")).enter(token));
  return true;
}
