// Element <map-card>: save the map, load a saved map, download map files.

import { address, wordedPath } from "../net/api.js";
import * as maps from "../net/maps-api.js";
import { icon, iconButton, make, nameField, onSubmit, write } from "../ui/element.js";
import { day, fixed } from "../ui/format.js";
import { AGAIN_MS } from "../ui/page-model.js";
import { Panel } from "../ui/panel.js";
import { refill } from "../ui/press.js";
import { confirmIn, questionIn } from "../ui/row-question.js";
import { language, t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { View } from "../net/session.js" */
/** @import { SavedMapRow as SavedMap } from "../net/rest.js" */

const ITSELF = "Beckon"; // who keeps a map of its own accord
const FILES = /** @type {const} */ ([
  ["api/map", t("map-card.map"), t("map-card.nav2_yaml_and_pgm")],
  ["api/map.png", t("map-card.picture"), "PNG"],
  [wordedPath("api/map.pdf"), t("map-card.plan"), t("map-card.pdf_to_print")],
  [wordedPath("api/map.svg"), t("map-card.drawing"), "SVG"],
  [wordedPath("api/reports/map"), t("map-card.report"), t("map-card.html_to_print")],
  [wordedPath("api/reports/drive"), t("map-card.drive"), t("map-card.report_of_the_drive")],
  ["api/landmarks.csv", t("map-card.landmarks"), "CSV"],
  ["api/trajectory.tum", t("map-card.trajectory"), "TUM"],
]);

const [SHEET_MM, LETTER_PX] = [297, 13.5]; // width of the plan; height of its words as they are shown

class MapCard extends Panel {
  #now = make("p.map-now");
  #name = nameField(t("map-card.name_of_this_map"));
  #saveWords = make("span", t("map-card.save"));
  #save = make("button.button.primary", { type: "submit" }, icon("save"), this.#saveWords);
  #form = make("form.map-form", this.#name, this.#save);
  #trouble = new TroubleLine(this.#name);
  #placed = make("p.note", { role: "status" }); // below the map that was loaded
  #loaded = "";
  #list = make("ul.maps", { "aria-label": t("map-card.saved_maps_newest_first") });
  #empty = make("p.note.map-empty", t("map-card.no_map_is_saved_yet"));
  #sheet = make("img.map-sheet", { alt: t("map-card.the_present_map_as_a_plan"), hidden: true });
  /** @type {SavedMap[]} */
  #maps = [];
  #revision = -1;
  #letter = 0; // [mm] of the plan's words
  /** @type {string | null} */
  #current = null;
  #operates = false;
  #busy = false;
  #saving = false;

  /** @override */
  build() {
    const files = FILES.map(([path, name, says]) =>
      make(
        "a.map-file",
        { href: address(path).href, download: "" },
        icon("download"),
        make("span", name),
        make("span.note", says),
      ),
    );
    const downloads = make("div.inline.slam-head", make("h3", t("map-card.downloads")));
    this.append(
      make(
        "section.map-present",
        { "aria-label": t("main.present_map") },
        this.#sheet,
        make(
          "div.map-keep",
          this.#now,
          this.#form,
          this.#trouble.element,
          this.closest(".page") && make("a.link.map-to-edit", { href: "#edit" }, t("map-editor.edit_the_map")),
        ),
        make("div.map-take", downloads, make("div.map-files", ...files)),
      ),
      make(
        "section.map-saved",
        { "aria-label": t("map-card.saved_maps") },
        make("div.inline.slam-head", make("h3", t("map-card.saved_maps"))),
        this.#empty,
        this.#list,
      ),
    );
    for (const event of ["load", "error"])
      this.#sheet.addEventListener(event, () => (this.#sheet.hidden = event === "error")); // nothing is known yet
    new ResizeObserver(() => {
      const { clientWidth: wide } = this.#sheet;
      if (wide && this.#letter && this.#letter * wide < LETTER_PX * SHEET_MM) this.#readSheet();
    }).observe(this.#sheet);
    onSubmit(this.#form, () => void this.#keep());
    this.#name.addEventListener("input", () => this.#trouble.say(""));
    this.session.on("hello", () => (this.#revision = -1));
  }

  /** What it costs to load another map. */
  #loses() {
    return this.session.state?.map.unsaved
      ? t("map-card.unsaved_changes_of_the_present_map")
      : t("map-card.the_present_map_is_saved");
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state || !hello) return;
    this.#operates = up && hello.you.role !== "viewer";
    this.#form.hidden = hello.you.role === "viewer";
    const { name, revision } = state.map;
    const text = name === null ? t("map-card.this_map_is_not_saved") : t("map-card.this_is_the_map_name", { name });
    write(this.#now, text);
    write(
      this.#placed,
      state.floor.lost
        ? t("map-card.loaded_the_robot_looks_for_its_place")
        : t("map-card.loaded_the_robot_knows_its_place"),
    );
    for (const button of this.querySelectorAll("button")) button.disabled = !this.#operates || this.#busy;
    const words = this.#replaces ? t("map-card.replace") : t("map-card.save");
    write(this.#saveWords, this.#saving ? t("trouble-line.saving") : words);
    if (name !== this.#current) {
      this.#current = name;
      if (name !== null) this.#name.value = name;
      this.#draw();
    }
    if (revision === this.#revision || this.#now.offsetParent === null) return;
    this.#revision = revision;
    if (this.closest(".page")) {
      this.#sheet.hidden = false; // its room is kept before it is there: what is drawn beside it must not move
      this.#readSheet();
    }
    void this.#fetch();
  }

  /** The plan, with letters that can be read as wide as it is shown. */
  #readSheet() {
    const { clientWidth: wide } = this.#sheet;
    if (!wide) return;
    this.#letter = Math.ceil((2 * LETTER_PX * SHEET_MM) / wide) / 2;
    const query = new URLSearchParams({
      letter_mm: String(this.#letter),
      of: String(Math.round(performance.now())),
      language,
    });
    this.#sheet.src = address(`api/map.svg?${query}`).href;
  }

  /** True where the name is that of a saved map. */
  get #replaces() {
    return this.#maps.some((map) => map.name.toLowerCase() === this.#name.value.trim().toLowerCase());
  }

  async #fetch() {
    const read = await this.#trouble.read(async () => {
      this.#maps = await maps.list(); // the buttons stay: one may be pressed just now
      this.#draw();
    });
    if (!read) setTimeout(() => (this.#revision = -1), AGAIN_MS); // with the next state once more
  }

  async #keep() {
    const name = this.#name.value.trim();
    const trouble = maps.nameTrouble(name);
    if (trouble) {
      this.#trouble.say(trouble);
      this.#name.focus();
      return;
    }
    const replace = this.#replaces;
    this.#saving = true;
    write(this.#saveWords, t("trouble-line.saving"));
    await this.#try(async () => {
      const kept = await maps.save(name, replace);
      this.session.announce(t("map-card.the_map_name_is_saved", { name: kept.name }));
    });
    this.#saving = false;
  }

  #draw() {
    if (this.#list.querySelector(".map-question")) return; // it would take the question away
    this.#empty.hidden = this.#maps.length > 0;
    refill(this.#list, ...this.#maps.map((map) => this.#row(map)));
  }

  /** @param {SavedMap} map */
  #row(map) {
    const size = `${fixed(map.width_m, 1)} × ${fixed(map.height_m, 1)} m`;
    const rooms = map.submaps > 1 ? [t("map-card.submaps_rooms", { submaps: map.submaps })] : [];
    const about = [size, ...rooms, t("map-card.landmarks_landmarks", { landmarks: map.landmarks })].join(" · ");
    const current = map.name === this.#current;
    const row = make(
      "li.row.map",
      { "data-current": current },
      make("img.map-preview", { src: maps.previewOf(map), alt: "", width: "56", height: "44", loading: "lazy" }),
      make(
        "div.map-body",
        make("p.inline.map-name", map.name, current && make("span.map-badge", t("map-card.in_use"))),
        make("p.note", about),
        make("p.note", `${day(map.saved_s)}, ${map.by === ITSELF ? t("map-card.kept_by_itself") : map.by}`),
      ),
    );
    const acts = make("div.map-acts");
    /** @param {string} look @param {string} says @param {string} words @param {() => void} onclick */
    const act = (look, says, words, onclick) =>
      acts.append(make("button", { class: `button small ${look}`, "aria-label": says, onclick }, words));
    /** @param {string} sentence @param {string} does @param {() => Promise<unknown>} then */
    const ask = (sentence, does, then) =>
      confirmIn(
        row,
        sentence,
        does,
        () => void this.#try(then),
        () => this.#draw(),
      );
    const { name } = map;
    if (!this.#form.hidden)
      act("", t("map-card.load_name", { name }), t("map-card.load"), () =>
        ask(this.#loses(), t("map-card.load_it"), async () => {
          await maps.load(name);
          this.#loaded = name;
          this.#draw();
        }),
      );
    acts.append(
      make(
        "a.button.small.plain",
        { href: maps.zipOf(name), download: "", "aria-label": t("map-card.download_name", { name }) },
        t("map-card.download"),
      ),
    );
    if (!this.#form.hidden)
      acts.append(
        iconButton("pencil", t("map-card.rename_name", { name }), () => this.#askName(row, name), {
          title: t("map-card.rename"),
          look: "small",
        }),
      );
    if (!this.#form.hidden)
      act("plain", t("map-card.delete_name", { name }), t("map-card.delete"), () =>
        ask(t("map-card.delete_this_map_for_good"), t("map-card.delete"), () => maps.remove(name)),
      );
    row.append(acts);
    if (current && name === this.#loaded) row.append(this.#placed);
    return row;
  }

  /** @param {HTMLElement} row @param {string} name of a saved map, which gets another one */
  #askName(row, name) {
    const field = nameField(t("map-card.new_name"), { value: name });
    const leave = () => this.#draw();
    const form = questionIn(row, "form", { "aria-label": t("map-card.rename_name", { name }) });
    const no = make("button.button", { type: "button" }, t("map-card.leave_it"));
    no.addEventListener("click", () => {
      form.remove();
      leave();
    });
    form.append(field, make("button.button.primary", { type: "submit" }, t("map-card.rename")), no);
    onSubmit(form, () => {
      const to = field.value.trim();
      form.remove();
      if (to === name) return leave();
      void this.#try(async () => {
        await maps.rename(name, to);
        await this.#fetch();
      });
    });
    field.select();
    form.scrollIntoView({ block: "nearest" });
  }

  /** @param {() => Promise<unknown>} act */
  async #try(act) {
    this.#busy = true;
    await this.#trouble.attempt(act);
    this.#busy = false;
  }
}

customElements.define("map-card", MapCard);
