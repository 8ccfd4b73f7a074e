"""COME HERE and FOLLOW ME on an ideal base: the simulated camera and laser look at people who stand and walk."""

import dataclasses
import math
import os
from functools import cache

import numpy as np
import pytest

from core.commands import spec_of
from core.commands.come_here import COME_HERE
from core.commands.command import Command, Progress
from core.commands.keep_to_person import ONLY_LEGS
from core.errors import Refused
from core.geometry import Pose, wrap
from core.message import Array
from core.models import find
from core.navigation.control_context import ControlContext
from core.perception.people.appearance import PersonProfile
from core.perception.people.engines import MODEL, open_detector
from core.perception.people.enrollment import learn, person_image
from core.perception.people.looking import ImmediateLook, LookAnswer, LookQuestion, PersonLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.voice_bearing import VoiceBearing
from core.sensors import Camera, Image, Laser
from core.simulation.camera import SimulatedCamera
from core.simulation.laser import SimulatedLaser
from core.simulation.world import Rect, Thing, World, outline
from core.speech.understanding.grammar import understand
from tests.core.commands.stage import STEP, Stage

HALL = World(name="hall", walls=outline([Rect(-3.5, -3.5, 6.0, 3.5)], []))
EVERY = 6  # frames for one scan and one picture


class Company(Stage):
    """The stage with people on it."""

    def __init__(self, **settings: float | str) -> None:
        super().__init__()
        self.people: dict[str, Thing] = {}
        self.call: VoiceBearing | None = None
        self.who: PersonProfile | None = None
        self.looks = PeopleSettings()
        self.look: PersonLook | None = None
        self.camera: Camera | None = Camera()
        self.frames = 0
        self.dark = False  # no picture comes
        self.blind = False  # the laser sees nobody
        self.bodiless = False  # pictures show nobody
        self._eye = SimulatedCamera(Camera(), HALL, np.random.default_rng(1))
        self._laser = SimulatedLaser(Laser(), np.random.default_rng(2))
        self._points: Array = np.zeros((0, 2))
        self._image: Image | None = None
        self._settings = settings

    def stands(self, name: str, x: float, y: float, look: str = "red/blue") -> None:
        self.people[name] = Thing(
            id=name, what="person", pose=Pose(x, y, 2.8), length=0.4, depth=0.4, height=1.75, look=look
        )

    def speaks(self, name: str, sd: float = 0.05, off: float = 0.0) -> None:
        at = self.people[name].pose
        azimuth = math.atan2(at.y - self.pose.y, at.x - self.pose.x) + off
        self.call = VoiceBearing(stamp=self.stamp, azimuth=azimuth, sd=sd, x=self.pose.x, y=self.pose.y)

    def to(self, name: str) -> float:
        return self.pose.distance_to(self.people[name].pose.x, self.people[name].pose.y)

    @property
    def here(self) -> ControlContext:
        self.frames += 1
        self._image = None
        if self.frames % EVERY == 0:
            world = HALL
            for one in self.people.values():
                world = world.with_thing(one)
            if self.camera is not None and not self.dark:
                self._image = self._eye.take(HALL if self.bodiless else world, self.stamp, self.pose)
            scan = self._laser.scan(HALL if self.blind else world, self.stamp, np.zeros(1), self.pose.vector[None])
            ends = np.column_stack((np.cos(scan.angles), np.sin(scan.angles))) * scan.ranges[:, None]
            self._points = ends[scan.valid]
        around = super().here
        return dataclasses.replace(
            around,
            scan_points=self._points,
            scan_stamp=float(self.frames // EVERY),
            image=self._image,
            camera=self.camera,
            call=self.call,
            who=self.who,
            look=self.look,
            people=self.looks,
            company=dataclasses.replace(around.company, **self._settings),  # type: ignore[arg-type]
        )


def test_it_turns_to_the_voice_comes_and_stops_half_a_metre_before_who_spoke() -> None:
    stage = Company()
    stage.stands("Ann", -0.9, 1.9)
    stage.stands("Bob", 1.5, 0.8, "green/black")
    stage.speaks("Ann", off=0.04)
    told = stage.obey("come here")
    assert told.finished == "done"
    assert told.person is not None
    assert stage.to("Ann") == pytest.approx(0.5, abs=0.1)
    assert abs(stage.pose.bearing_to(-0.9, 1.9)) < 0.2
    assert told.remark.startswith("Here I am")


def test_who_is_seen_by_the_camera_alone_is_followed() -> None:
    """The laser has not seen their legs yet: something low may hide them."""
    stage = Company()
    stage.blind = True
    stage.stands("Ann", 2.0, 0.0)
    told = follow(stage, 4.0, {})
    assert kept(stage, told[-1]) < 0.5


def bearing(stage: Company, x: float, y: float, strength: float) -> VoiceBearing:
    azimuth = math.atan2(y - stage.pose.y, x - stage.pose.x)
    return VoiceBearing(stamp=stage.stamp, azimuth=azimuth, sd=0.05, x=0.0, y=0.0, strength=strength)


@pytest.mark.campaign
def test_where_an_echo_is_louder_and_someone_else_talks_it_comes_to_the_caller() -> None:
    stage = Company(look_for=0.5)
    stage.looks = PeopleSettings(nearest=1.5, farthest=2.2)  # fewer distances
    stage.stands("Ann", 1.6, 0.6)
    stage.stands("Bob", 1.7, -0.7, "green/black")
    echo, bob, hers = bearing(stage, 1.0, 2.0, 0.9), bearing(stage, 1.7, -0.7, 0.5), bearing(stage, 1.6, 0.6, 0.8)
    command = understand("come here")
    assert isinstance(command, Command)
    action = COME_HERE.begin(dataclasses.replace(command, call=echo, others=(echo, bob, hers)), stage.here)
    told = Progress()
    while not told.finished and stage.stamp < 60.0:
        told = stage.step(action)
    assert told.finished == "done"
    assert stage.to("Ann") == pytest.approx(0.5, abs=0.1)


def test_without_pictures_it_stands_after_half_a_second_and_gives_up_after_one() -> None:
    stage = Company()
    stage.stands("Ann", 2.7, 0.0)
    stage.speaks("Ann")
    action = stage.begin("follow me")
    while not stage.step(action).twist.v:
        assert stage.stamp < 10.0
    stage.dark, silent_from = True, stage.stamp
    while stage.step(action).twist.v:
        assert stage.stamp < silent_from + 0.6
    stage.dark = False  # back again before the second is over
    while not stage.step(action).twist.v:
        assert stage.stamp < silent_from + 2.0
    stage.dark, silent_from = True, stage.stamp
    moved: list[float] = []
    told = Progress()
    while not told.finished and stage.stamp < silent_from + 3.0:
        told = stage.step(action)
        moved += [stage.stamp - silent_from] * told.twist.moves
    assert told.finished == "failed" and "No picture" in told.remark
    assert 0.8 < stage.stamp - silent_from < 1.2
    assert max(moved, default=0.0) < 0.6


def networks() -> PersonLook:
    """The pose networks, which answer at once; skips where they are not."""
    if find(MODEL) is None:
        why = "The pose networks are not here: beckon models get people"
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_PEOPLE") else pytest.skip(why)
    return ImmediateLook(open_detector(PeopleSettings(engine="pose")))


@pytest.mark.campaign
def test_the_pose_networks_find_who_spoke_and_near_them_the_legs_decide() -> None:
    stage = Company()
    stage.look = networks()
    stage.stands("Ann", 3.1, 0.3)
    stage.stands("Bob", 1.5, -1.2, "green/black")
    stage.speaks("Ann", off=0.04)
    action, told = stage.begin("come here"), Progress()
    remarks: list[str] = []
    while not told.finished:
        told = stage.step(action)
        remarks.append(told.remark)
        assert stage.stamp < 40.0
    assert told.finished == "done"
    assert stage.to("Ann") == pytest.approx(0.5, abs=0.1)
    assert "I come." in remarks and any(ONLY_LEGS in remark for remark in remarks)


class Nobody:
    """A detector that finds nobody, and how often it was asked."""

    def __init__(self) -> None:
        self.asked: list[LookQuestion] = []

    def ask(self, question: LookQuestion) -> None:
        self.asked.append(question)

    def answer(self) -> LookAnswer | None:
        return LookAnswer(stamp=self.asked[-1].stamp, found=()) if self.asked else None


def test_legs_alone_are_the_caller_only_where_the_camera_sees_no_more() -> None:
    near, far = Company(), Company()
    for stage, away in ((near, 1.4), (far, 3.4)):
        stage.look = Nobody()
        stage.stands("Ann", away, 0.0)
        stage.speaks("Ann")
    assert near.obey("come here").finished == "done"
    with pytest.raises(Refused, match="see nobody there"):
        far.obey("come here")


class Unanswered(Nobody):
    """A detector on a computer that is too slow for it."""

    def answer(self) -> LookAnswer | None:
        return None


@pytest.mark.parametrize("look", [None, Unanswered()], ids=["drawn figures", "no answer in time"])
def test_legs_at_the_voice_suffice_where_who_called_is_too_near_for_the_picture(look: PersonLook | None) -> None:
    stage = Company(look_for=0.5)
    stage.looks = PeopleSettings(nearest=0.8, farthest=1.4)  # fewer distances
    stage.look, stage.bodiless = look, True
    stage.stands("Ann", 1.0, 0.2)
    stage.speaks("Ann")
    told = stage.obey("come here")
    assert told.finished == "done" and stage.to("Ann") == pytest.approx(0.5, abs=0.1)


CHAIR = tuple(
    Thing(id=f"leg {n}", what="pillar", pose=Pose(1.0, side, 0.0), length=0.04, depth=0.04, height=0.45, look="wood")
    for n, side in enumerate((-0.2, 0.2))
)
BIN = (Thing(id="bin", what="bin", pose=Pose(1.0, 0.0, 0.0), length=0.28, depth=0.28, height=0.42),)


@pytest.mark.parametrize("things", [CHAIR, BIN], ids=["legs of a chair", "a bin"])
@pytest.mark.parametrize("look", [None, Nobody()], ids=["drawn figures", "networks"])
def test_furniture_at_the_voice_is_nobody(things: tuple[Thing, ...], look: PersonLook | None) -> None:
    stage = Company(look_for=0.5)
    stage.looks = PeopleSettings(nearest=0.8, farthest=1.4)
    stage.look = look
    stage.stands("Ann", 1.0, 0.0)
    stage.speaks("Ann")
    stage.people = {one.id: one for one in things}
    with pytest.raises(Refused, match="see nobody there"):
        stage.obey("come here")


def test_nobody_where_the_voice_is_heard_is_refused_in_words() -> None:
    stage = Company()
    stage.stands("Ann", 0.0, 2.0)
    stage.speaks("Ann")
    del stage.people["Ann"]
    with pytest.raises(Refused, match="I heard you from the left but see nobody there"):
        stage.obey("come here")


@cache
def ann() -> PersonProfile:
    """Learnt by the robot's own camera, elsewhere in the hall."""
    eye = SimulatedCamera(Camera(), HALL, np.random.default_rng(5))
    here = Pose(-1.0, -2.0, 0.2)
    worlds = [HALL]
    for gesture in ("", "wide", "wave"):
        place = here @ Pose(3.9, 0.0, math.pi)
        worlds.append(
            HALL.with_thing(
                Thing(
                    id="a",
                    what="person",
                    pose=place,
                    length=0.4,
                    depth=0.4,
                    height=1.75,
                    look="red/blue",
                    gesture=gesture,
                )
            )
        )
    background, *pictures = (eye.take(world, 0.0, here).pixels.copy() for world in worlds)
    return learn("Ann", [person_image(one, background) for one in pictures])


def test_of_two_who_stand_side_by_side_only_the_one_who_was_taught_is_come_to() -> None:
    stage = Company()
    stage.who = ann()
    stage.stands("Ann", 2.7, 0.45)
    stage.stands("Bob", 2.2, -0.35, "green/black")
    stage.speaks("Bob", sd=0.2, off=0.1)
    action, told = stage.begin("come here"), Progress()
    while told.person is None and stage.stamp < 20.0:
        told = stage.step(action)
    assert told.person is not None
    ann_at = stage.people["Ann"].pose
    assert math.dist(told.person.position.tolist(), (ann_at.x, ann_at.y)) < 0.4


def test_where_only_others_are_the_one_who_was_taught_is_asked_for_by_name() -> None:
    stage = Company(look_for=1.0)
    stage.looks = PeopleSettings(nearest=2.0, farthest=2.9)  # fewer distances
    stage.who = ann()
    stage.stands("Bob", 2.4, 0.2, "green/black")
    stage.speaks("Bob")
    with pytest.raises(Refused, match="someone else there; I come only to Ann"):
        stage.obey("follow me")
    del stage.people["Bob"]
    with pytest.raises(Refused, match="do not see Ann there"):
        stage.obey("come here")
    blind = Company(mode="voice")
    blind.who = stage.who
    blind.stands("Ann", 2.4, 0.2)
    blind.speaks("Ann")
    with pytest.raises(Refused, match="by ear alone I cannot tell"):
        blind.begin("come here")


@pytest.mark.parametrize("words", ["come here", "follow me"])
def test_without_a_fresh_and_sure_direction_nothing_moves(words: str) -> None:
    stage = Company()
    stage.stands("Ann", 2.0, 0.0)
    with pytest.raises(Refused, match="I heard nobody"):
        stage.begin(words)
    stage.speaks("Ann", sd=0.5)
    with pytest.raises(Refused, match="not well enough"):
        stage.begin(words)
    stage.speaks("Ann")
    stage.stamp += 30.0
    with pytest.raises(Refused, match="30 s old"):
        stage.begin(words)
    stage.speaks("Ann")
    stage.camera = None
    with pytest.raises(Refused, match="no camera"):
        stage.begin(words)


@pytest.mark.parametrize("words", ["come here", "follow me"])
def test_a_vague_direction_is_refused_also_where_other_voices_were_heard_meanwhile(words: str) -> None:
    stage = Company()
    stage.stands("Ann", 2.0, 0.0)
    stage.speaks("Ann", sd=0.5)
    command = understand(words)
    assert isinstance(command, Command) and stage.call is not None
    others = stage.call, dataclasses.replace(stage.call, sd=0.05)
    spoken = dataclasses.replace(command, call=stage.call, others=others)
    with pytest.raises(Refused, match="not well enough"):
        spec_of(command.name).begin(spoken, stage.here)


def follow(stage: Company, seconds: float, move: dict[str, tuple[float, float]]) -> list[Progress]:
    """FOLLOW ME while people walk at these speeds [m/s]."""
    stage.speaks("Ann")
    action = stage.begin("follow me")
    told: list[Progress] = []
    until = stage.stamp + seconds
    while stage.stamp < until:
        told.append(stage.step(action))
        if told[-1].finished:
            break
        if stage.stamp > 3.0:
            for name, (vx, vy) in move.items():
                one = stage.people[name]
                stride = wrap(one.stride + math.tau * math.hypot(vx, vy) * STEP / 1.2)
                pose = Pose(one.pose.x + vx * STEP, one.pose.y + vy * STEP, math.atan2(vy, vx))
                stage.people[name] = dataclasses.replace(one, pose=pose, stride=stride)
    return told


def kept(stage: Company, told: Progress) -> float:
    """How far [m] from Ann the robot takes her to be."""
    assert not told.finished and told.person is not None
    at = stage.people["Ann"].pose
    return math.dist(told.person.position.tolist(), (at.x, at.y))


@pytest.mark.campaign
def test_it_follows_through_someone_who_crosses_close_before_the_person_and_keeps_its_distance() -> None:
    stage = Company()
    stage.stands("Ann", 2.0, 0.0, "red/blue")
    stage.stands("Bob", 2.3, -1.5, "white/green")
    told = follow(stage, 9.5, {"Ann": (0.2, 0.02), "Bob": (0.0, 0.5)})
    assert kept(stage, told[-1]) < 0.3
    assert 0.7 < stage.to("Ann") < 1.8


@pytest.mark.campaign
def test_it_stands_while_someone_walks_by_close_to_it_and_goes_on_behind_them() -> None:
    """Their feet swing, and the guard knows only where they are now."""
    stage = Company()
    stage.stands("Ann", 3.0, 0.0, "red/blue")
    stage.stands("Bob", 1.0, -1.3, "white/green")
    stage.speaks("Ann")
    action = stage.begin("follow me")
    near: list[Progress] = []
    bob = stage.people["Bob"]
    while bob.pose.y < 1.3:
        told = stage.step(action)
        if told.person is not None:
            ann = stage.people["Ann"]
            stage.people["Ann"] = dataclasses.replace(ann, pose=Pose(ann.pose.x + 0.1 * STEP, 0.0, 0.0))
            stage.people["Bob"] = bob = dataclasses.replace(bob, pose=Pose(1.0, bob.pose.y + 0.5 * STEP, 1.57))
        if stage.to("Bob") < 0.45:
            near.append(told)
    assert stage.to("Bob") > 1.0
    standing = [one for one in near if not one.twist.moves]
    assert len(standing) > 0.6 * len(near) > 0
    assert any(one.remark == "Someone passes close by; I wait." for one in standing)
    assert stage.step(action).twist.moves


@pytest.mark.campaign
def test_where_two_who_met_were_mixed_up_it_knows_the_person_again_by_their_looks() -> None:
    stage = Company()
    stage.stands("Ann", 1.9, 0.4, "red/blue")
    stage.stands("Bob", 1.9, -1.0, "white/green")
    stage.speaks("Ann")
    action = stage.begin("follow me")
    while (told := stage.step(action)).person is None or stage.stamp < 4.0:
        assert stage.stamp < 10.0
    bob = stage.people["Bob"]
    for y in np.arange(-1.0, -0.15, 0.4 * STEP):
        stage.people["Bob"] = bob = dataclasses.replace(bob, pose=Pose(1.9, float(y), 0.0))
        told = stage.step(action)
    assert kept(stage, told) < 0.1
    ann = stage.people["Ann"]
    stage.people["Ann"] = dataclasses.replace(ann, pose=bob.pose)
    stage.people["Bob"] = dataclasses.replace(bob, pose=ann.pose)  # as where they hid each other
    for _ in range(80):
        told = stage.step(action)
    assert kept(stage, told) < 0.1


def test_it_says_that_it_lost_someone_who_vanished_and_stops() -> None:
    stage = Company()
    stage.stands("Ann", 2.0, 0.0)
    follow(stage, 2.5, {})
    stage.speaks("Ann")
    action = stage.begin("follow me")
    for _ in range(80):
        stage.step(action)
    del stage.people["Ann"]
    told = [stage.step(action) for _ in range(160)]
    ended = next(one for one in told if one.finished)
    assert ended.finished == "failed"
    assert "I lost you" in ended.remark
    assert not ended.twist.moves


def test_without_looking_it_goes_to_where_two_bearings_cross() -> None:
    stage = Company(mode="voice")
    stage.camera = None
    stage.stands("Ann", 2.0, 0.4)
    stage.speaks("Ann")
    action = stage.begin("come here")
    told = Progress()
    while not told.finished and stage.stamp < 90.0:
        told = stage.step(action)
        if stage.frames % 80 == 0:
            stage.speaks("Ann", off=0.01)
    assert told.finished == "done"
    assert stage.to("Ann") == pytest.approx(0.5, abs=0.15)
