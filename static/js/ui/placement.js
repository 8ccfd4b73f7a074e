// Placement of a hint next to its target: inside the window, never over STOP, preferably not over the command line.

/** @typedef {{left: number, top: number, right: number, bottom: number}} Box */
/** @typedef {"above" | "below" | "left" | "right"} Side */

const GAP = 14;
const EDGE = 8;
const NEAR = 40; // [px] by which one place is nearer than another before that counts

/**
 * @param {Box} target
 * @param {{width: number, height: number}} size of the hint
 * @param {{width: number, height: number}} space of the window
 * @param {Box} never what it may not cover
 * @param {readonly Box[]} rather what else it had better not cover
 * @returns {{left: number, top: number, side: Side}}
 */
export function placed(target, size, space, never, rather = []) {
  const [x, y] = [(target.left + target.right) / 2, (target.top + target.bottom) / 2];
  /** @type {Array<{left: number, top: number, side: Side}>} */
  const ways = [
    { side: "above", left: x - size.width / 2, top: target.top - GAP - size.height },
    { side: "below", left: x - size.width / 2, top: target.bottom + GAP },
    { side: "right", left: target.right + GAP, top: y - size.height / 2 },
    { side: "left", left: target.left - GAP - size.width, top: y - size.height / 2 },
  ];
  const aside = ways.flatMap((way) =>
    [never, ...rather].flatMap((free) => [
      { ...way, left: free.left - GAP - size.width },
      { ...way, top: free.top - GAP - size.height },
      { ...way, top: free.bottom + GAP },
    ]),
  );
  const inside = [...ways, ...aside].map((way) => ({
    ...way,
    left: clamp(way.left, EDGE, space.width - size.width - EDGE),
    top: clamp(way.top, EDGE, space.height - size.height - EDGE),
  }));
  /** @param {{left: number, top: number}} at */
  const box = (at) => ({ left: at.left, top: at.top, right: at.left + size.width, bottom: at.top + size.height });
  /** @param {{left: number, top: number}} at */
  const covered = (at) => [target, ...rather].reduce((sum, other) => sum + overlap(box(at), other), 0);
  const clear = inside.filter((way) => overlap(box(way), never) === 0);
  const candidates = clear.length ? clear : inside;
  /** @param {{left: number, top: number}} at */
  const far = (at) => Math.hypot(at.left + size.width / 2 - x, at.top + size.height / 2 - y);
  /** @param {{left: number, top: number}} one @param {{left: number, top: number}} other */
  const better = (one, other) => covered(one) - covered(other) || Math.round((far(one) - far(other)) / NEAR);
  return candidates.reduce((best, way) => (better(way, best) < 0 ? way : best));
}

/** @param {number} value @param {number} low @param {number} high */
const clamp = (value, low, high) => Math.max(low, Math.min(value, high));

/** How far two boxes are apart [px], across or down; 0 or less: they touch. @param {Box} a @param {Box} b */
export const apart = (a, b) => Math.max(a.left - b.right, b.left - a.right, a.top - b.bottom, b.top - a.bottom);

/** Shared area [px²]. @param {Box} a @param {Box} b */
export function overlap(a, b) {
  const width = Math.min(a.right, b.right) - Math.max(a.left, b.left);
  const height = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
  return Math.max(0, width) * Math.max(0, height);
}
