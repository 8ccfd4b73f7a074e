// Transform between the floor (metres, y up) and a drawing of it (pixels, y down).

/** @typedef {{x: number, y: number}} Point */
/** @typedef {{left: number, bottom: number, right: number, top: number}} Extent [m], world */

const CLOSEST = 400; // [px] to a metre
const FARTHEST = 1;
const RIM = 6; // [px] that a steady view keeps around an extent
const MAX_GROWTH = 1.3; // so many times larger the fitted view is at most while a steady one is kept

export class FloorView {
  /** @param {number} scale [px/m] @param {number} left [px] of the world's origin @param {number} top [px] */
  constructor(scale, left, top) {
    this.scale = scale;
    this.left = left;
    this.top = top;
  }

  /**
   * All of an extent in the middle of a drawing.
   * @param {Extent} extent
   * @param {number} width [px]
   * @param {number} height [px]
   * @param {number} margin [px]
   */
  static fitted({ left, bottom, right, top }, width, height, margin) {
    const across = (width - 2 * margin) / Math.max(right - left, 0.1);
    const scale = Math.min(
      CLOSEST,
      Math.max(FARTHEST, Math.min(across, (height - 2 * margin) / Math.max(top - bottom, 0.1))),
    );
    return new FloorView(scale, width / 2 - (scale * (left + right)) / 2, height / 2 + (scale * (bottom + top)) / 2);
  }

  /**
   * The same size, with a point in the middle of a drawing.
   * @param {Point} floor [m]
   * @param {number} width [px]
   * @param {number} height [px]
   */
  centred({ x, y }, width, height) {
    return new FloorView(this.scale, width / 2 - this.scale * x, height / 2 + this.scale * y);
  }

  /**
   * This view of an extent while a box shows all of it and it is not much too small, else the one that is fitted: a
   * card that opens, or a wall more, moves no map.
   * @param {FloorView} fitted
   * @param {Extent} extent [m]
   * @param {Extent} box [px]
   */
  steady(fitted, extent, box) {
    const first = this.drawn({ x: extent.left, y: extent.top });
    const last = this.drawn({ x: extent.right, y: extent.bottom });
    const [left, top, right, bottom] = [box.left + RIM, box.top + RIM, box.right - RIM, box.bottom - RIM];
    const shown = first.x >= left && first.y >= top && last.x <= right && last.y <= bottom;
    return shown && fitted.scale < MAX_GROWTH * this.scale ? this : fitted;
  }

  /** @param {Point} floor [m] @returns {Point} [px] */
  drawn({ x, y }) {
    return { x: this.left + this.scale * x, y: this.top - this.scale * y };
  }

  /** @param {Point} drawn [px] @returns {Point} [m] */
  floor({ x, y }) {
    return { x: (x - this.left) / this.scale, y: (this.top - y) / this.scale };
  }

  /**
   * The same, moved, and larger or smaller about a point that stays where it is drawn.
   * @param {Point} about [px]
   * @param {number} times
   * @param {Point} [shift] [px]
   */
  changed(about, times, shift = { x: 0, y: 0 }) {
    const scale = Math.min(CLOSEST, Math.max(FARTHEST, this.scale * times));
    const by = scale / this.scale;
    return new FloorView(
      scale,
      about.x + by * (this.left - about.x) + shift.x,
      about.y + by * (this.top - about.y) + shift.y,
    );
  }
}

/**
 * Heading of a drag on the floor, or null when it is too short.
 * @param {Point} from [px]
 * @param {Point} to [px]
 * @param {number} least [px]
 * @returns {number | null} [rad], counter-clockwise from +x
 */
export function headingOf(from, to, least) {
  const [across, down] = [to.x - from.x, to.y - from.y];
  return Math.hypot(across, down) < least ? null : Math.atan2(-down, across);
}

/**
 * Transform points from the robot frame to the floor.
 * @param {ReadonlyArray<readonly [number, number]>} points [m], robot frame
 * @param {{x: number, y: number, heading: number}} pose
 * @returns {Point[]} [m], world
 */
export function seenFrom(points, { x, y, heading }) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return points.map(([ahead, left]) => ({ x: x + cos * ahead - sin * left, y: y + sin * ahead + cos * left }));
}
