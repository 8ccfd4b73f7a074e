// The map in words, for those who do not see it.

import { degrees, inWords, metres, whereabouts } from "./format.js";

/** @typedef {import("../net/messages.js").State} State */
/** @typedef {import("./floor-view.js").Extent} Extent */

/**
 * Nearest of the laser's points.
 * @param {ReadonlyArray<readonly [number, number]>} points [m], robot frame
 * @returns {{distance: number, at: readonly [number, number]} | null}
 */
export function nearest(points) {
  let found = null;
  for (const at of points) {
    const distance = Math.hypot(...at);
    if (found === null || distance < found.distance) found = { distance, at };
  }
  return found;
}

/**
 * Length of what is left of a way.
 * @param {{x_m: number, y_m: number}} pose
 * @param {ReadonlyArray<readonly [number, number]>} path [m], world
 */
export function wayLeft({ x_m: x, y_m: y }, path) {
  let [length, east, north] = [0, x, y];
  let nearestAt = 0;
  for (const [index, [px, py]] of path.entries()) {
    const [bx, by] = path[nearestAt] ?? [px, py];
    if (Math.hypot(px - x, py - y) < Math.hypot(bx - x, by - y)) nearestAt = index;
  }
  for (const [px, py] of path.slice(nearestAt)) {
    length += Math.hypot(px - east, py - north);
    [east, north] = [px, py];
  }
  return length;
}

/**
 * @param {State} state
 * @param {ReadonlyArray<readonly [number, number]>} scan [m], robot frame
 * @param {Extent | null} extent of the map
 */
export function mapInWords(state, scan, extent) {
  const { pose, goal, path, person, floor } = state;
  const x = pose.x_m;
  const y = pose.y_m;
  const said = [`The robot is at x ${metres(x)}, y ${metres(y)}, heading ${degrees(pose.heading_rad)}.`];
  if (floor.lost) said.push("It does not know where it is.");
  const obstacle = nearest(scan);
  if (obstacle) said.push(`Nearest obstacle ${metres(obstacle.distance, 1)} ${whereabouts(...obstacle.at)}.`);
  if (goal) {
    const length = path.length > 1 ? wayLeft(pose, path) : Math.hypot(goal.x_m - x, goal.y_m - y);
    said.push(`It goes to x ${metres(goal.x_m)}, y ${metres(goal.y_m)}: ${metres(length, 1)} to go.`);
  }
  if (person) {
    const bearing = Math.atan2(person.y_m - y, person.x_m - x) - pose.heading_rad;
    const distance = metres(Math.hypot(person.x_m - x, person.y_m - y), 1);
    said.push(`Somebody is ${distance} away, ${inWords(Math.atan2(Math.sin(bearing), Math.cos(bearing)))}.`);
  }
  if (extent) {
    const rooms = floor.submaps.length > 1 ? ` in ${floor.submaps.length} rooms` : "";
    said.push(
      `The map is ${metres(extent.right - extent.left, 1)} by ${metres(extent.top - extent.bottom, 1)}${rooms}.`,
    );
  }
  return said.join(" ");
}
