"""A recorded drive is computed again to the last bit: poses, map, edges, directions."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from console.recording.recorder import RecorderService
from core.commands.command import Command
from core.gate import ZERO
from core.pilot.recorded_drive import AsRecorded, Comparer, ComputedNow, robot_of
from core.pilot.replayed_drive import open_robot as open_recording
from core.recording.drive import DriveRecording
from core.robots import Robot
from core.robots.connect import connect
from core.robots.driver_session import DriverSession
from core.robots.requests import CarryRobot, Seek, SetListening, Speak
from core.sensors import SensorFrame
from core.sensors.recordable import recordable
from core.settings import Settings
from core.simulation.faulty_robot import open_robot
from core.slam.map.occupancy import OccupancySettings
from core.snapshot import Snapshot
from core.speech.understanding.grammar import understand
from tests.benchmarks.recorded_drive import doctor
from tests.console.in_process import InProcessRobot
from tests.console.live import Live
from tests.console.recording.drives import RecordedPilot, drive, fingerprint
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.world import World

FRAMES = 260

Act = Callable[[int, RecordedPilot], object]


def tell(recorded: RecordedPilot, words: str) -> None:
    command = understand(words)
    assert isinstance(command, Command)
    recorded.pilot.tell(len(recorded.snapshots) + 1, command, "typed", "Ada")


def by_commands(robot: Robot) -> Act:
    """A turn, a way, a wall that is followed: at rest between them."""
    orders = {125: "turn left", 230: "continue 0.5 meters"}
    return lambda number, recorded: tell(recorded, orders[number]) if number in orders else None


def by_voices(robot: Robot) -> Act:
    """Somebody talks, to a robot that now and then talks itself."""
    robot.ask(SetListening(on=True))

    def act(number: int, recorded: RecordedPilot) -> None:
        if number % 90 == 20:
            robot.ask(Speak(x_m=1.2, y_m=0.8 - number / 200, text="robot come here please"))
        if number == 125:
            tell(recorded, "turn right")

    return act


def carried(robot: Robot) -> Act:
    """Taken up and put down elsewhere, and told where it is."""

    def act(number: int, recorded: RecordedPilot) -> None:
        if number == 125:
            tell(recorded, "continue 0.6 meters")
        if number == 180:
            robot.ask(CarryRobot(x_m=0.6, y_m=0.4, heading_rad=1.0))
        if number == 230:
            recorded.pilot.place_at(0.6, 0.4, 1.0)

    return act


def on_a_loaded_map(robot: Robot) -> Act:
    """The map of a while ago is loaded in the middle of a way, and a camera of another calibration is used."""
    kept = []

    def act(number: int, recorded: RecordedPilot) -> None:
        if number == 125:
            tell(recorded, "continue 0.8 meters")
        if number == 170:
            kept.append(recorded.pilot.keep_map())
        if number == 210:
            recorded.pilot.enter_map(kept[0])
        if number == 220:
            camera = recorded.profile.camera
            assert camera is not None
            recorded.pilot.look_through(recorded.profile.with_camera(camera))
            recorded.pilot.believe_closure(0, believed=False)

    return act


def all_at_once(robot: Robot) -> Act:
    """A way, voices, a robot that is carried, and a map that is loaded: what the suite has time for."""
    robot.ask(SetListening(on=True))
    kept = []

    def act(number: int, recorded: RecordedPilot) -> None:
        if number in (20, 100):
            robot.ask(Speak(x_m=1.2, y_m=0.8 - number / 200, text="come here"))
        if number == 90:
            tell(recorded, "continue 0.5 meters")
        if number == 125:
            kept.append(recorded.pilot.keep_map())
        if number == 135:
            robot.ask(CarryRobot(x_m=0.6, y_m=0.4, heading_rad=1.0))
            recorded.pilot.place_at(0.6, 0.4, 1.0)
        if number == 155:
            recorded.pilot.enter_map(kept[0])

    return act


LONGER = [
    pytest.param(acts, marks=pytest.mark.campaign) for acts in (by_commands, by_voices, carried, on_a_loaded_map)
]


def again(path: Path, settings: Settings | None = None) -> tuple[list[Snapshot], Comparer, ComputedNow]:
    recording = DriveRecording(path)
    recorded = AsRecorded(robot_of(recording).built)
    computed, comparer = ComputedNow(recording, settings or Settings()), Comparer()
    snapshots: list[Snapshot] = []
    for moment in recording.moments():
        then = recorded.take(moment)
        assert then is not None
        snapshots.append(computed.take(moment))
        comparer.compare(moment, then, snapshots[-1], computed.recorded_from_computed)
    assert recording.report.skipped == 0
    return snapshots, comparer, computed


@pytest.mark.parametrize("acts", [all_at_once, *LONGER])
def test_the_same_settings_compute_the_same_to_the_last_bit(acts: Callable[[Robot], Act], tmp_path: Path) -> None:
    robot, path = open_robot("lab", seed=3, settings=None), tmp_path / "drive.mcap"
    frames = 180 if acts is all_at_once else FRAMES
    live = drive(robot, path, frames, acts(robot), deaf=range(110, 120)).snapshots
    snapshots, comparer, computed = again(path)
    assert computed.whole and len(snapshots) == len(live)
    assert fingerprint(snapshots) == fingerprint(live)
    assert comparer.same and comparer.frames == len(live) and comparer.worst == 0.0


def test_what_is_computed_of_the_middle_of_a_drive_begins_in_the_map_that_was_there(tmp_path: Path) -> None:
    robot = open_robot("lab", seed=3, settings=None)
    before = drive(robot, tmp_path / "before.mcap", 330, by_commands(robot))
    recorded = RecordedPilot(tmp_path / "middle.mcap", robot.profile, pilot=before.pilot)
    for number in range(60):
        if number == 10:
            tell(recorded, "turn right")
        robot.drive(recorded.step(robot.read()).setpoint)
    recorded.finish()
    snapshots, comparer, computed = again(tmp_path / "middle.mcap")
    anew, apart, without = again(tmp_path / "middle.mcap", Settings(occupancy=OccupancySettings(resolution=0.1)))
    known = (recorded.snapshots[-1].grid.log_odds != 0).sum()
    assert computed.resumed and not computed.whole and comparer.worst < 0.02
    assert (snapshots[0].grid.log_odds != 0).sum() > 0.9 * known and _hits(snapshots[0]) > 5
    assert not without.resumed and _hits(anew[0]) == 1 and apart.worst < 0.1
    assert without.why_empty == "The map has cells of 0.05 m; set occupancy.resolution to that."


def test_what_was_kept_of_the_ring_begins_in_the_map_of_its_own_beginning(tmp_path: Path) -> None:
    robot, kept = open_robot("lab", seed=3, settings=None), tmp_path / "kept.mcap"
    recorded, act = RecordedPilot(tmp_path / "all.mcap", robot.profile, ring_s=6.0), by_commands(robot)
    for number in range(420):
        act(number, recorded)
        robot.drive(recorded.step(robot.read()).setpoint)
    recorded.keep(kept, 4.0)
    _, comparer, computed = again(kept)
    drive, then = DriveRecording(kept), recorded.snapshots[-161]
    first = AsRecorded(robot.profile)
    first.begin(drive.latest("/map", 0.0), ())
    shown = first.take(next(drive.moments()))
    assert (
        doctor(kept) == []
        and drive.duration == pytest.approx(4.0, abs=0.1)
        and computed.resumed
        and comparer.worst < 0.02
    )
    assert shown is not None and shown.grid.log_odds.shape == recorded.snapshots[-200].grid.log_odds.shape
    assert (shown.grid.log_odds != 0).sum() <= (then.grid.log_odds != 0).sum()


def _hits(snapshot: Snapshot) -> int:
    return max(one.hits for one in snapshot.landmarks)


def test_a_session_that_is_recorded_from_its_start_is_computed_again_to_the_last_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken = InProcessRobot.next_frame
    monkeypatch.setattr(  # pictures are packed where a robot is read, which is a process of its own elsewhere
        InProcessRobot, "next_frame", lambda robot, timeout: (one := taken(robot, timeout)) and recordable(one)
    )
    with Live(tmp_path, no_auth=True, from_start=True) as live:
        recorder = live.runtime.parts[RecorderService]
        live.until(lambda: recorder.state.seconds > 1.0, seconds=60.0)
    [path] = (tmp_path / "recordings").iterdir()
    snapshots, comparer, computed = again(path)
    assert path.suffix == ".mcap" and len(snapshots) > 10 and computed.whole and comparer.same


def test_where_no_picture_has_come_for_long_the_last_one_is_shown(tmp_path: Path) -> None:
    robot, path = open_robot("lab", seed=3, settings=None), tmp_path / "drive.mcap"
    recorded = RecordedPilot(path, robot.profile)
    frame = next(frame for _ in range(40) if (frame := robot.read()).image is not None)
    assert frame.wheels is not None
    recorded.step(frame)
    for number in range(1, 161):
        recorded.step(SensorFrame(stamp=frame.stamp + number / 40, wheels=frame.wheels))
    recorded.finish()
    with closing(open_recording(str(path), seed=0, settings=None)) as replayed:
        for place in (0.9, 0.1, 0.999):
            replayed.ask(Seek(value=place))
            assert replayed.read().image is not None


@contextmanager
def on_a_wire() -> Iterator[Robot]:
    """A robot behind rosbridge: frames as they come over a link, at the pace of life."""
    world = World()
    emulator = RosbridgeEmulator(world)
    emulator.start()
    world.start()
    robot = connect(emulator.url)
    yield robot
    world.stop()
    emulator.stop()


@pytest.mark.campaign
def test_a_drive_of_a_robot_on_a_wire_is_computed_again_to_the_last_bit(tmp_path: Path) -> None:
    path, scans = tmp_path / "drive.mcap", 0
    with on_a_wire() as robot:
        session = DriverSession(robot)
        recorded = RecordedPilot(path, session.profile)
        for number in range(FRAMES):
            if number in (125, 200):
                tell(recorded, "turn left" if number == 125 else "continue 0.5 meters")
            for frame in session.frames(0.1, recorded.snapshots[-1].setpoint if recorded.snapshots else ZERO):
                recorded.step(frame)
                scans += frame.scan is not None
        recorded.finish()
        session.close()
    snapshots, comparer, computed = again(path)
    assert (
        scans > 20 and computed.whole and comparer.same and fingerprint(snapshots) == fingerprint(recorded.snapshots)
    )
