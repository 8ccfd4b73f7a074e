// Colour map for distances: near is warm and bright, far is cool and dim; monotonic in grey.

/** @type {ReadonlyArray<readonly [number, number, number]>} */
const STOPS = [
  [253, 231, 37],
  [122, 209, 81],
  [34, 168, 132],
  [42, 120, 142],
  [65, 68, 135],
];

export const FARTHEST = 5; // [m] where the ramp ends

/** @param {number} range [m] @returns {string} a CSS colour */
export function rangeColour(range) {
  const along = (Math.min(Math.max(range, 0), FARTHEST) / FARTHEST) * (STOPS.length - 1);
  const index = Math.min(Math.floor(along), STOPS.length - 2);
  const [from, to] = [STOPS[index] ?? [0, 0, 0], STOPS[index + 1] ?? [0, 0, 0]];
  const mixed = from.map((part, channel) => Math.round(part + (along - index) * ((to[channel] ?? part) - part)));
  return `rgb(${mixed.join(" ")})`;
}
