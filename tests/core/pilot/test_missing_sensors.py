"""Robots that lack a sensor or have two: what can work works, and what cannot is said once."""

import itertools
import math
from collections import Counter, deque
from dataclasses import replace

import numpy as np
import pytest

from core.commands.command import Command
from core.errors import BeckonError
from core.geometry import Pose
from core.pilot import Pilot
from core.robots import Profile
from core.sensors import Laser, Scan, SensorFrame, Sound
from core.simulation.laser import SimulatedLaser
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.simulation.world import world_named
from core.snapshot import Snapshot
from core.speech.understanding.grammar import understand

FRONT = Laser(name="front", mounting=Pose(0.05, 0.0, 0.0))
REAR = Laser(name="rear", mounting=Pose(-0.05, 0.0, math.pi))
RATE = 16_000  # [Hz] of the microphones
PAST = 0.3  # [s] of poses that a turn of a laser needs
COMMAND = 100  # its number


class EquippedRobot:
    """A simulated robot with these sensors alone; it reports as a real one does."""

    def __init__(self, lasers: int, *, odometry: bool, camera: bool, microphones: bool, seed: int = 2) -> None:
        self.inner = SimulatedRobot("lab", seed=seed, settings=SimulationSettings(camera=camera))
        own = self.inner.profile
        self.profile = Profile(
            name="fake",
            url="fake:",
            lasers=(FRONT, REAR)[:lasers],
            cameras=own.cameras,
            arrays=own.arrays if microphones else (),
            odometry=odometry,
        )
        self._world = world_named("lab")
        chance = np.random.SeedSequence(seed).spawn(2)
        made = (SimulatedLaser(laser, np.random.default_rng(chance[i])) for i, laser in enumerate((FRONT, REAR)))
        self._lasers = list(made)[:lasers]
        self._past: deque[tuple[float, float, float, float]] = deque()
        self._count = 0
        self._chance = np.random.default_rng(seed)

    def read(self) -> SensorFrame:
        frame = self.inner.read()
        truth = frame.truth
        assert truth is not None
        heading = truth.heading
        if self._past:
            heading = self._past[-1][3] + math.remainder(truth.heading - self._past[-1][3], math.tau)
        self._past.append((frame.stamp, truth.x, truth.y, heading))
        while self._past[0][0] < frame.stamp - PAST:
            self._past.popleft()
        has = self.profile
        return replace(
            frame,
            scan=self._scan(frame.stamp),
            wheels=frame.wheels if has.odometry else None,
            sound=self._sound(frame.stamp) if has.arrays else None,
        )

    def _sound(self, stamp: float) -> Sound:
        """A quiet room."""
        shape = RATE // 40, len(self.profile.arrays[0].channels)
        samples = self._chance.normal(0.0, 1e-3, shape).astype(np.float32)
        return Sound(stamp=stamp - 1 / 40, rate=RATE, samples=samples)

    def _scan(self, stamp: float) -> Scan | None:
        self._count += 1
        due = self._count % 4 // 2  # frames 0 and 2 of four, for 10 Hz each
        if self._count % 2 or due >= len(self._lasers) or len(self._past) < 8:
            return None
        laser = self._lasers[due]
        past = np.array(self._past)
        scan = laser.scan(self._world, stamp - laser.duration, past[:, 0], past[:, 1:])
        return replace(scan, laser=laser.laser.name if len(self._lasers) > 1 else "")


class Session:
    def __init__(self, robot: EquippedRobot) -> None:
        self.robot, self.pilot = robot, Pilot(robot.profile)
        self.said: dict[int, str] = {}
        self.snapshot: Snapshot | None = None
        self.truth = Pose()

    def run(self, seconds: float) -> Snapshot:
        for _ in range(round(seconds * 40)):
            frame = self.robot.read()
            assert frame.truth is not None
            self.truth = frame.truth
            self.snapshot = self.pilot.step(frame)
            self.said |= {notice.id: notice.text for notice in self.snapshot.notices}
            self.robot.inner.drive(self.snapshot.setpoint)
            if any(ending.id == COMMAND for ending in self.snapshot.endings):
                break
        assert self.snapshot is not None
        return self.snapshot

    def obey(self, words: str, seconds: float) -> tuple[str, str]:
        """Words → how the command ended, and why."""
        heard = understand(words)
        assert isinstance(heard, Command)
        try:
            self.pilot.tell(COMMAND, heard, "typed", "test")
        except BeckonError as refused:
            return "refused", str(refused)
        ended = [one for one in self.run(seconds).endings if one.id == COMMAND]
        return (ended[0].state, ended[0].remark) if ended else ("running", "")


@pytest.mark.parametrize("odometry", [True, False])
@pytest.mark.parametrize("lasers", [0, 1, 2])
def test_a_way_is_driven_by_whatever_tells_how_far_it_is(lasers: int, odometry: bool) -> None:
    session = Session(EquippedRobot(lasers, odometry=odometry, camera=False, microphones=False))
    session.run(1.0)
    start = session.truth
    state, why = session.obey("continue 0.2 meters", 8.0)
    driven = start.distance_to(session.truth.x, session.truth.y)
    if lasers or odometry:
        assert (state, why) == ("done", "")
        assert driven == pytest.approx(0.2, abs=0.02)
        assert session.said == {}
    else:
        assert state == "refused" and "neither odometry nor a laser" in why
        assert driven == 0.0
        assert [text for text in session.said.values() if "neither odometry nor a laser" in text] == [why]


@pytest.mark.parametrize(
    ("lasers", "odometry", "camera", "microphones"), list(itertools.product((0, 1, 2), *[(True, False)] * 3))
)
def test_every_robot_steps_and_says_each_thing_once(
    lasers: int, odometry: bool, camera: bool, microphones: bool
) -> None:
    session = Session(EquippedRobot(lasers, odometry=odometry, camera=camera, microphones=microphones))
    newest = session.run(0.5)
    kinds = Counter(sensor.kind for sensor in newest.sensors)
    assert kinds == +Counter(laser=lasers, wheels=odometry, camera=camera, microphones=microphones)
    assert all(sensor.state == "live" for sensor in newest.sensors)
    assert (newest.hearing is not None) == microphones
    assert (newest.view is not None) == camera
    assert (newest.grid.log_odds.size > 0) == (lasers > 0)
    assert max(Counter(session.said.values()).values(), default=0) <= 1
    assert (session.said == {}) == (odometry or lasers > 0)


@pytest.mark.campaign
@pytest.mark.parametrize("odometry", [True, False])
def test_a_second_laser_does_no_harm_to_the_pose(odometry: bool) -> None:
    errors: list[float] = []
    for lasers in (1, 2):
        session = Session(EquippedRobot(lasers, odometry=odometry, camera=False, microphones=False))
        session.run(1.0)
        assert session.obey("turn left", 8.0)[0] == "done"
        assert session.obey("continue 0.5 meters", 12.0)[0] == "done"
        assert session.snapshot is not None
        here = session.snapshot.estimate.pose
        errors.append(session.truth.distance_to(here.x, here.y))
    assert errors[1] < max(0.02, 1.5 * errors[0])
