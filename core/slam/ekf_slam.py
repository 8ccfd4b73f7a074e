"""EKF-SLAM: the pose and the landmarks, estimated together (section 4.1, eq. 14-33)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Laser
from core.setting import Meta
from core.slam.association.associate import AssociationSettings, Observation, recognise
from core.slam.association.landmark_table import LandmarkRecord, LandmarkSettings, LandmarkTable
from core.slam.association.merge_duplicates import join_doubles
from core.slam.association.nearest_neighbour import Assignment
from core.slam.association.visibility import VisibilityCheck
from core.slam.consistency import squared_error
from core.slam.ekf.filter import Filter, Innovation
from core.slam.ekf.invariant import InvariantFilter
from core.slam.ekf.measurement_model import squared_distance
from core.slam.ekf.paper import PaperFilter
from core.slam.ekf.robust import AdaptiveGate, SlipThresholds, displaced, mahalanobis, trust, with_noise
from core.slam.estimate import Association, Estimate, Landmark, SlamHealth
from core.slam.motion import Increment

FORMS: dict[str, type[Filter]] = {"invariant": InvariantFilter, "paper": PaperFilter}
NIS_FADE = 0.98  # memory of the running NIS, per sighting


@dataclass(frozen=True)
class EkfSettings(LandmarkSettings, AssociationSettings, SlipThresholds):
    """The estimator.

    Watch:
        mode: NIS and the error in `beckon experiment dead-reckoning-vs-slam`
        sighting_noise: NIS, which should stay around 1
        range_sd: NIS with `sighting_noise` paper
        bearing_sd: NIS with `sighting_noise` paper
        soft_gate: jumps of the pose where people walk by (then lower it)
    """

    soft_memory: int = 80  # latest sightings that give the usual distance
    soft_slack: float = 2.0  # usual distance over the filter's own, beyond which the soft gate widens
    still_scans: int = 10  # scans taken at rest before the first move
    still_every: int = 5  # at rest, after those, one scan in so many: from one place errors repeat
    mode: Annotated[Literal["invariant", "paper"], Meta(meaning="form of the filter; paper: as printed")] = (
        "invariant"
    )
    sighting_noise: Annotated[
        Literal["corner", "paper"], Meta(meaning="every corner's own covariance, or R of eq. 43")
    ] = "corner"
    range_sd: Annotated[float, Meta("m", 0.001, 2, "sd of a sighting's range (eq. 43)")] = 0.08
    bearing_sd: Annotated[float, Meta("rad", 5e-4, 0.8, "sd of a sighting's bearing (eq. 43)")] = math.radians(1)
    soft_gate: Annotated[
        float, Meta("χ²", 0, 100, "squared distance from which a sighting is trusted less; 0: never")
    ] = 2.0


class EkfSlam:
    """Estimator of pose and landmarks: `advance` with every move, `see` with every scan."""

    def __init__(self, ekf: EkfSettings | None = None, laser: Laser | None = None) -> None:
        self.settings = ekf or EkfSettings()
        self.filter = FORMS[self.settings.mode]()
        self.table = LandmarkTable(self.settings)
        self._landmarks: tuple[Landmark, ...] | None = ()
        self.associations: tuple[Association, ...] = ()
        self._laser = laser
        self._travelled = 0.0  # [m]
        self._moved = False  # since the last scan
        self._resting = 0  # scans in the present rest
        self._looked = 0  # scans at rest in all
        self._updates = 0
        self._nis: float | None = None
        self._usual = AdaptiveGate(self.settings.soft_memory, self.settings.soft_slack)
        self._slipped = False  # by the newest sightings

    def resume(self, records: Sequence[LandmarkRecord]) -> None:
        """Go on with these rows of landmarks, which the filter has already."""
        self.table.resume(records)
        self._landmarks = None

    def advance(self, increment: Increment) -> None:
        """Predict over a move; while the wheels stand nothing is added."""
        if not increment.still:
            self._moved = True
            way = math.hypot(increment.pose.x, increment.pose.y)
            self._travelled += way
            self.table.travelled += way
            self.filter.predict(increment)

    def see(self, sightings: Sequence[Sighting], view: VisibilityCheck | None = None) -> None:
        """Correct by what was sighted from here."""
        self._resting = 0 if self._moved else self._resting + 1
        self._looked += not self._moved
        self._moved = False
        over = self._resting - self.settings.still_scans
        if over > 0 and over % self.settings.still_every:
            return
        self._updates += 1
        look = self._look(tuple(sightings))
        assignment = self._assign(look)
        self._correct(look, assignment)
        self._admit(look, assignment)
        self._miss(look, assignment, view)
        join_doubles(self.filter, self.table, [index for _, index in assignment.matches], self.settings)
        for index in reversed(self.table.lost.tolist()):
            self.filter.drop(index)
            self.table.forget(index)
        self._publish(look)

    @property
    def pose(self) -> Pose:
        """The robot's pose."""
        return self.filter.pose

    @property
    def estimate(self) -> Estimate:
        """The pose and its covariance in the world's axes."""
        return Estimate(pose=self.filter.pose, covariance=self.filter.pose_covariance())

    @property
    def landmarks(self) -> tuple[Landmark, ...]:
        """The landmarks of the map, as of the newest sightings."""
        if self._landmarks is None:
            rows, standing = self.table.records, np.flatnonzero(self.table.standing).tolist()
            spreads = self.filter.place_covariances()
            self._landmarks = tuple(
                Landmark(
                    id=rows[index].id,
                    position=self.filter.places[index],
                    covariance=spreads[index],
                    hits=rows[index].hits,
                    misses=rows[index].misses,
                    kind=rows[index].kind,
                )
                for index in standing
            )
        return self._landmarks

    @property
    def health(self) -> SlamHealth:
        """The filter's health."""
        fates = [association.fate for association in self.associations]
        return SlamHealth(
            mode=self.settings.mode,
            updates=self._updates,
            nis=self._nis,
            matched=fates.count("matched"),
            ignored=fates.count("ignored"),
            tentative=int((~self.table.believed).sum()),
            looking_around=self.looking_around,
            slipping=self._slipped,
        )

    @property
    def looking_around(self) -> bool:
        """The still start is not over: the first move had better wait.

        Landmarks first seen from a place that is known exactly carry the whole map (worst run 0.083 → 0.021 m). Once
        the robot has moved, waiting brings nothing any more.
        """
        return self._laser is not None and self._looked < self.settings.still_scans and self._travelled < 0.05

    def nees(self, truth: Pose) -> float:
        """Normalised error squared of the pose, ideal mean 3; NaN before the first move. For scoring only."""
        self.filter.settle()
        return squared_error(self.filter.error(truth), self.filter.covariance.block(0, 3))

    def _look(self, seen: tuple[Sighting, ...]) -> Observation:
        settings = self.settings
        as_printed = np.diag([settings.range_sd**2, settings.bearing_sd**2])
        noises = [as_printed if settings.sighting_noise == "paper" else sighting.covariance for sighting in seen]
        return Observation(
            seen,
            np.array([(sighting.range, sighting.bearing) for sighting in seen]).reshape(-1, 2),
            np.array(noises).reshape(-1, 2, 2),
            *self.filter.expect(),
            fates=[("ignored", None)] * len(seen),
        )

    def _assign(self, look: Observation) -> Assignment:
        """Sightings → landmarks: by their identities where these are known, else by distance."""
        if all(sighting.id is None for sighting in look.seen):
            return recognise(look, self.filter, self.table, self.settings)
        known = self.table.identities
        matches = tuple((row, known[s.id]) for row, s in enumerate(look.seen) if s.id in known)
        fresh = {s.id: row for row, s in reversed(list(enumerate(look.seen))) if s.id not in known}
        return Assignment(matches, tuple(sorted(fresh.values())))

    def _correct(self, look: Observation, assignment: Assignment) -> None:
        """Count the hits, and let the landmarks past their probation correct the state, all at once."""
        used: list[tuple[int, int]] = []
        self._slipped = False
        for row, index in assignment.matches:
            number, believed = self.table.hit(index, look.seen[row], self.filter.pose.heading)
            look.fates[row] = ("matched" if believed else "tentative", number)
            if believed:
                used.append((row, index))
        if not used:
            return
        rows, indices = np.array(used).T
        readings, noises = look.readings[rows], look.noises[rows]
        innovation = self.filter.innovate(indices, readings)
        self._note(innovation, noises)
        total = with_noise(innovation.state, noises)
        odd = mahalanobis(total, innovation.residuals)
        if self._notice_slip(indices, innovation, total, odd):
            innovation = self.filter.innovate(indices, readings)
            total = with_noise(innovation.state, noises)
            odd = mahalanobis(total, innovation.residuals)
        if self.settings.soft_gate > 0:
            wider = self._usual.factor if len(rows) < self.settings.slip_fewest else 1.0
            weights = trust(total, noises, innovation.residuals, odd, wider * self.settings.soft_gate)
            total = with_noise(total, (weights - 1.0)[:, None, None] * noises)
        self.filter.take_in(innovation, total)

    def _note(self, innovation: Innovation, noises: Array) -> None:
        """The running NIS: every sighting by its own covariance, before anything is softened."""
        count = len(noises)
        own = innovation.state.reshape(count, 2, count, 2)[np.arange(count), :, np.arange(count), :]
        distances = squared_distance(innovation.residuals, own + noises)[0].tolist()
        if count < self.settings.slip_fewest:  # more of them show by each other whether the robot errs
            self._usual.note(distances)
        for distance in distances:
            self._nis = distance / 2 if self._nis is None else NIS_FADE * self._nis + (1 - NIS_FADE) * distance / 2

    def _notice_slip(self, indices: Array, innovation: Innovation, total: Array, odd: Array) -> bool:
        """Return whether the sightings together say that the robot is elsewhere; then its pose is put in doubt."""
        if np.count_nonzero(odd > self.settings.slip_odd) < self.settings.slip_fewest:
            return False
        unnoticed = self.settings.unnoticed
        moved = self.filter.perturbed(indices, unnoticed)
        self._slipped = displaced(total, innovation.residuals, odd, moved, self.settings)
        if self._slipped:
            self.filter.doubt(unnoticed)
        return self._slipped

    def _admit(self, look: Observation, assignment: Assignment) -> None:
        """New landmarks join the state at once, on probation: they keep their first sighting and its own pose."""
        for row in assignment.fresh:
            if len(self.table) < self.settings.most and self.table.has_room(look.seen[row]):
                self.filter.add(look.readings[row], look.noises[row])
                look.fates[row] = ("new", self.table.add(look.seen[row], self.filter.pose.heading))

    def _miss(self, look: Observation, assignment: Assignment, view: VisibilityCheck | None) -> None:
        """Count a miss where a landmark should have been seen and was not."""
        unseen = np.ones(len(look.expectations), dtype=bool)
        unseen[[index for _, index in assignment.matches]] = False
        missing = np.flatnonzero(unseen)
        self.table.pass_over(missing)
        if view is None or not len(missing):
            return
        pose = self.filter.pose
        places = pose.inverse().apply(self.filter.places[missing])
        spreads = np.sqrt(np.trace(self.filter.place_covariances()[missing], axis1=1, axis2=2))
        plain, through = view.judge(places, spreads)
        back = np.arctan2(-places[:, 1], -places[:, 0]) + pose.heading
        expected = self.table.expected(missing, np.hypot(*places.T), back)
        self.table.miss(missing[through | (plain & expected)])

    def _publish(self, look: Observation) -> None:
        self._landmarks = None
        pose, (reaches, bearings) = self.filter.pose, look.readings.T
        directions = np.column_stack((np.cos(bearings + pose.heading), np.sin(bearings + pose.heading)))
        self.associations = tuple(
            Association(position=position, landmark=landmark, fate=fate)
            for position, (fate, landmark) in zip(
                (pose.x, pose.y) + reaches[:, None] * directions, look.fates, strict=True
            )
        )
