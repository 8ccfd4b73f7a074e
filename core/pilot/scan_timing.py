"""Timing of the scans: each laser's time offset, estimated and taken out before anything is perceived."""

from dataclasses import replace

from core.robots import Profile
from core.sensors import Fault, Laser, Scan, SensorFrame
from core.slam.motion import Motion
from core.slam.scan_matching.agreement import late_scans
from core.slam.scan_matching.time_offset import Estimated, TimeOffset, TimeOffsetEstimator, TimeOffsetSettings

REMARKABLE_OFFSET_S = 0.02  # off what is configured, from which the operator hears of it
REMARK_SD_S = 0.005  # sd of a figure that is shown to the operator, at most
MIN_OFFSET_SDS = 3.0  # sd by which stamps must be off before they are corrected


class ScanTiming:
    """One estimator per laser. Without odometry nothing is estimated, and only the configured offsets count."""

    def __init__(self, profile: Profile, settings: TimeOffsetSettings) -> None:
        self._settings = settings
        self._lasers = {laser.name: laser for laser in profile.lasers}
        self._laser = profile.laser or Laser()  # of scans that name none
        self._estimators = {
            laser.name: TimeOffsetEstimator(laser, settings) for laser in (*profile.lasers, self._laser)
        }
        self._offsets: dict[str, TimeOffset] = {}

    @property
    def offsets(self) -> tuple[TimeOffset, ...]:
        """The time offsets of the lasers of which they are known."""
        return tuple(self._offsets.values())

    def correct(self, frame: SensorFrame, motion: Motion, lateness: float = 0.0) -> SensorFrame:
        """The frame, its scan stamped on the odometry's clock.

        `lateness`: what is to be added by a coarser estimate, where this one finds nothing [s]; a scan of the future
        is not made of it.
        """
        laser = None if frame.scan is None else self._lasers.get(frame.scan.laser, self._laser)
        frame = _shifted(frame, laser.time_offset if laser else 0.0)
        if self._settings.estimate and not motion.by_scans:
            for name, estimator in self._estimators.items():
                own = laser is not None and laser.name == name
                estimator.update(frame.stamp, frame.wheels, frame.scan if own else None)
        if laser is None:
            return frame
        found = self._estimators[laser.name].newest
        if found is None:
            return _shifted(frame, min(lateness, 0.0))
        correction = self._correction(found)
        self._offsets[laser.name] = TimeOffset(
            laser=laser.name,
            offset=laser.time_offset + found.offset,
            sd=found.variance**0.5,
            applied=laser.time_offset + correction,
        )
        return _shifted(frame, correction)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Lasers whose stamps are surely wrong, beyond what is configured; they are corrected."""
        return tuple(
            late_scans(name or self._laser.name, timing.offset)
            for name, timing in self._offsets.items()
            if abs(timing.applied - self._lasers.get(name, self._laser).time_offset) > REMARKABLE_OFFSET_S
            and timing.sd < REMARK_SD_S
        )

    def _correction(self, found: Estimated) -> float:
        """Correction of the stamps beyond what is configured [s]; none as long as chance may explain it."""
        sure = max(self._settings.corrected, MIN_OFFSET_SDS * found.variance**0.5)
        return found.offset if abs(found.offset) > sure else 0.0


def _shifted(frame: SensorFrame, offset: float) -> SensorFrame:
    """The frame, its scan stamped later by `offset` [s]."""
    scan: Scan | None = frame.scan
    if scan is None or offset == 0.0:
        return frame
    return replace(frame, scan=replace(scan, stamp=scan.stamp + offset))
