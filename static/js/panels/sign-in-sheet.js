// Element <sign-in-sheet>: a link for a phone or another person, and the end of a login or a key.

import * as api from "../net/api.js";
import { make, nameField, onSubmit, svg, write } from "../ui/element.js";
import { date } from "../ui/format.js";
import { refill } from "../ui/press.js";
import { sure } from "../ui/row-question.js";
import { Sheet } from "../ui/sheet.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { KeyRow as Key, NewLink, SignedIn } from "../net/rest.js" */

const MARGIN = 4; // modules around a QR code, without which cameras miss it
/** @type {Record<string, string>} */
const KINDS = {
  start: t("sign-in-sheet.printed_at_a_start"),
  link: "link",
  file: t("sign-in-sheet.key_in_a_file"),
  program: "program",
};
/** @type {Record<string, string>} */
const LETS = { viewer: t("sign-in-sheet.who_opens_it_watches"), operator: t("sign-in-sheet.who_opens_it_drives") };
/** @type {Record<string, string>} */
const MAY = {
  viewer: t("sign-in-sheet.watches"),
  operator: t("sign-in-sheet.drives"),
  admin: t("sign-in-sheet.everything"),
};

export class SignInSheet extends Sheet {
  #name = nameField(t("sign-in-sheet.tablet"), { id: "link-name" });
  #drives = make("input", { type: "radio", name: "link-role", value: "operator" });
  #watches = make("input", { type: "radio", name: "link-role", value: "viewer", checked: true });
  #made = make("div.row.link-made", { hidden: true });
  #sessions = make("ul.sign-ins", { "aria-label": t("sign-in-sheet.signed_in") });
  #keys = make("ul.sign-ins", { "aria-label": t("sign-in-sheet.links_and_keys") });

  /** @override */
  build() {
    const form = make(
      "form.link-form",
      make("label", { for: "link-name" }, t("sign-in-sheet.a_link_for")),
      this.#name,
      make(
        "fieldset.link-role",
        make("legend.visually-hidden", t("sign-in-sheet.what_it_allows")),
        make("label", this.#watches, t("sign-in-sheet.to_watch_and_stop")),
        make("label", this.#drives, t("sign-in-sheet.to_drive")),
      ),
      make("button.button.primary", { type: "submit" }, t("sign-in-sheet.make_a_link")),
    );
    this.frame(
      t("sign-in-sheet.phones_and_sign_ins"),
      make(
        "div.sign-in-body",
        form,
        this.#made,
        make("h3.sign-in-title", t("sign-in-sheet.signed_in")),
        this.#sessions,
        make("h3.sign-in-title", t("sign-in-sheet.links_and_keys")),
        this.#keys,
      ),
    );
    onSubmit(form, () => void this.session.attempt(() => this.#makeLink()));
  }

  /** @override */
  toggle() {
    super.toggle();
    if (!this.hidden) void this.session.attempt(() => this.#fetch());
  }

  async #makeLink() {
    const role = this.#drives.checked ? "operator" : "viewer";
    /** @type {NewLink} */
    const { address, qr, note } = await api.makeLink(role, this.#name.value.trim());
    const box = make("input.field-box", { readonly: true, value: address, "aria-label": t("sign-in-sheet.link") });
    box.addEventListener("focus", () => box.select());
    const copy = make("button.button", { onclick: () => void this.#copy(box, copy) }, t("sign-in-sheet.copy"));
    refill(
      this.#made,
      drawn(qr),
      make(
        "div.link-words",
        make(
          "p",
          t("sign-in-sheet.value_lets_for_thirty_days", {
            value: note ? t("sign-in-sheet.open_it_in_another_browser") : t("sign-in-sheet.point_a_phone_s_camera_at"),
            lets: LETS[role],
          }),
        ),
        make("div.link-copy", box, copy),
        note &&
          make(
            "p.link-note",
            ...inLanguage(note)
              .split(/(--\w+)/)
              .map((part, n) => (n % 2 ? make("span", part) : part)),
          ),
      ),
    );
    this.#made.hidden = false;
    this.session.announce(t("sign-in-sheet.the_link_is_made"));
    await this.#fetch();
  }

  /** @param {HTMLInputElement} box @param {HTMLButtonElement} button */
  async #copy(box, button) {
    const copied = await navigator.clipboard?.writeText(box.value).then(
      () => true,
      () => false,
    );
    if (!copied) box.focus(); // it is selected, and the keys of the browser copy it
    write(button, copied ? t("sign-in-sheet.copied") : t("sign-in-sheet.selected"));
  }

  async #fetch() {
    /** @type {{sessions: SignedIn[], keys: Key[]}} */
    const { sessions, keys } = await api.signIns();
    const newest = (/** @type {{id: string}[]} */ rows) => rows.toReversed();
    refill(
      this.#sessions,
      .../** @type {SignedIn[]} */ (newest(sessions)).map((one) => {
        const here = one.yours
          ? t("sign-in-sheet.you")
          : one.present
            ? t("sign-in-sheet.page_open")
            : t("sign-in-sheet.no_page_open");
        const end = () => api.endSession(one.id);
        return this.#row(one, `${MAY[one.role]} · ${here}`, t("sign-in-sheet.sign_out"), one.yours ? null : end);
      }),
    );
    refill(
      this.#keys,
      .../** @type {Key[]} */ (newest(keys)).map((one) => {
        const about = `${MAY[one.role]} · ${KINDS[one.kind]} · ${until(one.end_s)}`;
        return this.#row(one, about, t("sign-in-sheet.revoke"), () => api.revokeKey(one.id));
      }),
    );
    if (!sessions.length) this.#sessions.append(make("li.note", t("sign-in-sheet.nobody_by_a_page")));
  }

  /**
   * @param {{name: string}} one
   * @param {string} about
   * @param {string} does
   * @param {(() => Promise<unknown>) | null} end null: not from here
   */
  #row(one, about, does, end) {
    const button = make("button.button", { "aria-label": `${does} ${one.name}` }, does);
    button.addEventListener("click", () => {
      if (!sure(button, t("sign-in-sheet.really"))) return;
      void this.session.attempt(async () => {
        await end?.();
        await this.#fetch();
      });
    });
    const words = make("span.sign-in-words", make("b", one.name), make("span.note", about));
    return make("li", words, end && button);
  }
}

/** Draw a QR code, dark on white in every theme. @param {string[]} rows "1" dark */
function drawn(rows) {
  const size = rows.length + 2 * MARGIN;
  const path = rows
    .flatMap((row, y) => [...row].map((module, x) => (module === "1" ? `M${x + MARGIN} ${y + MARGIN}h1v1h-1z` : "")))
    .join("");
  const code = svg("svg", {
    viewBox: `0 0 ${size} ${size}`,
    class: "qr",
    role: "img",
    "aria-label": t("sign-in-sheet.qr_code_of_the_link"),
  });
  code.append(svg("rect", { width: size, height: size, fill: "#fff" }), svg("path", { d: path, fill: "#000" }));
  return code;
}

/** @param {number | null} end Unix time */
function until(end) {
  if (end === null) return t("sign-in-sheet.until_revoked");
  return t("sign-in-sheet.until_date", { date: date(end) });
}

customElements.define("sign-in-sheet", SignInSheet);
