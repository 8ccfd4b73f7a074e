"""Sense and heading of a laser by its scans and the odometry, in a log that does not state them."""

import itertools
import math
from dataclasses import replace

from core.geometry import wrap
from core.recording.recording import ScanRecording
from core.recording.scans import turned_over
from core.sensors.checks import Fault, fault

MIRRORED, ASIDE = "agreement.mirrored", "agreement.mount"
TRACK_MIRRORED = "odometry.mirrored"
MAX_JUDGED_SCANS = 1500  # from the beginning of a log
MIN_TURNED_RAD = math.radians(15)  # of a laser: less may come from its place on the robot
SQUARE_RAD = math.radians(6)  # from a right angle, at which lasers are mounted mostly


def with_laser_as_driven(recording: ScanRecording, *, sense: bool = True, heading: bool = True) -> ScanRecording:
    """Turn the scans over, and the laser about its axis, where the odometry shows it and the log states neither.

    `sense`, `heading`: which of both may be changed. Where scans and odometry do not agree afterwards, the recording
    stays as it is.
    """
    if recording.track is None:
        return recording
    read, changes = recording, list[Fault]()
    found = _disagreement(read)
    if MIRRORED in found and any(one.code == TRACK_MIRRORED for one in read.report.faults):
        read = _by_its_places(read)
        found = _disagreement(read)
    if sense and MIRRORED in found:
        scans = tuple(turned_over(scan) for scan in read.scans)
        read = replace(read, scans=scans, laser=replace(read.laser, angle_min=scans[0].angle_min))
        changes.append(fault("scan.mirrored", "the laser", used=True))
        found = _disagreement(read)
    if heading and ASIDE in found:
        turned = _squared(float(found[ASIDE].values["heading"]))
        read = replace(read, laser=replace(read.laser, mounting=replace(read.laser.mounting, heading=turned)))
        degrees = f"{math.degrees(turned):.0f}"
        changes.append(fault("mount.turned", "the laser", used=True, degrees=degrees, heading=f"{turned:.2f}"))
        found = _disagreement(read)
    return recording if found else read.with_faults(tuple(changes))


def _by_its_places(recording: ScanRecording) -> ScanRecording:
    """The recording whose odometry was mirrored by its headings, mirrored back by its places: the scans turn as these
    did, so the headings were wrong.
    """
    assert recording.track is not None
    believed = next(one for one in recording.report.faults if one.code == TRACK_MIRRORED)
    report = replace(
        recording.report,
        faults=tuple(one for one in recording.report.faults if one != believed),
        warnings=tuple(one for one in recording.report.warnings if one != believed.sentence),
    )
    back = replace(recording, track=recording.track.mirrored, report=report)
    return back.with_faults((fault("odometry.clockwise", believed.sensor, used=True),))


def _disagreement(recording: ScanRecording) -> dict[str, Fault]:
    """Find what is wrong with sense and heading of the laser, by the beginning of a recording; empty: nothing."""
    from core.slam.scan_matching.agreement import SenseAgreement  # late: drivers do without scipy

    agreement = SenseAgreement(recording.laser)
    for frame in itertools.islice(recording, MAX_JUDGED_SCANS):
        if frame.wheels is not None:
            agreement.update(frame.stamp, frame.wheels, frame.scan)
        if agreement.decided:
            return {}
    agreement.finish()
    found = {one.code: one for one in agreement.faults if one.code in (MIRRORED, ASIDE)}
    if ASIDE in found:
        off = wrap(float(found[ASIDE].values["heading"]) - recording.laser.mounting.heading)
        return found if abs(off) > MIN_TURNED_RAD else {code: found[code] for code in found if code != ASIDE}
    return found


def _squared(heading: float) -> float:
    """A heading [rad], or the right angle that is near."""
    square = wrap(round(heading / (math.pi / 2)) * (math.pi / 2))
    return square if abs(wrap(heading - square)) < SQUARE_RAD else heading
