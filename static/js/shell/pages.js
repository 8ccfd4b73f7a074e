// Pages of the shell, in the order of the menu: one row each. A module and its styles are loaded when its page is first opened.

/** @typedef {import("../net/session.js").Session} Session */
/**
 * @typedef {object} OpenPage a page that was built
 * @property {HTMLElement} element with the page's own panels
 * @property {unknown} [model] what its panels watch
 * @property {() => void} [opened] called whenever the page is shown
 * @property {() => void} [left] called whenever another page is shown
 * @property {() => void} [moved] called when the hash of the address changes while the page is shown
 */
/**
 * @typedef {object} PageRow
 * @property {string} path below the root; "" is the console itself
 * @property {string} name
 * @property {string} icon
 * @property {string} [says] one sentence under the heading
 * @property {boolean} [docked] true: the live map and camera stay in sight
 * @property {boolean} [drives] true: without meaning for a robot that is only watched
 * @property {string[]} [styles] files of static/css
 * @property {() => Promise<{create: (session: Session) => OpenPage}>} [load]
 */

/** @type {readonly PageRow[]} */
export const PAGES = [
  { path: "", name: "Drive", icon: "wheel" },
  {
    path: "calibrate",
    name: "Calibrate",
    icon: "calibrate",
    says: "Camera, laser and microphones. You need a chessboard of known size, and your hands to clap; the page guides you.",
    styles: "page home setup board capture verdict progress views review evidence microphones"
      .split(" ")
      .map((name) => `calibration/${name}.css`),
    load: () => import("../calibration/main.js"),
  },
  {
    path: "hearing",
    name: "Hearing",
    icon: "ears",
    says: "How well the robot understands what is said to it where it stands.",
    docked: true,
    drives: true,
    styles: ["hearing/quality.css"],
    load: () => import("../speech-quality/main.js"),
  },
  {
    path: "people",
    name: "People",
    icon: "demo",
    says: "Whom the robot knows, and whom it comes to.",
    docked: true,
    drives: true,
    styles: ["people/people.css"],
    load: () => import("../people/main.js"),
  },
  {
    path: "maps",
    name: "Maps",
    icon: "map",
    says: "Saved maps, and the present one as files.",
    docked: true,
    styles: ["maps/maps.css"],
    load: () => import("../maps/main.js"),
  },
  {
    path: "experiments",
    name: "Experiments",
    icon: "estimate",
    says: "The chapter's figures and tables, computed again on this computer.",
    styles: ["experiments/experiments.css"],
    load: () => import("../experiments/main.js"),
  },
  {
    path: "connect",
    name: "Connect",
    icon: "antenna",
    says: "What was found on the robot, and its robot file.",
    styles: ["connect/connect.css"],
    load: () => import("../connect/main.js"),
  },
  {
    path: "help",
    name: "Help",
    icon: "book",
    styles: ["help/help.css"],
    load: () => import("../help/main.js"),
  },
];

/**
 * The page of an address: its last part, with or without ".html".
 * @param {string} pathname
 * @returns {PageRow | null} null: no page of the shell
 */
export function pageAt(pathname) {
  const last = pathname.slice(pathname.lastIndexOf("/") + 1).replace(/\.html$/, "");
  return PAGES.find(({ path }) => path === (last === "index" ? "" : last)) ?? null;
}
