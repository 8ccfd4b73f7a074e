// Start of every page: sign in with the token of a printed link, or with the existing session.

/**
 * Begin the session, and sign in again when a link with a token is opened later.
 * @param {import("../net/session.js").Session} session
 */
export function enter(session) {
  addEventListener("hashchange", enterByLink);
  if (!enterByLink()) void session.begin();
}

/** Token of the printed link: used at once, and removed from the address. */
function enterByLink() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return false;
  history.replaceState(null, "", location.pathname + location.search);
  void (/** @type {import("../panels/login-view.js").LoginView} */ (document.querySelector("login-view")).enter(token));
  return true;
}
