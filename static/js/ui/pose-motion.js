// Poses between the stamped ones, for a display that is faster than the robot's frames; nothing is extrapolated.

/** @typedef {{x: number, y: number, heading: number}} At */
/** @typedef {{stamp: number, late: number, at: At}} Stamped [s] of the robot's clock, and by how much ours is ahead */

const KEPT = 20; // poses
const TRAIL_S = 30; // after which a passed place is no longer drawn
const TRAIL_STEP_M = 0.03;
const JUMP_M = 0.5; // farther than a robot drives between two frames: a correction, shown at once
const OLD_S = 0.15; // later than two frames: what is shown is no longer true

export class PoseMotion {
  /** @type {Stamped[]} */
  #poses = [];
  /** @type {{x: number, y: number, stamp: number}[]} */
  #trail = [];
  #period = 0.2; // [s] between frames

  /**
   * A pose arrived.
   * @param {number} stamp [s] of the robot's clock
   * @param {At} at
   * @param {number} now [s] of ours
   */
  saw(stamp, at, now) {
    const newest = this.#poses.at(-1);
    if (newest && (stamp <= newest.stamp || apart(newest.at, at) > JUMP_M)) {
      if (stamp === newest.stamp) return;
      this.forget();
    }
    if (newest && stamp > newest.stamp) this.#period += 0.2 * (Math.min(1, stamp - newest.stamp) - this.#period);
    this.#poses.push({ stamp, late: now - stamp, at });
    if (this.#poses.length > KEPT) this.#poses.shift();
    const last = this.#trail.at(-1);
    if (!last || Math.hypot(at.x - last.x, at.y - last.y) >= TRAIL_STEP_M)
      this.#trail.push({ x: at.x, y: at.y, stamp });
    while (this.#trail[0] && stamp - this.#trail[0].stamp > TRAIL_S) this.#trail.shift();
  }

  /** Another map or another robot. */
  forget() {
    [this.#poses, this.#trail] = [[], []];
  }

  /**
   * Return the pose to show, one frame late so that it lies between two; `moving` while another would be shown soon.
   * @param {number} now [s] of our clock
   * @returns {{at: At, moving: boolean, old: boolean} | null}
   */
  at(now) {
    const newest = this.#poses.at(-1);
    if (!newest) return null;
    const quickest = Math.min(...this.#poses.map(({ late }) => late));
    const shown = now - quickest - this.#period;
    const at = this.where(shown);
    return at
      ? { at, moving: this.#moved(), old: false }
      : { at: newest.at, moving: false, old: now - newest.stamp - newest.late > OLD_S + 2 * this.#period };
  }

  /**
   * Return the pose at a stamp, between those that are known; null for one that is newer than all.
   * @param {number} stamp [s] of the robot's clock
   */
  where(stamp) {
    const after = this.#poses.findIndex((pose) => pose.stamp >= stamp);
    const [to, from] = [this.#poses[after], this.#poses[Math.max(0, after - 1)]];
    if (!to || !from) return null;
    return to === from ? to.at : between(from.at, to.at, (stamp - from.stamp) / (to.stamp - from.stamp));
  }

  /** Where it was within the last half minute, oldest first, each with how fresh it is (0..1). */
  get trail() {
    const now = this.#poses.at(-1)?.stamp ?? 0;
    return this.#trail.map(({ x, y, stamp }) => ({ x, y, fresh: Math.max(0, 1 - (now - stamp) / TRAIL_S) }));
  }

  #moved() {
    const [newest, before] = [this.#poses.at(-1), this.#poses.at(-3) ?? this.#poses[0]];
    return newest !== undefined && before !== undefined && differs(newest.at, before.at);
  }
}

/** @param {At} one @param {At} other */
const apart = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);

/** @param {At} one @param {At} other */
const differs = (one, other) => apart(one, other) > 1e-3 || Math.abs(one.heading - other.heading) > 1e-3;

/** @param {At} from @param {At} to @param {number} part 0..1 @returns {At} */
function between(from, to, part) {
  const turn = Math.atan2(Math.sin(to.heading - from.heading), Math.cos(to.heading - from.heading));
  return {
    x: from.x + part * (to.x - from.x),
    y: from.y + part * (to.y - from.y),
    heading: from.heading + part * turn,
  };
}
