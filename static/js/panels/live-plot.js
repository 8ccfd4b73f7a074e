// Plot of one value over the last two minutes, with its expected band or limit.

import { make, mark, svg, write } from "../ui/element.js";
import { line, Series, SPAN_S, ticks } from "../ui/series.js";
import { t } from "../ui/texts.js";

/**
 * @typedef {object} Look
 * @property {string} name
 * @property {string} says what it means, in a sentence
 * @property {(high: number) => {unit: string, times: number}} unit in which values up to this are read
 * @property {number} least the axis reaches at least so far
 * @property {string} [claim] meaning of the dashed line
 */

const HEIGHT = 68; // [px]
const EDGE = { left: 34, right: 6, top: 6, bottom: 18 };
const EVERY_MS = 250;
const TIMES_S = [-120, -90, -60, -30, 0];

export class LivePlot extends HTMLElement {
  /** @type {Look} */
  #look;
  #series = new Series();
  #value = make("span.plot-value", "–");
  #note = make("span.note");
  #drawing = svg("svg", { class: "plot-drawing", role: "img", height: HEIGHT });
  #grid = svg("g", { class: "plot-grid" });
  #words = svg("g", { class: "plot-words" });
  #band = svg("rect", { class: "plot-band", x: 0, y: 0, width: 0, height: 0 });
  #claim = svg("path", { class: "plot-claim", d: "" });
  #line = svg("path", { class: "plot-line", d: "" });
  #dot = svg("circle", { class: "plot-dot", r: 2.6, visibility: "hidden" });
  /** @type {readonly [number, number] | null} */
  #expected = null;
  #shownAt = -Infinity;
  #axes = "";

  /** @param {Look} look */
  constructor(look) {
    super();
    this.#look = look;
    this.#drawing.append(this.#band, this.#grid, this.#claim, this.#line, this.#dot, this.#words);
  }

  connectedCallback() {
    if (this.children.length) return;
    const { name, says, claim } = this.#look;
    this.title = says;
    mark(this.#drawing, "aria-label", name); // until the first values are drawn
    this.append(
      make(
        "div.plot-head",
        make("span.plot-name", name),
        claim ? make("span.note", claim) : null,
        this.#note,
        make("span.spring"),
        this.#value,
      ),
      this.#drawing,
    );
  }

  /**
   * @param {number} time [s], robot clock
   * @param {number | null} value
   * @param {number | null} [claim] value of the dashed line
   */
  add(time, value, claim = null) {
    this.#series.add(time, value, claim);
  }

  /** @param {string} words next to its name */
  note(words) {
    write(this.#note, words);
  }

  /** @param {readonly [number, number] | null} expected interval of the value */
  show(expected = null) {
    const now = performance.now();
    if (this.offsetParent === null || now - this.#shownAt < EVERY_MS) return;
    this.#shownAt = now;
    this.#expected = expected;
    this.#draw();
  }

  #draw() {
    const { samples, newest, highest } = this.#series;
    const width = this.#drawing.clientWidth || 300;
    const [low, high] = this.#expected ?? [0, 0];
    const top = Math.max(Number.isFinite(highest) ? highest : 0, this.#look.least, this.#expected ? 1.15 * high : 0);
    const { unit, times } = this.#look.unit(top);
    const marks = ticks(top * times);
    const end = newest?.[0] ?? 0;
    const inner = { width: width - EDGE.left - EDGE.right, height: HEIGHT - EDGE.top - EDGE.bottom };
    /** @param {number} time */
    const x = (time) => EDGE.left + inner.width * (1 + (time - end) / SPAN_S);
    /** @param {number} value */
    const y = (value) => EDGE.top + inner.height * (1 - (value * times) / (marks.at(-1) ?? 1));
    this.#drawAxes(width, marks, inner);
    mark(this.#line, "d", line(samples, 1, x, y));
    mark(this.#claim, "d", line(samples, 2, x, y));
    place(this.#band, this.#expected && { x: EDGE.left, y: y(high), width: inner.width, height: y(low) - y(high) });
    const value = newest?.[1] ?? NaN;
    const known = Number.isFinite(value);
    mark(this.#dot, "visibility", known ? null : "hidden");
    if (known) {
      mark(this.#dot, "cx", x(end).toFixed(1));
      mark(this.#dot, "cy", y(value).toFixed(1));
    }
    const reading = known ? `${figure(value * times)}${unit}` : "–";
    write(this.#value, reading);
    mark(this.#value, "data-tone", this.#expected && value > high ? "stale" : null);
    mark(
      this.#drawing,
      "aria-label",
      t("live-plot.name_the_last_two_minutes_now", {
        name: this.#look.name,
        reading,
        figure: figure(highest * times),
        unit,
      }),
    );
  }

  /** @param {number} width @param {readonly number[]} marks @param {{width: number, height: number}} inner */
  #drawAxes(width, marks, inner) {
    const axes = `${width} ${marks.join(" ")}`;
    if (axes === this.#axes) return;
    this.#axes = axes;
    mark(this.#drawing, "viewBox", `0 0 ${width} ${HEIGHT}`);
    const last = marks.at(-1) ?? 1;
    const rows = marks.map((value) => ({ value, y: EDGE.top + inner.height * (1 - value / last) }));
    const columns = TIMES_S.map((time) => ({ time, x: EDGE.left + inner.width * (1 + time / SPAN_S) }));
    this.#grid.replaceChildren(
      ...rows.map(({ y }) => svg("line", { x1: EDGE.left, x2: EDGE.left + inner.width, y1: y, y2: y })),
      ...columns.map(({ x }) =>
        svg("line", { x1: x, x2: x, y1: EDGE.top, y2: EDGE.top + inner.height, class: "plot-time" }),
      ),
    );
    const named = rows.filter((_, index) => marks.length <= 3 || index % 2 === (marks.length - 1) % 2 || index === 0);
    this.#words.replaceChildren(
      ...named.map(({ value, y }) => text(figure(value), { x: EDGE.left - 5, y: y + 4.5, "text-anchor": "end" })),
      ...columns
        .filter(({ time }) => time % 60 === 0)
        .map(({ time, x }) =>
          text(time === 0 ? t("live-plot.now") : `−${-time} s`, {
            x: time === 0 ? x + 4 : x,
            y: HEIGHT - 4,
            "text-anchor": time === 0 ? "end" : time === -SPAN_S ? "start" : "middle",
          }),
        ),
    );
  }
}

/** @param {string} words @param {Record<string, string | number>} attributes */
function text(words, attributes) {
  const element = svg("text", attributes);
  element.textContent = words;
  return element;
}

/**
 * @param {SVGRectElement} rectangle
 * @param {{x: number, y: number, width: number, height: number} | null} where null: nowhere
 */
function place(rectangle, where) {
  const { x, y, width, height } = where ?? { x: 0, y: 0, width: 0, height: 0 };
  for (const [name, value] of Object.entries({ x, y, width, height: Math.max(0, height) }))
    mark(rectangle, name, value.toFixed(1));
}

/** A number in three places or so: 0.04, 1.2, 35. @param {number} value */
export function figure(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const decimals = size === 0 || size >= 10 ? 0 : size >= 1 ? 1 : 2;
  return String(Number(value.toFixed(decimals)));
}

customElements.define("live-plot", LivePlot);
