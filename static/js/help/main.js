// The help page: pages of the documentation beside the running robot. The hash of the address names the page.

import { address } from "../net/api.js";
import { icon, make, mark, write } from "../ui/element.js";
import { inLanguage, language, t } from "../ui/texts.js";

const CONTENTS = "index.md";
const ROOT = "static/docs/";
const API = "docs";
const DOCS = "en"; // the language of every article

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const text = make("article.docs");
  const says = make("p.note", { role: "status" });
  const lead = make("p.note.help-lead", { hidden: language === DOCS });
  const back = make("a.link", { href: "help" }, icon("book"), t("main.contents"));
  const api = make("a.link", { href: `help#${API}` }, t("main.http_interface"));
  const nav = make("nav.help-nav", { "aria-label": t("main.contents") });
  /** @type {Promise<Node[]> | undefined} */
  let contents;
  let shown = "";

  /** Beside an article, where there is room, stands what else there is. @param {string} file */
  async function showContents(file) {
    nav.hidden = file === CONTENTS;
    if (nav.hidden) return;
    contents ??= read(CONTENTS).catch(() => []);
    nav.replaceChildren(...(await contents).filter((node) => node.nodeName === "DIV"));
    for (const link of nav.querySelectorAll("a"))
      mark(link, "aria-current", link.getAttribute("href") === `help#${file}` ? "page" : null);
  }

  async function follow() {
    const [file, anchor] = fileOf(location.hash);
    void showContents(file);
    back.hidden = file === CONTENTS;
    mark(text, "data-contents", file === CONTENTS);
    if (file !== shown) {
      write(says, t("main.loading"));
      const page = await read(file).catch(() => null);
      if (file !== fileOf(location.hash)[0]) return; // another one is wanted by now
      write(says, page ? "" : t("main.this_page_cannot_be_read_it"));
      shown = page ? file : "";
      text.replaceChildren(...(page ?? []));
      text.lang = file === CONTENTS ? language : DOCS;
      write(lead, page ? leadOf(file === CONTENTS ? "" : (text.querySelector("h2")?.textContent ?? "")) : "");
    }
    if (anchor) text.querySelector(`#${CSS.escape(anchor)}`)?.scrollIntoView();
    else text.closest("main")?.scrollTo(0, 0);
    const title = text.querySelector("h2")?.textContent;
    if (title && shown !== CONTENTS) session.announce(title);
  }

  const element = make("div.stack", make("p.help-links", back, api), says, lead, make("div.help-sides", nav, text));
  return { element, opened: () => void follow(), moved: () => void follow() };
}

/** @param {string} hash of the address @returns {[string, string]} a file below the documentation, and a chapter of it */
export function fileOf(hash) {
  const [file = "", anchor = ""] = hash.replace(/^#/, "").split("#");
  return file === API || /^[\w-]+(?:\/[\w-]+)*\.md$/.test(file) ? [file, anchor] : [CONTENTS, ""];
}

/**
 * Fetch a page of the documentation; its links stay inside the help page, and its headings are one level lower.
 * @param {string} file
 * @returns {Promise<Node[]>}
 */
async function read(file) {
  const url = address(file === API ? API : ROOT + file);
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(String(answer.status));
  const page = new DOMParser().parseFromString(await answer.text(), "text/html");
  const main = page.querySelector("main");
  if (!main) throw new Error("no page");
  const docs = address(ROOT).href;
  const chapters = page.querySelector(".contents");
  if (chapters && file !== CONTENTS) main.prepend(chapters);
  for (const link of main.querySelectorAll("a[href]")) {
    const href = link.getAttribute("href") ?? "";
    if (href.startsWith("#")) {
      link.setAttribute("href", `help#${file}${href}`);
      continue;
    }
    const to = new URL(href, url);
    const near = to.href.startsWith(docs) && to.pathname.endsWith(".md");
    link.setAttribute("href", near ? `help#${to.href.slice(docs.length)}` : to.href);
    if (!near) link.setAttribute("target", "_blank");
    if (!near) link.setAttribute("rel", "noopener");
  }
  for (const picture of main.querySelectorAll("img, source"))
    for (const name of ["src", "srcset"]) {
      const at = picture.getAttribute(name);
      if (at) picture.setAttribute(name, new URL(at, url).href);
    }
  if (file === CONTENTS) {
    main.querySelector("h1")?.remove(); // the page's own title says it
    layInCards(main);
    translateTexts(main);
  } else lowerHeadings(main);
  return [...main.childNodes].map((node) => document.adoptNode(node));
}

/** What precedes an English text in another language. @param {string} title of an article; "": the contents */
function leadOf(title) {
  if (!title) return t("main.articles_are_in_english");
  const known = inLanguage(title);
  return known === title ? t("main.this_is_in_english") : t("main.title_is_in_english", { title: known });
}

/** Say the contents in the page's language. @param {Element} main */
function translateTexts(main) {
  if (language === DOCS) return;
  const texts = document.createTreeWalker(main, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const node = /** @type {Text} */ (texts.currentNode);
    const words = node.data.replace(/\s+/g, " ");
    node.data = words.replace(words.trim(), inLanguage(words.trim()));
  }
}

/** Every heading with what follows it on a card, and below a link what is said of it. @param {Element} main */
function layInCards(main) {
  const cards = make("div.help-cards");
  for (const part of [...main.children]) {
    if (part.localName === "h2") cards.append(make("section.card.help-card"));
    cards.lastElementChild?.append(part);
  }
  main.append(cards);
  for (const link of cards.querySelectorAll("li > a:first-child")) {
    const says = make("span.note");
    while (link.nextSibling) says.append(link.nextSibling);
    if (says.firstChild) says.firstChild.textContent = (says.firstChild.textContent ?? "").replace(/^:?\s+/, "");
    link.append(says);
  }
}

/** @param {Element} main whose headings stand below the page's own one */
function lowerHeadings(main) {
  for (const heading of [...main.querySelectorAll("h1, h2, h3, h4, h5")].reverse()) {
    const lower = document.createElement(`h${Number(heading.localName.slice(1)) + 1}`);
    lower.id = heading.id;
    lower.append(...heading.childNodes);
    heading.replaceWith(lower);
  }
}
