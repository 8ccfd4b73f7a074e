"""The dry run: what COME HERE and FOLLOW ME would do where nothing drives, on a stage that never moves."""

import dataclasses
import math

import numpy as np
import pytest

from core.commands.command import Command, Progress
from core.commands.dry_run import FORGET_PERSON_S, MAX_START_S, SEARCH_TIME_S, SHOW_FOUND_S, DryRun
from core.errors import Refused
from core.geometry import OPTICAL, Transform
from core.navigation.control_context import ControlContext
from core.optics import CameraModel
from core.perception.people.appearance import NO_LIMBS, Appearance, PersonProfile
from core.perception.people.looking import ImmediateLook, LookAnswer, LookQuestion, PersonLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.detector import PoseDetector
from core.perception.people.voice_bearing import VoiceBearing
from core.sensors import Camera, Image
from tests.core.commands.stage import STEP, Stage
from tests.core.perception.stick_figures import StickNetworks, white_body

WEBCAM = Camera(
    model=CameraModel(fx=554.0, fy=554.0, cx=320.0, cy=240.0, width=640, height=480),
    mounting=Transform(rotation=OPTICAL, translation=np.array([0.0, 0.0, 0.16])),
)


class Desk(Stage):
    """A camera on a desk, someone before it, and perhaps a voice."""

    def __init__(self) -> None:
        super().__init__()
        self.pixels = white_body(640, 480, 420.0, 80.0, 300.0)
        self.call: VoiceBearing | None = None
        self.look: PersonLook | None = ImmediateLook(PoseDetector(StickNetworks(), PeopleSettings()))
        self.who: PersonProfile | None = None
        self.camera: Camera | None = WEBCAM

    @property
    def here(self) -> ControlContext:
        image = Image(stamp=self.stamp, pixels=self.pixels)
        return dataclasses.replace(
            super().here, image=image, camera=self.camera, call=self.call, look=self.look, who=self.who
        )

    def hears(self, azimuth: float) -> None:
        self.call = VoiceBearing(stamp=self.stamp, azimuth=azimuth, sd=0.05, x=0.0, y=0.0)

    def shows(self, words: str, seconds: float) -> list[Progress]:
        """What it says meanwhile; it must never ask for motion."""
        action = DryRun(Command(name=words, numbers={}, heard_as=words), self.here)
        told: list[Progress] = []
        until = self.stamp + seconds
        while self.stamp < until and not (told and told[-1].finished):
            told.append(action.drive(self.here))
            assert not told[-1].twist.moves
            self.stamp += STEP
        return told


def test_someone_is_boxed_and_told_what_a_robot_would_do() -> None:
    desk = Desk()
    told = desk.shows("come_here", 1.0)[-1]
    assert told.person is not None and told.person.rectangle is not None
    left, _, right, _ = told.person.rectangle.box
    assert left < 420 < right
    assert "Dry run: I see you" in told.remark and "turn 10° right" in told.remark
    assert told.goal is not None and told.path is not None
    away = math.hypot(*told.person.position)
    assert math.hypot(*told.goal) == pytest.approx(away - 0.5, abs=0.02)
    assert f"{away:.1f} m away" in told.remark


def test_of_two_directions_the_voice_decides_and_its_ray_is_kept() -> None:
    desk = Desk()
    desk.hears(-0.17)
    person = desk.shows("follow_me", 1.0)[-1].person
    assert person is not None and person.sound is not None and set(person.used) == {"camera", "sound"}
    desk = Desk()
    desk.hears(0.35)
    assert all(told.person is None for told in desk.shows("follow_me", 1.0))
    desk.hears(1.9)
    assert "I would turn 109° left and look who spoke" in desk.shows("follow_me", 0.2)[-1].remark


def test_come_here_ends_and_follow_me_waits_for_who_left() -> None:
    desk = Desk()
    ended = desk.shows("come_here", SHOW_FOUND_S + 2.0)[-1]
    assert ended.finished == "done" and not ended.twist.moves
    desk = Desk()
    command = Command(name="follow_me", numbers={}, heard_as="follow me")
    action = DryRun(command, desk.here)
    remarks: list[str] = []
    for frame in range(round((2.0 + FORGET_PERSON_S) / STEP)):
        if frame * STEP > 1.0:
            desk.pixels = np.zeros_like(desk.pixels)
        remarks.append(action.drive(desk.here).remark)
        desk.stamp += STEP
    assert any("you are hidden" in remark for remark in remarks)
    assert "look for anybody" in remarks[-1]


@pytest.mark.campaign
def test_what_is_missing_is_said_in_a_sentence() -> None:
    desk = Desk()
    desk.pixels = np.zeros_like(desk.pixels)
    with pytest.raises(Refused, match="I see nobody"):
        desk.shows("come_here", SEARCH_TIME_S + 1.0)
    desk.hears(0.0)
    desk.pixels = white_body(640, 480, 420.0, 80.0, 300.0)
    desk.who = PersonProfile(
        name="Ann", looks=Appearance(colours=np.full((3, 4), 3.0), proportions=NO_LIMBS), pictures=4
    )
    desk.call = None
    with pytest.raises(Refused, match="someone, but not Ann"):
        desk.shows("come_here", SEARCH_TIME_S + 1.0)
    desk.look = None
    with pytest.raises(Refused, match="beckon models get people"):
        desk.shows("come_here", 1.0)
    desk.camera = None
    with pytest.raises(Refused, match="no camera"):
        desk.shows("come_here", 1.0)


class Starting:
    """A worker that does not come to life."""

    def ask(self, question: LookQuestion) -> None:
        """Take a question."""

    def answer(self) -> LookAnswer | None:
        return None


def test_a_worker_that_starts_late_is_waited_for_and_named() -> None:
    desk = Desk()
    desk.look = Starting()
    assert not desk.shows("come_here", SEARCH_TIME_S + 1.0)[-1].finished
    with pytest.raises(Refused, match="has not started yet"):
        desk.shows("come_here", MAX_START_S + 1.0)
