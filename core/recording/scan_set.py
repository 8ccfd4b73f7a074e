"""Scan sets: an archive with `t` (N,) [s], `scan_cm` (N, beams) [cm] and, with odometry, `odo_raw` (N, 3)."""

from core.errors import BadInput
from core.recording.clocks import evenly_spread, seconds_per_unit
from core.recording.npz import Archive
from core.recording.odometry_checks import believable_track
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording, stamped
from core.recording.scans import in_time_order, make_scan, scan_recording, spread
from core.sensors import Scan

MAX_RANGE_M = 81.0  # readings from here on mean that nothing came back


def read(archive: Archive, settings: LogSettings) -> ScanRecording:
    """The beams stand every 180°/n from -90° on, the laser at the robot's origin. Raises BadInput."""
    tally = ReadReport(archive.path)
    times, ranges = archive.floats("t"), archive.floats("scan_cm", 0) / 100
    poses = archive.floats("odo_raw", 3) if "odo_raw" in archive.names else None
    if len(times) != len(ranges) or (poses is not None and len(poses) != len(times)):
        raise BadInput(f"t, scan_cm and odo_raw in {archive.path.name} have different lengths.")
    if ranges.nbytes > 2 * settings.most_readings:
        raise BadInput(f"{archive.path.name} holds more scans than log.most_readings_mb of the settings allows.")
    scans: list[Scan] = []
    used: list[int] = []
    limits = (0.0, settings.range_max or MAX_RANGE_M)
    for number, (stamp, row) in enumerate(zip(times.tolist(), ranges, strict=True)):
        try:
            scans.append(make_scan(stamp, row, spread(max(1, ranges.shape[1])), limits))
            used.append(number)
            tally.read += 1
        except BadRecord as problem:
            tally.skip(str(problem), f"row {number}")
    if not scans:
        raise BadInput(f"{archive.path.name} holds no scan that can be used. {tally.reasons()}")
    stamps = times[used] * seconds_per_unit(times[used], "t", tally)
    stamps = evenly_spread(stamps, tally, "t")
    scans = in_time_order([stamped(scan, float(stamp)) for scan, stamp in zip(scans, stamps, strict=True)], tally)
    wanted = poses is not None and settings.odometry_topic != "none"
    track = believable_track("odo_raw", stamps, poses[used], None, tally) if wanted and poses is not None else None
    tally.topics = ["scan_cm: laser"] + (["odo_raw: odometry"] if track is not None else [])
    return scan_recording(archive.path, scans, track, tally, "scan set", settings)
