// Element <command-line>: text box for commands with completion and recall.

import { Recall, suggest } from "../drive/suggest.js";
import { wordsOf } from "../net/api.js";
import { kindsOf, marksOf } from "../net/marks-api.js";
import { icon, make, mark, onSubmit } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { mayBegin } from "../ui/pending-command.js";
import { t } from "../ui/texts.js";

/** @import { Suggestion } from "../drive/suggest.js" */
/** @import { View } from "../net/session.js" */
/** @import { Transcript } from "../voice/audio-socket.js" */

const HEARD_MS = 6000; // for which words that were heard stay in the box

const ASK = t("command-line.tell_it_what_to_do");
const ASK_SHORT = t("command-line.short_hint");
const WIDE_PX = 240; // of the box, from which it holds the longer one

export class CommandLine extends Panel {
  #box = make("input.words", {
    id: "words",
    type: "text",
    maxlength: "200",
    autocomplete: "off",
    autocapitalize: "off",
    spellcheck: "false",
    enterkeyhint: "send",
    placeholder: ASK,
    "aria-label": t("command-line.tell_the_robot_what_to_do"),
    role: "combobox",
    "aria-autocomplete": "list",
    "aria-expanded": "false",
    "aria-controls": "suggestions",
    "aria-keyshortcuts": "/",
  });
  #send = make("button.button.primary.send", { type: "submit", "aria-label": t("command-line.send") }, icon("send"));
  #list = make("ul.suggestions", {
    id: "suggestions",
    role: "listbox",
    "aria-label": t("command-line.suggestions"),
    hidden: true,
  });
  #recall = new Recall();
  /** @type {Suggestion[]} */
  #offered = [];
  #chosen = -1;
  #asked = false;
  #heard = ""; // transcript in the box, while it is unchanged
  #away = 0;

  /** @override */
  build() {
    const form = make("form.line", this.#box, make("kbd.slash", { "aria-hidden": "true" }, "/"), this.#send);
    this.append(this.#list, form);
    onSubmit(form, () => void this.#say());
    this.#box.addEventListener("input", () => {
      this.#recall.leave();
      this.#note("");
      this.#offer();
    });
    this.#box.addEventListener("keydown", (event) => this.#key(event));
    this.#box.addEventListener("blur", () => this.#shut());
    this.session.on("transcript", (transcript) => this.#hear(transcript));
    this.session.on("interrupt", () => this.#heard && this.#empty()); // a person speaks again
    this.session.on("history", (rows) => {
      if (this.#asked) return;
      this.#asked = true;
      for (const row of [...rows].reverse()) this.#recall.add(wordsOf(row));
    });
  }

  take() {
    this.#box.focus();
    this.#box.select();
  }

  /** @override @param {View} view */
  show({ up, permission }) {
    const off = !up || permission.may === "no";
    mark(this.#box, "aria-disabled", up ? null : "true");
    this.#send.disabled = !up; // without control "stop" still works; other commands are refused with the reason
    const hint = off ? permission.why : this.#box.clientWidth < WIDE_PX ? ASK_SHORT : ASK;
    if (this.#box.placeholder !== hint) this.#box.placeholder = hint;
  }

  /**
   * Put a transcript into the box, unless the operator is typing; refused words can be corrected there.
   * @param {Transcript} transcript
   */
  #hear({ words, heard_as, accepted, overtaken }) {
    const text = accepted ? heard_as : words;
    if (!text || overtaken || (this.#box.value && this.#box.value !== this.#heard)) return;
    this.#box.value = text;
    this.#note(text);
    this.#shut();
    if (!accepted) return;
    this.#recall.add(text);
    this.#away = setTimeout(() => this.#heard === text && this.#empty(), HEARD_MS);
  }

  /** @param {string} heard */
  #note(heard) {
    clearTimeout(this.#away);
    this.#heard = heard;
    mark(this.#box, "data-heard", heard !== "");
  }

  #empty() {
    if (this.#box.value === this.#heard) this.#box.value = "";
    this.#note("");
  }

  async #say() {
    const waiting = mayBegin(this.session.view);
    if (waiting && this.#box.value === this.#heard && this.#chosen < 0) {
      await this.session.pendingCommand("begin", waiting.id); // an empty box, or the words of the pending command
      return;
    }
    const chosen = this.#offered[this.#chosen];
    if (chosen && this.#box.value !== chosen.text) {
      this.#accept(chosen);
      if (!chosen.complete) return;
    }
    /** @type {HTMLElement | null} */
    const meant = document.querySelector("command-status [data-enter]");
    if (!this.#box.value && meant?.checkVisibility({ checkVisibilityCSS: true })) {
      meant.click();
      return;
    }
    const text = this.#box.value.replace(/^[\s/]+/, "").trim(); // "/" leads here, and may be typed once more
    if (!text || this.#send.disabled) return;
    this.#recall.add(text);
    this.#box.value = "";
    this.#note("");
    this.#shut();
    const answer = await this.session.say(text, "typed");
    if (answer.status === 0 && !this.#box.value) this.#box.value = text;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const back = event.key === "ArrowUp";
    if (event.key === "Escape") this.#box.blur(); // keys drive again
    if (event.key === "Enter" && event.repeat) event.preventDefault(); // a key that is held sends once
    if (!back && event.key !== "ArrowDown") return;
    event.preventDefault();
    const recalling = this.#recall.walking || (back && this.#box.value === "");
    if (recalling) {
      this.#box.value = back ? this.#recall.older(this.#box.value) : this.#recall.newer();
      this.#shut();
    } else if (this.#offered.length === 0 || this.#list.hidden) {
      this.#offer(true);
    } else {
      const count = this.#offered.length;
      this.#choose(this.#chosen < 0 ? (back ? count - 1 : 0) : (this.#chosen + (back ? count - 1 : 1)) % count);
    }
  }

  /** @param {boolean} [evenIfEmpty] */
  #offer(evenIfEmpty = false) {
    const text = this.#box.value;
    const offered =
      text.trim() || evenIfEmpty
        ? suggest(text, [...this.session.kinds, ...kindsOf(marksOf(this.session).places)])
        : [];
    this.#offered = offered.filter((suggestion) => suggestion.text !== text.trim());
    this.#chosen = -1;
    this.#list.replaceChildren(
      ...this.#offered.map((suggestion, index) => {
        const row = make(
          "li.suggestion",
          { id: `suggestion-${index}`, role: "option", "aria-selected": "false" },
          make("span.suggestion-words", suggestion.complete ? suggestion.text : suggestion.shows),
          make("span.note", suggestion.summary),
        );
        row.addEventListener("pointerdown", (event) => {
          event.preventDefault();
          this.#accept(suggestion);
          if (suggestion.complete) void this.#say();
        });
        return row;
      }),
    );
    this.#list.hidden = this.#offered.length === 0;
    mark(this.#box, "aria-expanded", String(!this.#list.hidden));
    mark(this.#box, "aria-activedescendant", null);
  }

  /** @param {number} index */
  #choose(index) {
    this.#chosen = index;
    for (const [other, row] of [...this.#list.children].entries()) mark(row, "aria-selected", String(other === index));
    mark(this.#box, "aria-activedescendant", `suggestion-${index}`);
  }

  /** @param {Suggestion} suggestion */
  #accept(suggestion) {
    this.#box.value = suggestion.text;
    this.#box.setSelectionRange(suggestion.caret, suggestion.caret);
    this.#shut();
  }

  #shut() {
    this.#list.hidden = true;
    this.#offered = [];
    this.#chosen = -1;
    mark(this.#box, "aria-expanded", "false");
    mark(this.#box, "aria-activedescendant", null);
  }
}

customElements.define("command-line", CommandLine);
