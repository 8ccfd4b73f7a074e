"""The odometry of a recording, for any instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.geometry import Pose, rotation, wrap, wrap_all
from core.message import Array, message
from core.sensors import Wheels

MAX_VALUE = 1e6  # [m, rad, m/s, rad/s]: what is so far from the rest is no odometry


@message
class OdometryTrack:
    """Odometry over time, rebased so that it starts at Pose(0, 0, 0)."""

    times: Array  # (N,) [s], rising
    poses: Array  # (N, 3) [m, m, rad], headings unwrapped
    speeds: Array  # (N,) [m/s]
    turn_rates: Array  # (N,) [rad/s]

    @staticmethod
    def of(times: Array, poses: Array, twists: Array | None = None) -> OdometryTrack | None:
        """Times (N,) [s], poses (N, 3) in any order, twists (N, 2) [m/s, rad/s] if known → the track.

        Rows that are not finite or absurd, and repeated times are left out; fewer than two rows left: None. Twists
        that are mostly so are taken for unknown: some bases send none.
        """
        good = np.isfinite(times) & np.isfinite(poses).all(axis=1)
        good &= (np.abs(poses - np.median(poses[good], axis=0)) < MAX_VALUE).all(axis=1) if good.any() else False
        sound = None if twists is None else (np.abs(twists) < MAX_VALUE).all(axis=1)
        if sound is not None and np.count_nonzero(sound & good) > np.count_nonzero(good) / 2:
            good &= sound
        else:
            twists = None
        times, first = np.unique(times[good], return_index=True)
        if len(times) < 2:
            return None
        poses = poses[good][first]
        heading = np.unwrap(poses[:, 2])
        places = (poses[:, :2] - poses[0, :2]) @ rotation(heading[0])
        poses = np.column_stack([places, heading - heading[0]])
        twists = _differences(times, poses) if twists is None else twists[good][first]
        return OdometryTrack(times=times, poses=poses, speeds=twists[:, 0], turn_rates=twists[:, 1])

    @property
    def mirrored(self) -> OdometryTrack:
        """The same track seen in a mirror along its first heading."""
        return replace(self, poses=self.poses * [1.0, -1.0, -1.0], turn_rates=-self.turn_rates)

    def wheels_at(self, stamp: float) -> Wheels:
        """The wheels' reading at `stamp` [s], between two records in proportion, outside them held."""
        if not self.times[0] <= stamp <= self.times[-1]:
            pose = self.poses[0 if stamp < self.times[0] else -1]
            return Wheels(odometry=_pose(pose), speed=0.0, turn_rate=0.0)
        after = max(1, int(np.searchsorted(self.times, stamp)))
        before = after - 1
        share = (stamp - self.times[before]) / (self.times[after] - self.times[before])
        pose = (1 - share) * self.poses[before] + share * self.poses[after]
        return Wheels(
            odometry=_pose(pose),
            speed=float((1 - share) * self.speeds[before] + share * self.speeds[after]),
            turn_rate=float((1 - share) * self.turn_rates[before] + share * self.turn_rates[after]),
        )


def _pose(row: Array) -> Pose:
    return Pose(float(row[0]), float(row[1]), wrap(float(row[2])))


def _differences(times: Array, poses: Array) -> Array:
    """Times (N,), poses (N, 3) → (N, 2) speed ahead and turn rate by central differences."""
    turn_rates = np.gradient(poses[:, 2], times)
    along = np.stack([np.gradient(poses[:, 0], times), np.gradient(poses[:, 1], times)], axis=1)
    ahead = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    return np.stack([(along * ahead).sum(axis=1), turn_rates], axis=1)


def heading_of(qx: Array, qy: Array, qz: Array, qw: Array) -> Array:
    """Quaternions, each part (...) → heading (...) [rad] of the x axis in the plane."""
    return wrap_all(np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))
