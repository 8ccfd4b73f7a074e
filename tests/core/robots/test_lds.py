"""Turning lidars through lds2d against emulators of three protocols, in the simulated lab."""

import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.message import Array
from core.robots.lds import MODELS, LidarDevice, TurnCollector, laser_of, open_device
from core.robots.nearness import field_of
from core.sensors import Laser, Scan
from tests.core.robots.links import frames, live, memory, no_leak, until
from tests.emulators.lds import AROUND, TURNS, LidarEmulator
from tests.emulators.wires import bit_flips, malformed
from tests.emulators.world import World


def emulated(model: str, path: Path | None) -> Iterator[LidarEmulator]:
    world = World()
    emulator = LidarEmulator(world, model, path=path)
    emulator.start()
    world.start()
    yield emulator
    world.stop()
    emulator.stop()


@pytest.fixture(params=sorted(TURNS))
def lidar(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[LidarEmulator]:
    yield from emulated(request.param, tmp_path / "ttyUSB0")


@pytest.fixture
def ld19() -> Iterator[LidarEmulator]:
    yield from emulated("ld19", None)


def device_of(emulator: LidarEmulator) -> LidarDevice:
    return open_device(emulator.url.removeprefix("lds:"))


def room(emulator: LidarEmulator, scan: Scan) -> Array:
    """What the emulator's room has at the beams of a scan, [m]."""
    beams = np.round((scan.angles + math.pi) / (math.tau / AROUND)).astype(int) % AROUND
    return emulator.ranges[beams]


def test_a_turn_becomes_a_scan_that_runs_counter_clockwise(lidar: LidarEmulator) -> None:
    rate = TURNS[lidar.model][1]
    with live(device_of(lidar)) as robot:
        scans = [frame.scan for frame in frames(robot, 2.2) if frame.scan is not None]
    stamps = np.array([scan.stamp for scan in scans])
    assert len(scans) >= 2.2 * rate * 0.7 - 2
    assert (np.diff(stamps) > 0).all() and np.median(np.diff(stamps)) == pytest.approx(1 / rate, rel=0.15)
    scan = scans[-1]
    seen = scan.valid
    errors = np.abs(scan.ranges - room(lidar, scan))[seen]
    assert seen.mean() > 0.85
    assert np.median(errors) < 0.06 and np.mean(errors < 0.25) > 0.9  # the noise of two turns
    turns = [one.time_step * len(one.ranges) for one in scans]  # as they arrive: on a busy machine one is late
    assert np.median(turns) == pytest.approx(-1 / rate, rel=0.2)


def test_the_lidar_sees_all_around() -> None:
    for model in MODELS.values():
        laser = laser_of(model)
        assert field_of(laser) == math.pi
        assert laser.angle_min + laser.beams * laser.angle_step == pytest.approx(math.pi)


def test_every_model_is_one_that_lds2d_knows() -> None:
    from lds2d.core import driver_for

    assert [name for name, model in MODELS.items() if driver_for(model.driver) is None] == []


def turns(points: list[tuple[float, float]], beams: int = 36) -> list[Scan]:
    """Points (clockwise [degrees], [m]), 1 ms apart → scans."""
    laser = Laser(beams=beams, angle_min=-math.pi, angle_step=math.tau / beams, range_min=0.1, range_max=10.0)
    collector = TurnCollector(laser)
    found = [collector.add(math.radians(angle), metres, 1e-3 * n) for n, (angle, metres) in enumerate(points)]
    return [scan for scan in found if scan is not None]


def head(count: int, step: float = 10.0) -> list[tuple[float, float]]:
    """A turning head: a point every `step` degrees, whose distance tells its angle."""
    return [(step * n % 360, 1.0 + (step * n % 360) / 100) for n in range(count)]


def test_the_first_turn_counts_once_it_was_seen_from_its_begin() -> None:
    scans = turns(head(36 * 4))
    assert len(scans) == 3 and all(np.isfinite(scan.ranges).all() for scan in scans)
    clockwise = np.degrees(-scans[0].angles) % 360
    assert np.allclose(scans[0].ranges, 1.0 + clockwise / 100)
    assert scans[0].time_step == pytest.approx(-1e-3)


def test_angles_that_jitter_at_the_seam_end_no_turn_twice() -> None:
    rng = np.random.default_rng(1)
    points = [((angle + rng.normal(0, 4)) % 360, metres) for angle, metres in head(360 * 5, 1.0)]
    scans = turns(points)
    assert len(scans) == 4
    assert all(np.isfinite(scan.ranges).all() for scan in scans)


def test_an_echo_out_of_range_is_no_echo_and_of_two_the_nearer_one_counts() -> None:
    points = head(36 * 3)
    points[40:42] = [(40.0, 0.0), (50.0, 50.0)]
    points.insert(45, (80.5, 0.5))
    scan = turns(points)[0]
    clockwise = np.round(np.degrees(-scan.angles) % 360)
    assert np.isnan(scan.ranges[np.isin(clockwise, (40, 50))]).all()
    assert scan.ranges[clockwise == 80].tolist() == [0.5]


def test_the_motor_of_an_rplidar_a2_is_started(monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[bytes] = []

    class Deaf:
        def read(self, timeout: float) -> bytes:
            return b""

        def write(self, data: bytes) -> None:
            heard.append(data)

        def close(self) -> None:
            heard.append(b"closed")

    def link(address: object, baud: int, *, dtr: bool) -> Deaf:
        assert (baud, dtr) == (115200, False)  # the adapter's motor turns while DTR is low
        return Deaf()

    monkeypatch.setattr("core.robots.lds.open_link", link)
    monkeypatch.setattr("core.robots.lds.OPENING_TIMEOUT_S", 0.0)
    device = open_device("///dev/x?model=rplidar-a2")
    with pytest.raises(Unavailable):
        device.open()
    device.close()
    assert heard == [b"\xa5\x25", b"\xa5\xf0\x02\x94\x02\xc1", b"\xa5\x20", b"\xa5\x25", b"closed"]


def test_flipped_bits_are_noticed_and_the_scans_stay_right(ld19: LidarEmulator) -> None:
    ld19.port.mangle = bit_flips(np.random.default_rng(6), 0.3)
    with live(device_of(ld19)) as robot:
        scans = [frame.scan for frame in frames(robot, 2.0) if frame.scan is not None]
    assert len(scans) >= 10
    for scan in scans:
        errors = np.abs(scan.ranges - room(ld19, scan))[scan.valid]
        assert scan.valid.mean() > 0.4 and np.mean(errors < 0.25) > 0.9


def test_after_it_was_unplugged_it_is_found_again(lidar: LidarEmulator) -> None:
    with no_leak(), live(device_of(lidar)) as robot:
        until(lambda: robot.read().scan is not None)
        lidar.stop()
        until(lambda: "was lost" in " ".join(robot.read().notes))
        lidar.start()
        until(lambda: robot.read().scan is not None, 15.0)


def test_a_head_that_stands_still_is_lost(ld19: LidarEmulator) -> None:
    with live(device_of(ld19)) as robot:
        until(lambda: robot.read().scan is not None)
        ld19.turning = False
        until(lambda: "was lost" in " ".join(robot.read().notes))
        ld19.turning = True
        until(lambda: robot.read().scan is not None, 15.0)


def fuzz(emulator: LidarEmulator, count: int) -> float:
    """Malformed messages → memory's growth in the second half [MB]."""
    rng, before = np.random.default_rng(4), 0.0
    samples = emulator.packets()[:5]
    with live(device_of(emulator)) as robot:
        for number in range(count):
            if number == count // 2:
                before = memory()
            until(lambda: emulator.inject(malformed(rng, samples[int(rng.integers(len(samples)))])), 30.0)
            if number % 20 == 0:
                scan = robot.read().scan
                assert scan is None or np.isfinite(scan.stamp)
        growth = memory() - before
        until(lambda: robot.read().scan is not None, 30.0)
    return growth


def test_malformed_bytes_do_not_end_the_driver(lidar: LidarEmulator) -> None:
    assert fuzz(lidar, 500) < 20


@pytest.mark.campaign
def test_a_hundred_thousand_malformed_messages(lidar: LidarEmulator) -> None:
    assert fuzz(lidar, 100_000) < 20


@pytest.mark.parametrize(
    "rest", ["", "///dev/x", "///dev/x?model=sick", "///dev/x?model=ld19&baud=x", "//?model=ld19"]
)
def test_an_address_that_cannot_be_is_a_sentence(rest: str) -> None:
    with pytest.raises(BadInput, match=r"\.$"):
        open_device(rest)


def test_a_lidar_that_does_not_measure_is_a_sentence(ld19: LidarEmulator, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("core.robots.lds.OPENING_TIMEOUT_S", 0.5)
    ld19.turning = False
    device = device_of(ld19)
    with pytest.raises(Unavailable, match="no ld19 measures"):
        device.open()
    device.close()


def test_without_the_package_the_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr("core.robots.lds.import_module", missing)
    with pytest.raises(Unavailable, match=re.escape(install_extra("hardware"))):
        open_device("///dev/none?model=ld19").open()
