"""The pilot: what it publishes, and what it makes of frames that are not as they should be."""

import dataclasses
import threading
from dataclasses import replace

import numpy as np
import pytest

from core.commands.command import Command
from core.errors import Refused
from core.gate import Twist
from core.geometry import Pose
from core.navigation.control_context import ControlContext
from core.perception.people.voice_bearing import VoiceBearing
from core.pilot import Pilot
from core.pilot.notices import Notices
from core.pilot.pilot import of_robot
from core.pilot.trail import Trail
from core.robots import Profile
from core.sensors import Image, Laser, SensorFrame, Sound
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.snapshot import Snapshot
from core.speech.understanding.grammar import understand


def command(words: str) -> Command:
    heard = understand(words)
    assert isinstance(heard, Command)
    return heard


def robot(*, camera: bool = False) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=4, settings=SimulationSettings(camera=camera))


def started(wheels_turn: SimulatedRobot) -> Pilot:
    """A pilot that has looked around."""
    pilot = Pilot(wheels_turn.profile)
    for _ in range(60):
        pilot.step(wheels_turn.read())
    return pilot


def test_everything_published_is_read_only() -> None:
    lab = robot(camera=True)
    pilot = Pilot(lab.profile)
    snapshot = pilot.step(lab.read())
    for _ in range(20):
        snapshot = pilot.step(lab.read())
    arrays = [getattr(snapshot, field.name) for field in dataclasses.fields(snapshot)]
    arrays += [snapshot.grid.log_odds, snapshot.estimate.covariance]
    assert snapshot.view is not None
    assert len(snapshot.view.laser) > 20
    assert len(snapshot.view.edges) > 0
    assert len(snapshot.scan_points) > 300
    for array in arrays:
        assert not isinstance(array, np.ndarray) or not array.flags.writeable


def test_the_nonce_of_the_frame_comes_back_with_the_setpoint() -> None:
    lab = robot()
    pilot = Pilot(lab.profile)
    assert pilot.step(replace(lab.read(), nonce=77)).nonce == 77


def test_setpoints_are_plain_numbers_under_the_undertakings_name() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(5, command("continue 1 meters"), "typed", "anna")
    snapshot = pilot.step(lab.read())
    assert snapshot.setpoint.v > 0
    assert type(snapshot.setpoint.v) is float
    assert type(snapshot.setpoint.w) is float
    assert snapshot.setpoint_command_id == 5
    assert snapshot.active_command is not None
    assert (snapshot.active_command.heard_as, snapshot.active_command.who) == ("continue 1 meters", "anna")


def test_the_plan_and_the_goal_are_shown_while_they_hold() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("stop at 1 and 0.5"), "click", "anna")
    snapshot = pilot.step(lab.read())
    assert snapshot.goal == pytest.approx([1.0, 0.5])
    assert snapshot.path[-1] == pytest.approx([1.0, 0.5])
    pilot.cancel("cancelled", "Stopped by anna.")
    snapshot = pilot.step(lab.read())
    assert snapshot.goal is None
    assert len(snapshot.path) == 0
    assert [(ended.state, ended.remark) for ended in snapshot.endings] == [("cancelled", "Stopped by anna.")]
    assert not snapshot.setpoint.moves
    assert snapshot.setpoint_command_id == 0


def test_a_straight_line_shows_its_end() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 1 meters"), "typed", "anna")
    snapshot = pilot.step(lab.read())
    assert snapshot.goal == pytest.approx([1.0, 0.0], abs=0.01)
    assert snapshot.path[-1] == pytest.approx(snapshot.goal)


def test_any_thread_may_tell() -> None:
    lab = robot()
    pilot = started(lab)
    turn = command("turn left")
    tellers = [
        threading.Thread(target=lambda start=start: [pilot.tell(start + i, turn, "rest", "anna") for i in range(200)])
        for start in (1000, 2000, 3000)
    ]
    for teller in tellers:
        teller.start()
    endings = [ended for _ in range(40) for ended in pilot.step(lab.read()).endings]
    for teller in tellers:
        teller.join()
    endings += pilot.step(lab.read()).endings
    pilot.cancel("cancelled", "Enough.")
    endings += pilot.step(lab.read()).endings
    assert sorted(ended.id for ended in endings) == [start + i for start in (1000, 2000, 3000) for i in range(200)]


def test_a_cancel_ends_only_what_was_told_before_it() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("turn left"), "typed", "anna")
    pilot.cancel("cancelled", "Stopped.")
    pilot.tell(2, command("turn right"), "typed", "anna")
    snapshot = pilot.step(lab.read())
    assert [ended.id for ended in snapshot.endings] == [1]
    assert snapshot.setpoint_command_id == 2
    assert snapshot.setpoint.w < 0


def test_a_contact_ends_what_is_under_way_and_is_told_once() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    touched = [pilot.step(replace(lab.read(), contact=True)) for _ in range(5)]
    assert [ended.state for ended in touched[0].endings] == ["failed"]
    assert "touched" in touched[0].endings[0].remark
    assert not touched[0].setpoint.moves
    assert len([notice for notice in touched[-1].notices if "touches" in notice.text]) == 1
    pilot.tell(2, command("turn left"), "typed", "anna")
    assert pilot.step(replace(lab.read(), contact=True)).setpoint.w > 0


def test_a_silent_laser_is_one_notice_that_ends_with_its_return() -> None:
    lab = robot()
    pilot = started(lab)
    blind = [pilot.step(replace(lab.read(), scan=None)) for _ in range(60)]
    back = [pilot.step(lab.read()) for _ in range(8)]
    texts = [notice.text for notice in back[-1].notices]
    assert [notice.text for notice in blind[-1].notices] == ["No scan comes from the laser."]
    assert texts == ["The laser is back."]


def test_a_slow_computer_is_one_notice_with_a_real_robot_and_none_in_the_simulator() -> None:
    lab = robot()
    simulated = [Pilot(lab.profile).step(replace(lab.read(), pace=pace)).notices for pace in (1.0, 0.5)]
    assert simulated == [(), ()]
    pilot = Pilot(replace(lab.profile, capabilities=lab.profile.capabilities - {"simulate"}))
    seen = [pilot.step(replace(lab.read(), pace=pace)).notices for pace in (1.0, 0.85, 0.48, 0.54, 1.0)]
    assert seen[0] == ()
    assert [[notice.id for notice in notices] for notices in seen[1:]] == [[1]] * 4
    assert seen[1][0].text == seen[2][0].text == seen[3][0].text and "beckon doctor" in seen[2][0].text
    assert [notices[0].level for notices in seen[3:]] == ["warning", "info"]
    assert "keeps up" in seen[4][0].text


def test_the_wheelbase_is_the_robots_own() -> None:
    profile = replace(robot().profile, wheelbase=0.31)
    assert of_robot(Settings(), profile).motion.wheelbase == 0.31
    recorded = replace(profile, capabilities=frozenset({"replay"}))
    assert of_robot(Settings(), recorded).motion.wheelbase == Settings().motion.wheelbase


def test_a_base_that_does_not_answer_ends_what_is_under_way() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 2 meters"), "typed", "someone")
    for _ in range(40):
        pilot.step(lab.read())
    snapshot = pilot.step(replace(lab.read(), trouble="serial:///dev/ttyUSB0 does not answer."))
    assert [(one.state, one.remark) for one in snapshot.endings] == [
        ("failed", "serial:///dev/ttyUSB0 does not answer.")
    ]
    assert snapshot.setpoint == Twist()
    assert pilot.step(lab.read()).notices[-1].text == "The robot can be driven again."


def test_what_the_driver_notes_reaches_the_operator() -> None:
    lab = robot()
    pilot = Pilot(lab.profile)
    assert pilot.step(replace(lab.read(), notes=("The battery is low.",))).notices[-1].text == "The battery is low."


def test_a_picture_of_the_wrong_size_is_told_and_flies_past() -> None:
    lab = robot(camera=True)
    pilot = Pilot(lab.profile)
    snapshot = None
    for _ in range(20):
        frame = lab.read()
        if frame.image is not None:
            frame = replace(frame, image=Image(stamp=frame.stamp, pixels=np.zeros((10, 10, 3), np.uint8)))
        snapshot = pilot.step(frame)
    assert snapshot is not None
    assert [notice.level for notice in snapshot.notices] == ["warning"]
    assert "10x10" in snapshot.notices[0].text


def test_a_recording_refuses_commands() -> None:
    pilot = Pilot(Profile(name="log", url="log:x", lasers=(Laser(),), capabilities=frozenset({"replay"})))
    with pytest.raises(Refused, match="recording"):
        pilot.tell(1, command("turn left"), "typed", "anna")


def test_a_jump_back_in_time_begins_anew() -> None:
    lab = robot()
    pilot = Pilot(lab.profile)
    frames = [lab.read() for _ in range(60)]
    first = [pilot.step(frame) for frame in frames]
    again = [pilot.step(frame) for frame in frames]
    assert again[0].slam.updates <= 1
    assert (again[-1].grid.log_odds == first[-1].grid.log_odds).all()
    assert again[-1].estimate.pose == first[-1].estimate.pose


def test_a_driver_whose_clock_begins_anew_ends_what_is_under_way() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(5, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    snapshot = pilot.step(robot().read())
    assert snapshot.active_command is None and not snapshot.setpoint.moves
    (ending,) = snapshot.endings
    assert (ending.id, ending.state) == (5, "failed") and "clock" in ending.remark


def test_time_that_stands_still_changes_nothing() -> None:
    lab = robot()
    pilot = started(lab)
    frame = lab.read()
    before = pilot.step(frame)
    paused = [pilot.step(SensorFrame(stamp=frame.stamp, wheels=frame.wheels, running=False)) for _ in range(40)]
    assert paused[-1].estimate.pose == before.estimate.pose
    assert not paused[-1].running
    assert paused[-1].notices == before.notices


@pytest.mark.campaign
def test_scans_alone_are_enough_to_find_the_way() -> None:
    """A hand-held laser: no wheels in any frame."""
    lab = robot()
    pilot = Pilot(replace(lab.profile, capabilities=frozenset({"replay"})))
    truth = Pose()
    snapshot: Snapshot | None = None
    for count in range(400):
        lab.drive(Twist(0.1, 0.2 if count > 200 else 0.0) if count > 60 else Twist())
        frame = lab.read()
        snapshot = pilot.step(replace(frame, wheels=None, truth=None))
        assert frame.truth is not None
        truth = frame.truth
    assert snapshot is not None
    assert snapshot.estimate.pose.distance_to(truth.x, truth.y) < 0.05
    assert snapshot.estimate.pose.heading == pytest.approx(truth.heading, abs=0.03)
    assert snapshot.slam.updates > 0


def test_a_trail_is_thinned_and_bounded() -> None:
    trail = Trail(step=0.01, most=100)
    line = np.zeros((0, 2))
    for x in np.arange(0, 20, 0.01):
        line = trail.add(float(x), 0.0)
    assert len(line) <= 100
    assert line[0] == pytest.approx([0, 0])
    assert line[-1, 0] > 19.5
    assert not line.flags.writeable


def test_notices_are_bounded_and_a_trouble_is_one_notice_that_begins_and_ends() -> None:
    notices = Notices(most=5)
    seen: list[list[tuple[int, str]]] = []
    for stamp in range(12):
        notices.watch(stamp, "laser", "Trouble." if 2 <= stamp < 7 or stamp > 9 else "", "error", "Relief.")
        seen.append([(notice.id, notice.text) for notice in notices.newest])
    assert seen[1:4] == [[], [(1, "Trouble.")], [(1, "Trouble.")]]
    assert seen[7:] == [[(1, "Relief.")]] * 3 + [[(2, "Trouble.")]] * 2
    for stamp in range(10):
        notices.add(stamp, "info", str(stamp))
    assert [notice.text for notice in notices.newest] == ["5", "6", "7", "8", "9"]
    assert [notice.id for notice in notices.newest] == sorted(notice.id for notice in notices.newest)


def test_a_command_that_cannot_begin_leaves_the_one_under_way_alone() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    pilot.tell(2, command("come here"), "chip", "anna")
    snapshot = pilot.step(lab.read())
    assert [(ended.id, ended.state) for ended in snapshot.endings] == [(2, "refused")]
    assert snapshot.active_command is not None and snapshot.active_command.id == 1
    assert snapshot.setpoint.v > 0 and snapshot.setpoint_command_id == 1
    pilot.tell(3, command("come here"), "chip", "anna")
    pilot.tell(4, command("turn left"), "chip", "anna")
    snapshot = pilot.step(lab.read())
    assert [(ended.id, ended.state) for ended in snapshot.endings] == [(3, "pre-empted"), (1, "pre-empted")]
    assert snapshot.setpoint_command_id == 4 and snapshot.setpoint.w > 0


def test_a_command_that_cannot_begin_leaves_the_other_alone_also_while_the_robot_looks_around(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    drive = pilot._executor.drive
    monkeypatch.setattr(pilot._executor, "drive", lambda here, *_: drive(here, "I look around."))
    pilot.tell(2, command("come here"), "chip", "anna")
    snapshot = pilot.step(lab.read())
    assert [(ended.id, ended.state) for ended in snapshot.endings] == [(2, "refused")]
    assert snapshot.active_command is not None and snapshot.active_command.id == 1
    pilot.tell(3, command("turn left"), "chip", "anna")
    snapshot = pilot.step(lab.read())
    assert [(ended.id, ended.state) for ended in snapshot.endings] == [(1, "pre-empted")]
    assert snapshot.active_command is not None and snapshot.active_command.remark == "I look around."
    assert not snapshot.setpoint.moves


def test_a_stop_ends_what_came_in_with_it_too() -> None:
    lab = robot()
    pilot = started(lab)
    pilot.tell(1, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    pilot.tell(2, command("turn left"), "typed", "anna")
    pilot.cancel("cancelled", "Stopped by anna.")
    snapshot = pilot.step(lab.read())
    assert sorted((ended.id, ended.state) for ended in snapshot.endings) == [(1, "cancelled"), (2, "cancelled")]
    assert snapshot.active_command is None and not snapshot.setpoint.moves
    pilot.tell(3, command("continue 1 meters"), "typed", "anna")
    pilot.step(lab.read())
    pilot.tell(4, command("stop"), "typed", "anna")
    snapshot = pilot.step(lab.read())
    assert [(ended.id, ended.state) for ended in snapshot.endings] == [(3, "pre-empted"), (4, "done")]
    assert not snapshot.setpoint.moves


def test_a_voice_is_known_to_the_decision_of_the_frame_that_it_is_heard_in(monkeypatch: pytest.MonkeyPatch) -> None:
    lab = robot(camera=True)
    pilot = started(lab)

    def hear(*_: object) -> None:
        pilot._hearing.call = VoiceBearing(stamp=pilot._stamp, azimuth=1.0, sd=0.05, x=0.0, y=0.0)

    monkeypatch.setattr(pilot._hearing, "hear", hear)
    pilot.tell(1, command("come here"), "chip", "anna")
    snapshot = pilot.step(lab.read())
    assert snapshot.active_command is not None and snapshot.setpoint.w > 0


def test_words_into_which_others_talked_on_are_as_old_as_the_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    """They were understood when all of it was over: their own end alone would make them too old."""
    lab = robot(camera=True)
    pilot = started(lab)
    for _ in range(240):
        pilot.step(lab.read())
    now = pilot._stamp
    fresh = Settings().person_following.spoken_fresh
    heard = VoiceBearing(stamp=now - fresh - 1, azimuth=1.0, sd=0.05, x=0.0, y=0.0)
    monkeypatch.setattr(pilot._hearing, "heard_in", lambda *_: (heard,))
    other = VoiceBearing(stamp=now - 1, azimuth=-2.0, sd=0.05, x=0.0, y=0.0)
    words = replace(command("come here"), call=other, said=(now - fresh - 2, now - fresh - 1))
    pilot.tell(1, words, "ears", "anna")
    snapshot = pilot.step(lab.read())
    assert snapshot.active_command is not None and snapshot.setpoint.w > 0


@pytest.mark.parametrize(
    ("kind", "order"), [("picture", "follow me"), ("sound", "come here"), ("odometry", "turn left")]
)
@pytest.mark.parametrize("late", [0.0, 1.0])
def test_no_command_is_driven_by_a_late_picture_sound_or_odometry(
    monkeypatch: pytest.MonkeyPatch, kind: str, order: str, late: float
) -> None:
    lab = robot(camera=True)
    pilot = started(lab)
    pilot._hearing.call = VoiceBearing(stamp=pilot._stamp, azimuth=1.0, sd=0.05, x=0.0, y=0.0)
    monkeypatch.setattr(pilot._hearing, "hear", lambda *_: ())
    seen: list[ControlContext] = []
    drive = pilot._executor.drive

    def watched(here: ControlContext, wait_for: str) -> Twist:
        seen.append(here)
        return drive(here, wait_for)

    monkeypatch.setattr(pilot._executor, "drive", watched)
    pilot.tell(1, command(order), "chip", "anna")
    frame = lab.read()
    assert frame.wheels is not None
    taken = frame.stamp - late
    image = Image(stamp=taken, pixels=np.zeros((480, 640, 3), np.uint8))
    sound = Sound(stamp=taken - 0.02, rate=16_000, samples=np.zeros((320, 1)))
    readings = {"picture": {"image": image}, "sound": {"sound": sound}, "odometry": {}}[kind]
    age = late if kind == "odometry" else 0.0
    snapshot = pilot.step(replace(frame, wheels=replace(frame.wheels, age=age), **readings))
    used = {
        "picture": lambda: seen[-1].image is not None,
        "sound": lambda: seen[-1].call is not None,
        "odometry": lambda: snapshot.setpoint.moves,
    }[kind]
    assert used() is (not late)
