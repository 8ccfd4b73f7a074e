// Element <uploads-card>: result of each uploaded file.

import { icon, isNew, make, write } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { grouped } from "./uploads.js";

/** @import { Uploads } from "./uploads.js" */

const NAMED_FILES = 3; // of a row; more are counted

const ICONS = /** @type {Readonly<Record<string, string>>} */ ({ counted: "done", same: "again", nothing: "eye" });

export class UploadsCard extends HTMLElement {
  #title = make("h2.card-title");
  #list = make("ul.attempts");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(make("div.card-head", this.#title), this.#list);
  }

  /** @param {Uploads} uploads */
  show({ attempts, waiting }) {
    this.hidden = attempts.length + waiting === 0;
    if (!isNew(this, attempts.length, waiting)) return;
    const taken = attempts.filter(({ kind }) => kind === "counted").length;
    write(
      this.#title,
      waiting
        ? t("uploads-card.waiting_filevalue_to_go", { waiting, value: waiting === 1 ? "" : "s" })
        : t("uploads-card.taken_of_length_files_counted", { taken, length: attempts.length }),
    );
    this.#list.replaceChildren(
      ...grouped(attempts).map(({ names, kind, words }) =>
        make(
          "li.attempt",
          { "data-kind": kind },
          icon(ICONS[kind] ?? "refused"),
          make(
            "span",
            make("span.attempt-name", { title: names.join(", ") }, namesIn(names)),
            make("span.note", words),
          ),
        ),
      ),
    );
  }
}

/** @param {string[]} names newest first */
function namesIn(names) {
  const more = names.length - NAMED_FILES;
  const named = names.slice(0, NAMED_FILES).join(", ");
  return more > 0 ? t("uploads-card.names_and_more", { named, more }) : named;
}

customElements.define("uploads-card", UploadsCard);
