// The map in words, for those who do not see it.

import { degrees, inWords, metres, whereabouts } from "./format.js";
import { t } from "./texts.js";

/** @import { State } from "../net/messages.js" */
/** @import { Extent } from "./floor-view.js" */

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
  const said = [
    t("map-text.the_robot_is_at_x_metres", {
      metres: metres(x),
      metres2: metres(y),
      degrees: degrees(pose.heading_rad),
    }),
  ];
  if (floor.lost) said.push(t("map-text.it_does_not_know_where_it"));
  const obstacle = nearest(scan);
  if (obstacle)
    said.push(
      t("map-text.nearest_obstacle_metres_whereabouts", {
        metres: metres(obstacle.distance, 1),
        whereabouts: whereabouts(...obstacle.at),
      }),
    );
  if (goal) {
    const length = path.length > 1 ? wayLeft(pose, path) : Math.hypot(goal.x_m - x, goal.y_m - y);
    said.push(
      t("map-text.it_goes_to_x_metres_y", {
        metres: metres(goal.x_m),
        metres2: metres(goal.y_m),
        metres3: metres(length, 1),
      }),
    );
  }
  if (person) {
    const bearing = Math.atan2(person.y_m - y, person.x_m - x) - pose.heading_rad;
    const distance = metres(Math.hypot(person.x_m - x, person.y_m - y), 1);
    said.push(
      t("map-text.someone_is_distance_away_inwords", {
        distance,
        inwords: inWords(Math.atan2(Math.sin(bearing), Math.cos(bearing))),
      }),
    );
  }
  if (extent) {
    const rooms = floor.submaps.length > 1 ? t("map-text.in_length_rooms", { length: floor.submaps.length }) : "";
    said.push(
      t("map-text.the_map_is_metres_by_metres2rooms", {
        metres: metres(extent.right - extent.left, 1),
        metres2: metres(extent.top - extent.bottom, 1),
        rooms,
      }),
    );
  }
  return said.join(" ");
}
