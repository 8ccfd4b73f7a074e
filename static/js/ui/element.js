// Create elements, and change them only where something differs.
// Button with an icon and a label, both of which can change.

const SVG = "http://www.w3.org/2000/svg";

/**
 * `"p"` or `"p.note.wide"`: a tag and its classes → the tag.
 * @template {string} S
 * @typedef {S extends `${infer T}.${string}` ? T : S} Tag
 */
/** @typedef {Node | string | null | undefined | false} Child */

/**
 * An element: `make("li.fact", { title: "…" }, ...children)`, or without attributes. `on…` are listeners; null,
 * undefined and false leave an attribute out. A button sends no form unless it says `type: "submit"`.
 * @template {keyof HTMLElementTagNameMap | `${keyof HTMLElementTagNameMap}.${string}`} S
 * @param {S} selector
 * @param {Record<string, any> | Child} [first] attributes, or the first child
 * @param {...Child} rest
 * @returns {HTMLElementTagNameMap[Tag<S> & keyof HTMLElementTagNameMap]}
 */
export function make(selector, first, ...rest) {
  const [tag = "", ...classes] = selector.split(".");
  const element = document.createElement(tag);
  if (classes.length) element.className = classes.join(" ");
  if (tag === "button") element.setAttribute("type", "button");
  const attributes = first && typeof first === "object" && !("nodeType" in first) ? first : null;
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false)
      element.setAttribute(name, value === true ? "" : value);
  }
  for (const child of attributes ? rest : [/** @type {Child} */ (first), ...rest])
    if (child || child === "") element.append(child);
  return /** @type {any} */ (element);
}

/**
 * An element of a drawing with its attributes.
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Record<string, string | number>} attributes
 * @returns {SVGElementTagNameMap[T]}
 */
export function svg(tag, attributes) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  return element;
}

const ICONS = new URL("../../img/icons.svg", import.meta.url).href;

/**
 * A drawing from static/img/icons.svg. Hidden from screen readers: the label next to it names it.
 * @param {string} name
 */
export function icon(name) {
  const drawing = document.createElementNS(SVG, "svg");
  const use = document.createElementNS(SVG, "use");
  drawing.setAttribute("class", "icon");
  drawing.setAttribute("aria-hidden", "true");
  use.setAttribute("href", `${ICONS}#${name}`);
  drawing.append(use);
  return drawing;
}

/** @param {SVGElement | null} drawing made by icon() @param {string} name */
export function redraw(drawing, name) {
  const use = drawing?.firstElementChild;
  const href = `${ICONS}#${name}`;
  if (use && use.getAttribute("href") !== href) use.setAttribute("href", href);
}

/** @param {Element} element @param {string} text */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {Element} element
 * @param {string} name
 * @param {string | boolean | null} value true: present; false or null: absent
 */
export function mark(element, name, value) {
  if (value === false || value === null) {
    if (element.hasAttribute(name)) element.removeAttribute(name);
  } else {
    const text = value === true ? "" : value;
    if (element.getAttribute(name) !== text) element.setAttribute(name, text);
  }
}

/** @type {WeakMap<object, string>} */
const LATEST = new WeakMap();

/**
 * Whether these values differ from those of the call before for the same owner, so that it has to be drawn again.
 * @param {object} owner @param {...unknown} values
 */
export function isNew(owner, ...values) {
  const key = JSON.stringify(values);
  const differs = LATEST.get(owner) !== key;
  if (differs) LATEST.set(owner, key);
  return differs;
}

/**
 * A button that is a drawing.
 * @param {string} drawing
 * @param {string} says its name for who does not see it
 * @param {(() => void) | undefined} onclick
 * @param {{title?: string, look?: string}} [more] what the pointer says; further classes
 */
export const iconButton = (drawing, says, onclick, { title, look } = {}) =>
  make("button", { class: `icon-button ${look ?? ""}`.trim(), "aria-label": says, title, onclick }, icon(drawing));

/** Do it when the form is sent, instead of sending it. @param {HTMLFormElement} form @param {() => void} act */
export function onSubmit(form, act) {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    act();
  });
}

/**
 * A field for a name: what is typed there is no key of the robot's.
 * @param {string} words that stand in it while it is empty
 * @param {Record<string, string>} [more] attributes; an `id` for who labels it
 */
export function nameField(words, more = {}) {
  const held = { type: "text", maxlength: "40", autocomplete: "off", spellcheck: "false", placeholder: words };
  const field = make("input.field-box", { ...held, "aria-label": "id" in more ? null : words, ...more });
  field.addEventListener("keydown", (event) => event.key !== "Escape" && event.stopPropagation());
  return field;
}

/**
 * A field for a number.
 * @param {string} says its name
 * @param {Record<string, string | number | boolean>} bounds min, max, step, value
 * @param {string} [look] further classes
 */
export const numberField = (says, bounds, look = "") =>
  make("input", { class: `field-box ${look}`.trim(), type: "number", "aria-label": says, ...bounds });

/** A head of a card. @param {string} title @param {...Child} rest stand at its end */
export const cardHead = (title, ...rest) =>
  make("div.card-head", make("h2.card-title", title), rest.length > 0 && make("span.spring"), ...rest);

/** @param {string} drawing @param {string} words @param {() => void} [onclick] */
export const action = (drawing, words, onclick) =>
  make("button.button", { "data-does": drawing, onclick }, icon(drawing), make("span", words));

/** @param {HTMLButtonElement} button @param {string} words @param {string} drawing */
export function say(button, words, drawing) {
  write(/** @type {Element} */ (button.lastElementChild), words);
  redraw(/** @type {SVGElement} */ (button.firstElementChild), drawing);
}
