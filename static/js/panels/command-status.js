// Element <command-status>: status line with the running command, the newest result or refusal.
// Element <command-chain>: what of a person the robot has by each sense while it comes or follows.

import { wordsOf } from "../net/api.js";
import { steerRoute } from "../net/marks-api.js";
import * as room from "../net/room-api.js";
import { icon, iconButton, isNew, make, mark, redraw, write } from "../ui/element.js";
import { degrees, inWords, metres, share } from "../ui/format.js";
import { couldCall, goesToPerson, isEmptyRoom, letCall } from "../ui/let-call.js";
import { meter } from "../ui/meter.js";
import { Panel } from "../ui/panel.js";
import { SPOKEN } from "../ui/pending-command.js";
import { CommandVoice, chainOf, LastVoice } from "../ui/sensed.js";
import { StatusLog } from "../ui/status.js";
import { t } from "../ui/texts.js";
import { ToGo } from "../ui/to-go.js";
import { asking } from "./lease-chip.js";
import { routeWords } from "./route-card.js";

/** @import { HistoryRow } from "../net/rest.js" */
/** @import { Said, View } from "../net/session.js" */
/** @import { StatusLine } from "../ui/status.js" */

const ARRIVED_M = 0.1;
const STEPS = /** @type {const} */ (["heard", "seen", "laser", "coming"]);

class CommandChain extends Panel {
  #voice = new LastVoice();
  #itsVoice = new CommandVoice();
  #list = make("ol.chain", { "aria-label": t("command-chain.what_the_robot_has_of_the") });
  #steps = STEPS.map((step) => {
    const [words, says, sd] = [make("span.chain-more"), make("span"), make("span.chain-more")];
    const name = make("b", t(`command-chain.${step}`));
    const row = make("li.chain-step", { "data-step": step }, name, words, says, sd);
    this.#list.append(row);
    return { row, name, words, says, sd };
  });

  /** @override */
  build() {
    this.hidden = true;
    this.append(this.#list);
  }

  /** @override @param {View} view */
  show({ state }) {
    const voice = state ? this.#voice.saw(state) : null; // remembered before a command begins
    const chain = state ? chainOf(state, this.#itsVoice.of(state, voice), this.session.kinds) : null;
    this.hidden = chain === null;
    if (!chain) return;
    const command = state?.command;
    const said = command && SPOKEN.includes(command.source) ? `“${command.heard_as}”` : "";
    const before = chain.looks ? t("command-chain.looking") : t("command-chain.not_yet");
    const says = [
      chain.heard ? inWords(chain.heard.azimuth) : said ? "" : t("command-chain.no_voice"),
      chain.seen === null
        ? chain.found
          ? t("command-chain.no_whole_person")
          : before
        : `${chain.seen.name} ${chain.seen.value === null ? t("command-chain.yes") : share(chain.seen.value)}`.trim(),
      chain.laser !== null ? metres(chain.laser, 1) : chain.found ? t("command-chain.no_legs") : before,
      chain.left === null
        ? t("command-chain.not_yet")
        : t("command-chain.metres_to_go", { metres: metres(chain.left, 1) }),
    ];
    const follows = command?.name === "follow_me";
    const [heard, coming] = [this.#steps.at(0), this.#steps.at(-1)];
    if (heard) write(heard.words, said);
    if (heard) write(heard.sd, chain.heard ? `± ${degrees(chain.heard.sd)}` : "");
    if (coming) write(coming.name, t(follows ? "command-chain.following" : "command-chain.coming"));
    if (follows && chain.left !== null && chain.left < ARRIVED_M) says[3] = t("command-chain.at_its_distance");
    const lit = [chain.heard !== null, chain.seen !== null, chain.laser !== null, chain.left !== null];
    for (const [index, { row, says: place }] of this.#steps.entries()) {
      write(place, says[index] ?? "");
      mark(row, "data-lit", lit[index] === true);
    }
  }
}

customElements.define("command-chain", CommandChain);

const POINT = matchMedia("(pointer: coarse)").matches ? t("command-status.tap") : t("command-status.click");
/** @type {StatusLine} */
const READY = {
  icon: "command",
  words: t("command-status.ready"),
  remark: t("command-status.type_press_a_button_below_or", { point: POINT }),
  state: "",
  suggestions: [],
};
const OFFERED = 3;
const ENTER_MS = 500; // a key that was pressed twice by mistake, or is held, sends nothing
const STAYS = ["refused", "failed"]; // for a while; who has read it dismisses it
/** Codes of refusals that say themselves what the offered commands are. */
const OFFERING = ["words.unknown", "words.unknown_like", "words.did_you_mean", "places.other", "places.others"];
const GETTING_READY = t("command-status.getting_the_ears_ready");

class CommandStatus extends Panel {
  #icon = icon("command");
  #words = make("span.status-words");
  #remark = make("span.status-remark");
  #left = make("span.status-left");
  #level = make("span.status-level", { "aria-hidden": "true", hidden: true });
  #suggestions = make("div.row.suggested", { role: "group", "aria-label": t("command-status.did_you_mean") });
  #progress = meter("div.meter.progress", { role: "progressbar", "aria-label": t("command-status.progress") });
  #dismiss = iconButton("close", t("notice-toasts.dismiss"), () => this.#leave(), { look: "small status-dismiss" });
  #endWords = make("span");
  #end = make("button.button", { hidden: true }, icon("close"), this.#endWords);
  #ends = false; // the route, and not a command alone
  #steerWords = make("span");
  #steer = make("button.button", { hidden: true }, this.#steerWords);
  #log = new StatusLog();
  #toGo = new ToGo();

  /** @override */
  build() {
    this.append(
      this.#icon,
      make("p.status-text", this.#words, this.#remark),
      this.#level,
      this.#suggestions,
      this.#progress.element,
      this.#left,
      this.#steer,
      this.#dismiss,
      this.#end,
    );
    this.#end.addEventListener("click", () => {
      this.session.stop();
      if (this.#ends) void this.session.attempt(() => steerRoute("stop"));
    });
    this.#steer.addEventListener("click", () => {
      const paused = this.session.state?.route?.state === "paused";
      void this.session.attempt(() => steerRoute(paused ? "resume" : "pause"));
    });
    this.session.on("said", (said) => this.#answered(said));
    this.session.on("transcript", (transcript) => this.#log.heard(transcript, performance.now()));
    this.session.on("reading", (words) => this.#log.reads(performance.now(), words));
    this.session.on("so-far", (words) => this.#log.readsSoFar(words));
    this.session.on("read", () => this.#log.wasRead(performance.now()));
    this.session.on("hearing", (hearing) => {
      this.#log.listens(hearing?.words ?? null, performance.now());
      this.#level.hidden = hearing === null;
      this.#level.style.setProperty("--level", String(hearing?.level ?? 0));
    });
    this.session.on("stopped", (sent) => this.#log.stopped(sent, performance.now()));
    this.session.on("heard", (view) => this.#log.saw(view, performance.now()));
    this.session.on("history", (rows) => this.#ended(rows));
  }

  /** @override @param {View} view */
  show(view) {
    const now = performance.now();
    this.#log.saw(view, now);
    const { state, up, permission } = view;
    const command = state?.command?.state === "running" ? state.command : null;
    const route = command && command.source !== "route" ? null : routeUnderWay(state);
    this.#end.hidden = !command && !route;
    this.#end.disabled = !up;
    this.#ends = route !== null;
    write(this.#endWords, route ? t("route-card.end") : t("command-status.cancel_command"));
    mark(this.#end, "title", route ? t("command-status.ends_the_route") : t("command-status.ends_this_command"));
    this.#steer.hidden = !route || view.hello?.you.role === "viewer"; // who may stop it, and no more
    this.#steer.disabled = !up;
    write(this.#steerWords, route?.state === "paused" ? t("route-card.go_on") : t("route-card.pause"));
    this.#progress.element.hidden = !command || command.progress === null;
    const left = state ? this.#toGo.saw(state, view.hello?.robot.cruise_m_s ?? 0) : [];
    this.#left.hidden = left.length === 0 || !command;
    if (left.length) write(this.#left, t("command-status.join_to_go", { join: left.join(", ") }));
    if (command) this.#progress.set(command.progress ?? 0);
    const ready = state?.ears?.starting ? { ...READY, remark: GETTING_READY } : READY;
    let line = this.#log.line(view, now, ready);
    if (state?.pending_command && line.state === "refused") {
      this.#log.dismiss(); // what follows it is asked about now
      line = this.#log.line(view, now, ready);
    }
    const offered = (line.room && state?.ears?.suggested_commands) || line.suggestions;
    const refused = line.state === "" || line.state === "refused";
    const late = line.state === "refused" ? (state?.late_command ?? null) : null;
    if (late && permission.may !== "no") this.#offerLate(line, late);
    else if (permission.held && refused && !offered.length) this.#offerControl(line, view);
    else if (route?.state === "paused" && line.state !== "refused")
      this.#show({ ...line, icon: "pause", words: routeWords(route), remark: route.reason, state: "paused" });
    else if (route && ["", "running", "done"].includes(line.state))
      this.#show({ ...line, icon: "running", words: routeWords(route), remark: route.reason, state: "running" });
    else this.#show({ ...line, suggestions: offered });
  }

  /** @param {Said} said */
  #answered(said) {
    this.#log.answered(said, performance.now());
    if (!said.answer.ok)
      this.session.announce(
        t("command-status.text_refused_detail", { text: said.text, detail: said.answer.detail ?? "" }),
      );
  }

  /** @param {HistoryRow[]} rows newest first */
  #ended(rows) {
    for (const row of this.#log.ended(rows, this.session.historyAt, performance.now()))
      this.session.announce(`${wordsOf(row)}: ${t(`state.${row.state}`)}. ${row.remark}`);
  }

  /** Whether other suggestions are to be drawn. @param {string} key of what is suggested; "": nothing */
  #offers(key) {
    this.#suggestions.hidden = key === "";
    return isNew(this.#suggestions, key);
  }

  /** @param {StatusLine} line */
  #write(line) {
    redraw(this.#icon, line.icon);
    write(this.#words, line.words);
    write(this.#remark, line.remark);
    mark(this, "data-state", line.state || null);
    this.#dismiss.hidden = !STAYS.includes(line.state) || !this.#end.hidden;
  }

  #leave() {
    this.#log.dismiss();
    this.show(this.session.view);
  }

  /**
   * Offer to begin what was refused only because it came late.
   * @param {StatusLine} line
   * @param {import("../net/messages.js").LateCommandState} late
   */
  #offerLate(line, late) {
    this.#write(line);
    const same = line.words.toLowerCase() === late.heard_as.toLowerCase();
    const key = `late ${late.id} ${same}`;
    if (!this.#offers(key)) return;
    const now = make(
      "button.chip",
      icon("again"),
      same ? t("command-status.do_it_now") : t("command-status.do_words_now", { words: late.heard_as }),
    );
    now.addEventListener("click", () => {
      now.disabled = true;
      void this.session.pendingCommand("begin", late.id).finally(() => (now.disabled = false));
    });
    this.#suggestions.replaceChildren(now);
  }

  /** @param {StatusLine} line @param {View} view */
  #offerControl(line, { state, hello }) {
    if (!state || !hello) return;
    const { holder, asked_by: asked } = state.lease;
    const words = line.state ? line.remark : t("command-status.holder_drives", { holder });
    const answer = asked ? asking(state.lease, hello.you.id) : "";
    this.#write({ ...line, remark: answer ? `${words} ${answer}.` : words, state: line.state || "held" });
    if (!this.#offers(`control ${asked}`)) return;
    const ask = make("button.chip", { disabled: asked !== null }, t("lease-chip.ask_for_control"));
    const take = make("button.chip", { onclick: () => void this.session.lease("take") }, t("lease-chip.take_over"));
    ask.addEventListener("click", () => void this.session.lease("ask"));
    this.#suggestions.replaceChildren(ask, take);
  }

  /** @param {StatusLine} line */
  #show(line) {
    this.#write(line);
    const suggestions = line.suggestions.slice(0, OFFERED);
    const mine = line.state === "refused" && !line.room; // words of the room are pressed, or said again
    const unheard = line.state === "refused" && goesToPerson(this.session, line.words);
    const caller = unheard ? couldCall() : "";
    const empty = unheard && isEmptyRoom();
    const key = caller ? `${caller}: ${line.words}` : empty ? "nobody" : suggestions.join("|");
    if (!this.#offers(key)) return;
    if (caller) this.#suggestions.replaceChildren(letCall(caller, line.words), howItWorks());
    else if (empty) this.#suggestions.replaceChildren(this.#addPerson(), howItWorks());
    else
      this.#suggestions.replaceChildren(
        ...(OFFERING.includes(line.code ?? "") ? [] : [make("span.note", t("command-status.did_you_mean"))]),
        ...suggestions.map((text) => this.#suggestion(text, mine && suggestions.length === 1)),
      );
  }

  /** @param {string} text @param {boolean} only what Enter sends while nothing is typed: see command-line */
  #suggestion(text, only) {
    const look = only ? "button.button.primary" : "button.chip";
    const button = make(look, { onclick: () => void this.session.say(text, "chip") }, text);
    if (only) {
      button.setAttribute("aria-keyshortcuts", "Enter");
      setTimeout(() => mark(button, "data-enter", true), ENTER_MS);
    }
    return button;
  }

  /** In an empty simulated room: someone to come to. */
  #addPerson() {
    const button = make("button.chip", icon("demo"), t("command-status.add_a_person"));
    button.addEventListener("click", () => {
      const pose = this.session.state?.pose;
      if (pose) void this.session.attempt(() => room.add(pose));
    });
    return button;
  }
}

/** The route that goes on by itself, or by a press. @param {import("../net/messages.js").State | null} state */
const routeUnderWay = (state) =>
  state?.route && ["driving", "waiting", "paused"].includes(state.route.state) ? state.route : null;

const howItWorks = () => make("a.chip", { href: "help#how-to/call-the-robot.md" }, t("command-status.how_it_works"));

customElements.define("command-status", CommandStatus);
