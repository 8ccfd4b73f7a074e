"""The Hokuyo's driver against an emulator on a pseudo-terminal and on TCP."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.message import Array
from core.robots.scip import (
    BadReply,
    ScipLaser,
    ScipParameters,
    SensorTime,
    checksum,
    decode,
    in_metres,
    laser_of,
    open_device,
    parse_parameters,
    parse_scan,
)
from core.sensors import Scan
from tests.core.robots.links import frames, live, memory, no_leak, until
from tests.emulators.scip import FIRST, LAST, ScipEmulator, encode, with_sum
from tests.emulators.wires import bit_flips, malformed

RECORDING = Path(__file__).parents[4] / "shared/data/urg04lx_handheld/urg04lx_handheld.mcap"


@contextmanager
def turning(sensor: ScipEmulator, scans: list[Array], period: float = 0.1) -> Iterator[None]:
    """The emulator with a turning mirror: the scans given, one after another and again from the first."""
    over = threading.Event()

    def turn() -> None:
        due, number = time.monotonic(), 0
        while not over.wait(max(0.0, due - time.monotonic())):
            sensor.show(scans[number % len(scans)])
            due, number = due + period, number + 1

    thread = threading.Thread(target=turn, daemon=True)
    sensor.start()
    thread.start()
    yield
    over.set()
    thread.join()
    sensor.stop()


def room(number: int, beams: int = LAST - FIRST + 1) -> Array:
    """A scan that no other equals, [mm]."""
    return np.random.default_rng(number).integers(20, 5601, beams)


@pytest.fixture(params=[pytest.param("tcp", marks=pytest.mark.campaign), "serial"])
def sensor(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[ScipEmulator]:
    emulator = ScipEmulator(path=tmp_path / "ttyACM0" if request.param == "serial" else None)
    with turning(emulator, [room(number) for number in range(100)]):
        yield emulator


@pytest.fixture
def quick_sensor() -> Iterator[ScipEmulator]:
    """Three times as quick as a real one."""
    emulator = ScipEmulator()
    with turning(emulator, [room(number) for number in range(100)], period=0.035):
        yield emulator


def device_of(emulator: ScipEmulator, options: str = "") -> ScipLaser:
    return open_device(emulator.url.removeprefix("scip:") + options)


def scans_of(emulator: ScipEmulator, seconds: float, options: str = "") -> list[Scan]:
    with live(device_of(emulator, options)) as robot:
        return [frame.scan for frame in frames(robot, seconds) if frame.scan is not None]


@pytest.mark.parametrize(
    ("line", "total"),
    [
        *(("00", "P"), ("99", "b"), ("01", "Q"), ("02", "R"), ("10", "Q"), ("0E", "e"), ("DMIN:20", "4")),
        *(("DMAX:5600", "_"), ("ARES:1024", "\\"), ("AMIN:44", "7"), ("AMAX:725", "o"), ("AFRT:384", "6")),
        ("SCAN:600", "e"),
    ],
)
def test_sums_are_those_of_the_manual(line: str, total: str) -> None:
    assert chr(checksum(line.encode())) == total


@pytest.mark.parametrize(
    ("characters", "number"),
    [("CB", 1234), ("1Dh", 5432), ("00D", 20), ("1GP", 5600), ("0001", 1), ("m2@0", 16_000_000)],
)
def test_numbers_are_those_of_the_manual(characters: str, number: int) -> None:
    assert decode(characters.encode(), len(characters)).tolist() == [number]
    assert encode(np.array([number]), len(characters)) == characters.encode()


def test_a_full_frame_has_the_length_of_the_manual() -> None:
    command = b"MD0044072501000"
    reply = ScipEmulator().reply(command, 44, 725, 1, room(1))
    lines = reply.rstrip(b"\n").split(b"\n")
    assert (len(reply), len(lines) - 3, len(lines[-1]) - 1) == (2137, 32, 62)
    assert parse_scan(lines[2:], 682)[1].tolist() == room(1).tolist()


def test_values_below_20_are_error_codes_and_no_obstacles() -> None:
    parameters = device_parameters()
    ranges = in_metres(np.array([0, 1, 7, 18, 19, 20, 5600, 5601]), parameters)
    assert np.isnan(ranges[[0, 1, 2, 3, 4, 7]]).all() and ranges[5:7].tolist() == [0.02, 5.6]


def device_parameters() -> ScipParameters:
    lines = ScipEmulator().answer(b"PP").rstrip(b"\n").split(b"\n")
    return parse_parameters(lines)


def test_the_geometry_is_what_the_sensor_says() -> None:
    laser = laser_of(device_parameters(), skip=0, cluster=1)
    last = laser.angle_min + (laser.beams - 1) * laser.angle_step
    assert laser.beams == 682 and math.degrees(laser.angle_min) == pytest.approx(-119.53, abs=0.005)
    assert math.degrees(last) == pytest.approx(119.88, abs=0.005)
    assert laser.rate == pytest.approx(10.0) and laser.time_step == pytest.approx(97.66e-6, rel=1e-4)
    clustered = laser_of(device_parameters(), skip=2, cluster=3)
    assert clustered.beams == 228 and clustered.rate == pytest.approx(10 / 3)
    assert clustered.angle_min == pytest.approx(laser.angle_min + laser.angle_step)


def test_scans_arrive_at_the_sensors_rate_exact_and_on_time(sensor: ScipEmulator) -> None:
    with live(device_of(sensor)) as robot:
        zero = time.monotonic() - robot._readings.now()
        scans = [frame.scan for frame in frames(robot, 2.0) if frame.scan is not None]
    stamps = np.array([scan.stamp for scan in scans])
    sent = np.array([begin - zero for begin, _ in sensor.sent])
    truth = {tuple(ranges.tolist()): begin for (_, ranges), begin in zip(sensor.sent, sent, strict=True)}
    errors = [
        scan.stamp - FIRST * 0.1 / 1024 - truth[tuple((scan.ranges * 1e3).round().astype(int).tolist())]
        for scan in scans
    ]
    assert len(scans) >= 16 and (np.diff(stamps) > 0).all()
    assert np.median(np.diff(stamps)) == pytest.approx(0.1, abs=0.003)
    assert np.median(np.abs(errors)) < 0.003


@pytest.mark.parametrize("state", ["streaming", "time mode", "SCIP 1.1", "half a command", "unread stream"])
def test_the_start_recovers_from_any_state(sensor: ScipEmulator, state: str) -> None:
    if state == "time mode":
        sensor.in_time_mode = True
    elif state == "SCIP 1.1":
        sensor.old = True
    elif state == "half a command":
        sensor.stop()
        sensor.half_heard = b"MD004"
        sensor.start()
    else:
        sensor.streaming = (b"MD0044072501000", FIRST, LAST, 1)
        time.sleep(0.3 if state == "unread stream" else 0.0)
    assert len(scans_of(sensor, 0.8)) >= 4


def test_a_skip_and_a_cluster_are_asked_for_and_understood(sensor: ScipEmulator) -> None:
    scans = scans_of(sensor, 2.5, "?skip=1&cluster=3")
    assert 9 <= len(scans) <= 13 and {len(scan.ranges) for scan in scans} == {228}
    sent = {tuple(ranges[:3].tolist()) for _, ranges in sensor.sent}
    assert all(round(float(scan.ranges[0]) * 1e3) in {min(first) for first in sent} for scan in scans)


def test_of_replies_with_flipped_bits_only_the_correct_ones_are_delivered(quick_sensor: ScipEmulator) -> None:
    sensor = quick_sensor
    device = device_of(sensor)
    with live(device) as robot:
        sensor.port.mangle = bit_flips(np.random.default_rng(7), 0.3)
        scans = [frame.scan for frame in frames(robot, 2.5) if frame.scan is not None]
    sensor.port.mangle = None
    sent = {tuple(ranges.tolist()) for _, ranges in sensor.sent}
    delivered = [tuple((scan.ranges * 1e3).round().astype(int).tolist()) for scan in scans]
    assert set(delivered) <= sent and len(delivered) == len(set(delivered))
    assert 30 <= len(delivered) <= 58 and device.rejected >= 8


def test_the_start_recovers_while_bits_are_flipped(quick_sensor: ScipEmulator) -> None:
    sensor = quick_sensor
    sensor.port.mangle = bit_flips(np.random.default_rng(8), 0.3)
    for _ in range(3):
        try:
            assert scans_of(sensor, 0.8)
        except Unavailable:
            continue
        return
    pytest.fail("the laser was never reached")


def test_after_the_sensor_was_unplugged_it_is_found_again(sensor: ScipEmulator) -> None:
    with no_leak(), live(device_of(sensor)) as robot:
        until(lambda: robot.read().scan is not None)
        sensor.stop()
        until(lambda: "was lost" in " ".join(robot.read().notes))
        sensor.start()
        until(lambda: robot.read().scan is not None)


def test_a_sensor_that_falls_silent_is_started_again(sensor: ScipEmulator) -> None:
    with live(device_of(sensor)) as robot:
        until(lambda: robot.read().scan is not None)
        sensor.streaming = None
        until(lambda: robot.read().scan is None)
        until(lambda: robot.read().scan is not None, 10.0)


def fuzz(sensor: ScipEmulator, count: int) -> tuple[int, float]:
    """`count` malformed messages → wrong scans that were delivered, memory's growth [MB] in the second half."""
    rng = np.random.default_rng(9)
    good = sensor.reply(b"MD0044072501000", FIRST, LAST, 1, np.full(LAST - FIRST + 1, 777))
    wrong, before = 0, 0.0
    with live(device_of(sensor)) as robot:
        for number in range(count):
            if number == count // 2:
                before = memory()
            until(lambda: sensor.inject(malformed(rng, good)), 30.0)
            scan = robot.read().scan
            wrong += scan is not None and tuple((scan.ranges * 1e3).round()) not in fuzz_sent(sensor)
        growth = memory() - before
        until(lambda: robot.read().scan is not None, 20.0)
    return wrong, growth


def fuzz_sent(sensor: ScipEmulator) -> set[tuple[float, ...]]:
    return {tuple(ranges.astype(float)) for _, ranges in sensor.sent[-20:]} | {(777.0,) * (LAST - FIRST + 1)}


def test_malformed_bytes_neither_end_the_driver_nor_become_scans(quick_sensor: ScipEmulator) -> None:
    wrong, growth = fuzz(quick_sensor, 500)
    assert wrong == 0 and growth < 20


@pytest.mark.campaign
def test_a_hundred_thousand_malformed_messages() -> None:
    emulator = ScipEmulator()
    with turning(emulator, [room(number) for number in range(100)], period=0.035):
        wrong, growth = fuzz(emulator, 100_000)
    assert wrong < 100 and growth < 20  # some flipped bits cancel out in the sensor's sums of 6 bits


@pytest.mark.real_data
def test_a_recording_of_a_real_sensor_goes_over_the_wire_unchanged() -> None:
    if not RECORDING.exists():
        pytest.skip("the recording urg04lx_handheld is not there")
    recorded = recorded_scans(25)
    emulator = ScipEmulator(last=724)
    with turning(emulator, recorded):
        scans = scans_of(emulator, 2.0)
    known = [np.where(ranges >= 20, ranges / 1000, np.nan) for ranges in recorded]
    assert len(scans) >= 15
    assert scans[0].angle_min == pytest.approx(-2.08621, abs=1e-5)
    assert all(any(np.array_equal(scan.ranges, one, equal_nan=True) for one in known) for scan in scans)


def recorded_scans(count: int) -> list[Array]:
    """(681,) [mm] each, 0 where the sensor measured nothing."""
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    scans: list[Array] = []
    with RECORDING.open("rb") as file:
        for _, _, record in make_reader(file).iter_messages(topics=["/scan"]):
            message = store.deserialize_cdr(record.data, "sensor_msgs/msg/LaserScan")
            scans.append(np.round(np.asarray(message.ranges, float) * 1e3).astype(int))
            if len(scans) == count:
                break
    return scans


@pytest.mark.parametrize("apart", [-100.0, 0.0, 100.0])
def test_the_sensors_time_is_put_on_the_robots_clock(apart: float) -> None:
    """20 ppm of drift, 50 ms of jitter, and its counter starts over on the way."""
    rng = np.random.default_rng(5)
    clock = SensorTime(apart - 16_770.0, late=0.0)
    errors: list[float] = []
    for number in range(600):
        true = 0.1 * number
        counter = round((true * (1 + 20e-6) + 16_770.0 - apart) * 1e3) % (1 << 24)
        assert clock.plausible(counter)
        errors.append(clock.stamp(counter, true + 0.07 + float(rng.uniform(0.0, 0.05) if number % 5 else 0.0)) - true)
    assert max(map(abs, errors)) < 0.005


@pytest.mark.parametrize(
    "lines", [[b"PP", b"00P"], [b"PP", b"00P", b"MODL:x;1"], [b"PP", b"0Ee"], [b"QT", b"00P"], [b"PP"], []]
)
def test_what_is_no_description_is_refused(lines: list[bytes]) -> None:
    with pytest.raises(BadReply):
        parse_parameters(lines)


@pytest.mark.parametrize(
    "rest",
    [
        "",
        "//",
        "//host:port",
        "//host:1/path",
        "///dev/x?speed=3",
        "///dev/x?skip=11",
        "///dev/x?skip=a",
        "//h?skip=.5",
    ],
)
def test_an_address_that_cannot_be_is_a_sentence(rest: str) -> None:
    with pytest.raises(BadInput, match=r"\.$"):
        open_device(rest)


def test_nobody_there_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="no serial port"):
        open_device(f"//{tmp_path}/none").open()
    with pytest.raises(Unavailable, match="cannot be reached"):
        open_device("//127.0.0.1:1").open()


def test_something_that_is_no_laser_is_a_sentence() -> None:
    emulator = ScipEmulator()
    emulator.answer = lambda line: b"what?\n\n"  # type: ignore[method-assign]
    emulator.start()
    with pytest.raises(Unavailable, match="no laser answers SCIP"):
        device_of(emulator).open()
    emulator.stop()
    assert with_sum(b"00") == b"00P\n"
