"""FOLLOW WALL by the whole robot, with the noise of its wheels and laser."""

import dataclasses

import pytest

from core.experiments.rehearsal import Rehearsal
from core.settings import Settings
from core.simulation.settings import SimulationSettings

BLIND = dataclasses.replace(Settings(), simulation=SimulationSettings(camera=False))


@pytest.mark.campaign
def test_the_corridor_is_followed_until_another_command() -> None:
    floor = Rehearsal("sim:floor", seed=2, settings=BLIND)
    order = floor.tell("follow wall")
    floor.run(1.2)
    assert floor.snapshot.active_command is not None
    assert "To the wall on the right first" in floor.snapshot.active_command.remark
    floor.run(15.0)
    assert floor.truth.y == pytest.approx(-0.5, abs=0.05)
    assert floor.truth.x > 0.2
    assert floor.say("stop").state == "done"
    ended = floor.ended(order)
    assert ended is not None
    assert ended.state == "pre-empted"
    assert (floor.contacts, floor.faults()) == (0, [])


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(3))
def test_once_round_the_laboratory_nothing_is_touched(seed: int) -> None:
    lab = Rehearsal("sim:lab", seed=seed, settings=BLIND)
    lab.tell("follow wall")
    went_away = False
    for snapshot in lab.frames(400.0):
        assert snapshot.active_command is not None, lab.endings
        away = lab.truth.distance_to(0.5, -2.0)
        went_away = went_away or away > 3.0
        if went_away and away < 0.3:
            break
    assert went_away
    assert lab.truth.distance_to(0.5, -2.0) < 0.3
    assert (lab.contacts, lab.faults()) == (0, [])
