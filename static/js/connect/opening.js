// Open a recording or a simulated robot instead of the console's robot; where the map is not saved, ask first.

import { post } from "../net/api.js";
import * as maps from "../net/maps-api.js";
import { make, mark } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";

/** @import { Session } from "../net/session.js" */

/** A name for a map that has none. @param {Date} now */
export const mapName = (now) => `map ${now.toLocaleString("sv").slice(0, 16).replace(":", "-")}`;

/** What a person calls it: the name of a recording, else its URL. @param {string} url */
export const nameOf = (url) => url.replace(/^log:(?:.*\/)?(.*?)(?:\.mcap)?$/, "$1");

/** URL of the robot that a recording was opened instead of; "" where none is known. */
export const robotBefore = () => remembered("robot", "");

/**
 * Open a URL: the console starts again with it, and so does the page. Throws with the reason where it did not open.
 * @param {Session} session
 * @param {string} url
 * @param {boolean} [plays] true: a recording plays as soon as the page shows it, else it waits for Play
 */
export async function openInstead(session, url, plays = false) {
  const [before, ends] = [session.hello?.console, new AbortController()];
  if (session.hello && session.hello.robot.kind !== "LOG") remember("robot", session.hello.robot.url);
  session.opening = url;
  /** @param {(heard: true) => void} then */
  const listen = (then) => session.on("heard", () => session.hello?.console !== before && then(true), ends);
  const again = new Promise(listen); // of the console that starts again, perhaps before it has answered
  try {
    const opened = await post("api/robot/open", { url });
    await again;
    if (session.hello?.robot.url === opened.url) {
      remember("plays", plays ? opened.url : "");
      return location.assign("./");
    }
    const why = session.state?.notices.findLast(({ level }) => level === "error")?.text;
    throw new Error(why ?? t("connection-model.url_did_not_open", { url }));
  } finally {
    session.opening = "";
    ends.abort();
  }
}

/** Save the map under its name, or a new one; back at the robot, it is offered. @param {Session} session */
export async function saveMap(session) {
  const known = session.state?.map?.name ?? null;
  const name = known ?? mapName(new Date());
  await maps.save(name, known !== null);
  remember("map-left", name);
}

/** Whether this recording was opened to be played, once. @param {string} url */
export function playsAtOnce(url) {
  const plays = remembered("plays", "") === url;
  remember("plays", "");
  return plays;
}

/** The map that was saved before a recording was opened, once; "" for none. */
export function mapLeft() {
  const name = remembered("map-left", "");
  remember("map-left", "");
  return name;
}

/**
 * Open, or ask first where the map would be lost.
 * @param {HTMLElement} question where it is asked
 * @param {Session} session
 * @param {{url: string, open: (save: boolean) => void, stay: () => void}} then
 */
export function askToOpen(question, session, { url, open, stay }) {
  if (!session.state?.map.unsaved) return open(false);
  /** @param {string} words @param {() => void} act @param {string} [look] */
  const choice = (words, act, look = "button") => {
    const onclick = () => {
      question.hidden = true;
      act();
    };
    return make("button", { class: look, onclick }, words);
  };
  const { name } = session.state.map;
  const sentence = name
    ? t("connect-robot.the_map_has_changed", { name, url: nameOf(url) })
    : t("connect-robot.your_map_is_not_saved", { url: nameOf(url) });
  const save = choice(t("connect-robot.save_and_open"), () => open(true), "button primary");
  mark(question, "aria-label", sentence);
  question.replaceChildren(
    make("p", sentence),
    save,
    choice(t("connect-robot.open_without_saving"), () => open(false)),
    choice(t("connect-robot.stay"), stay),
  );
  question.hidden = false;
  save.focus();
}
