// Pages of the shell, in the order of the menu: one row each. A module and its styles are loaded when its page is first opened.

import { t } from "../ui/texts.js";

/** @import { Session } from "../net/session.js" */
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
  { path: "", name: t("pages.drive"), icon: "wheel" },
  {
    path: "calibrate",
    name: t("pages.calibrate"),
    icon: "calibrate",
    says: t("pages.camera_laser_and_microphones_you_need"),
    styles: "page home setup board capture verdict progress views review evidence microphones"
      .split(" ")
      .map((name) => `calibration/${name}.css`),
    load: () => import("../calibration/main.js"),
  },
  {
    path: "hearing",
    name: t("pages.hearing"),
    icon: "ears",
    says: t("pages.how_well_the_robot_understands_what"),
    docked: true,
    drives: true,
    styles: ["hearing/quality.css"],
    load: () => import("../speech-quality/main.js"),
  },
  {
    path: "people",
    name: t("pages.people"),
    icon: "demo",
    says: t("pages.whom_the_robot_knows_and_whom"),
    docked: true,
    drives: true,
    styles: ["people/people.css"],
    load: () => import("../people/main.js"),
  },
  {
    path: "maps",
    name: t("pages.maps"),
    icon: "map",
    says: t("pages.saved_maps_and_the_present_one"),
    docked: true,
    styles: ["maps/maps.css"],
    load: () => import("../maps/main.js"),
  },
  {
    path: "recordings",
    name: t("pages.recordings"),
    icon: "tape",
    says: t("pages.drives_as_the_robot_sensed_them"),
    styles: ["recordings/recordings.css"],
    load: () => import("../recordings/main.js"),
  },
  {
    path: "experiments",
    name: t("pages.experiments"),
    icon: "estimate",
    says: t("pages.the_chapter_s_figures_and_tables"),
    styles: ["experiments/experiments.css"],
    load: () => import("../experiments/main.js"),
  },
  {
    path: "connect",
    name: t("pages.connect"),
    icon: "antenna",
    says: t("pages.what_was_found_on_the_robot"),
    styles: ["connect/connect.css"],
    load: () => import("../connect/main.js"),
  },
  {
    path: "help",
    name: t("pages.help"),
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
