"""An array that sits turned on the robot: the wizard finds by how much, from voices in the simulated room."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.gate import Twist
from core.geometry import wrap
from core.perception.sound.array_orientation import Orientation, OrientationWizard, heard_from, oriented
from core.robots.requests import ReadTruth, SetListening, Speak
from core.sensors.microphones import ARRAYS, RESPEAKER_ODAS, Sound, joined
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.speech.practice_voice import practice_voice

TURNED = 0.7  # [rad]


def recording(robot: SimulatedRobot, azimuth: float) -> Sound:
    """A person speaks from there for a second."""
    here = robot.ask(ReadTruth())
    angle = here.heading_rad + azimuth
    voice = (4000 * practice_voice(np.random.default_rng(1), 0.8, 16_000)).astype("<i2").tobytes()
    x, y = here.x_m + 1.2 * math.cos(angle), here.y_m + 1.2 * math.sin(angle)
    robot.ask(SetListening(on=True))
    robot.ask(Speak(pcm=voice, x_m=x, y_m=y))
    sound: Sound | None = None
    while sound is None or sound.duration < 2.4:
        robot.drive(Twist(0.0, 0.0))
        sound = joined(sound, robot.read().sound, 10.0)
    robot.ask(SetListening(on=False))
    robot.drive(Twist(0.0, 0.0))
    robot.read()
    return sound


def test_the_wizard_finds_how_the_array_is_turned() -> None:
    robot = SimulatedRobot("lab", seed=1, settings=SimulationSettings(turned=TURNED, camera=False))
    array = robot.profile.microphones
    assert array is not None and array.mounting.heading == 0.0
    wizard = OrientationWizard()
    for asked in wizard.asked[:3]:
        assert wizard.add(asked, heard_from(recording(robot, asked), array)) == ""
    found = wizard.solve()
    assert isinstance(found, Orientation) and not found.mirrored
    assert abs(wrap(found.yaw - TURNED)) < min(0.1, 3 * found.yaw_sd)
    assert oriented(array, found).mounting.heading == found.yaw


def test_silence_and_scraps_are_no_clap() -> None:
    hiss = 0.001 * np.random.default_rng(0).normal(size=(48_000, 4))
    with pytest.raises(BadInput, match="Nothing stood out"):
        heard_from(Sound(stamp=0.0, rate=16_000, samples=hiss), RESPEAKER_ODAS)
    with pytest.raises(BadInput, match="too short"):
        heard_from(Sound(stamp=0.0, rate=16_000, samples=hiss[:800]), RESPEAKER_ODAS)


def test_an_array_upside_down_has_its_sides_exchanged() -> None:
    found = Orientation(yaw=0.3, yaw_sd=0.01, mirrored=True, residual=0.0)
    turned = oriented(ARRAYS["tetrahedron"], found)
    assert np.allclose(turned.positions, ARRAYS["tetrahedron"].positions * (1, -1, -1))
