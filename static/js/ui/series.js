// History of a value: the last two minutes, kept in this page.

/** @typedef {readonly [time: number, ...values: number[]]} Sample */

export const SPAN_S = 120;
const STEP_S = 0.2; // a newer value within this replaces the last

export class Series {
  /** @type {Sample[]} */
  #samples = [];

  /** @returns {readonly Sample[]} oldest first */
  get samples() {
    return this.#samples;
  }

  /** @returns {Sample | null} */
  get newest() {
    return this.#samples.at(-1) ?? null;
  }

  /**
   * Add a sample. A value that is not a number leaves a gap; a clock that goes back clears the series.
   * @param {number} time [s], robot clock
   * @param {...(number | null)} values
   */
  add(time, ...values) {
    const last = this.newest;
    if (last && time < last[0]) this.#samples = [];
    const numbers = values.map((value) => (value === null ? NaN : value));
    const [older] = this.#samples.slice(-2, -1);
    if (last && older && time - older[0] < STEP_S) this.#samples.pop();
    this.#samples.push([time, ...numbers]);
    const first = this.#samples.findIndex(([at]) => at >= time - SPAN_S);
    if (first > 0) this.#samples.splice(0, first);
  }

  /** @returns {number} the largest of all values; NaN when there are none */
  get highest() {
    let high = NaN;
    for (const [, ...values] of this.#samples)
      for (const value of values) if (!(value <= high)) high = Number.isFinite(value) ? value : high;
    return high;
  }
}

/**
 * Round values for an axis that begins at 0: two to four of them, the last at or above what must fit.
 * @param {number} high what must fit
 * @returns {number[]}
 */
export function ticks(high) {
  if (!(high > 0)) return [0, 1];
  const rough = high / 3;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((times) => times * power >= rough * 0.999) ?? 10);
  const count = Math.ceil(high / step - 1e-9);
  return Array.from({ length: count + 1 }, (_, index) => Number((index * step).toPrecision(6)));
}

/**
 * Samples as the path of a line, with gaps where there is no number.
 * @param {readonly Sample[]} samples
 * @param {number} which of their values, from 1
 * @param {(time: number) => number} x
 * @param {(value: number) => number} y
 */
export function line(samples, which, x, y) {
  let path = "";
  let drawing = false;
  for (const sample of samples) {
    const value = sample[which] ?? NaN;
    if (Number.isFinite(value)) path += `${drawing ? "L" : "M"}${x(sample[0]).toFixed(1)} ${y(value).toFixed(1)}`;
    drawing = Number.isFinite(value);
  }
  return path;
}
