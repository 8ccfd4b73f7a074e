"""The chapter's own forms by one switch."""

import dataclasses
import math

import numpy as np
import pytest

from core.experiments.rehearsal import Rehearsal
from core.perception.sound.locate import locate
from core.perception.sound.multi_source import talkers
from core.perception.sound.paper import locate_as_printed
from core.sensors.microphones import ARRAYS, Sound
from core.settings import Settings, as_printed, read
from core.slam.association.nearest_neighbour import nearest

PRINTED = read('[chapter]\nmode = "printed"\n')


def test_one_line_in_the_file_puts_the_chapter_s_forms_in_place_and_leaves_the_rest() -> None:
    assert as_printed(Settings()) == PRINTED
    changed = {
        one.name
        for one in dataclasses.fields(Settings)
        if getattr(PRINTED, one.name) != getattr(Settings(), one.name)
    }
    assert changed == {"chapter", "ekf", "edges", "matching", "direction_finding"}
    assert PRINTED.edges.edge_required and not PRINTED.matching.corrects
    assert (PRINTED.ekf.mode, PRINTED.ekf.form, PRINTED.ekf.sighting_noise) == ("paper", "nearest", "paper")
    assert read("") == Settings() and read('[chapter]\nmode = "ours"\n') == Settings()


def test_what_the_file_says_besides_stays() -> None:
    told = read('[chapter]\nmode = "printed"\n[ekf]\nrange_sd = 0.05\n[steering]\nlookahead = 0.3\n')
    assert told.ekf.range_sd == 0.05 and told.steering.lookahead == 0.3 and told.ekf.mode == "paper"


def test_every_sighting_goes_alone_to_its_nearest_landmark_and_is_new_beyond_the_gate() -> None:
    distances = np.array([[1.0, 4.0], [2.0, 9.0], [50.0, 60.0]])
    found = nearest(distances, 10.0)
    assert found.matches == ((0, 0), (1, 0)) and found.fresh == (2,)
    nothing_known = nearest(np.zeros((2, 0)), 10.0)
    assert nothing_known.matches == () and nothing_known.fresh == (0, 1)


def test_in_the_printed_mode_every_way_to_a_direction_is_the_chapter_s() -> None:
    array = next(iter(ARRAYS.values()))
    noise = np.random.default_rng(2).standard_normal((8000, max(array.channels) + 1))
    sound = Sound(stamp=0.0, rate=16000, samples=noise)
    printed = locate_as_printed(sound, array).towards
    alone = locate(sound, array, settings=PRINTED.direction_finding)
    (among,) = talkers(sound, array, settings=PRINTED.direction_finding)
    assert alone is not None
    assert alone.towards == pytest.approx(printed) and among.towards == pytest.approx(printed)


def test_the_whole_robot_drives_by_the_chapter_s_forms_without_scan_matching() -> None:
    robot = Rehearsal("sim:lab", seed=1, settings=PRINTED)
    robot.run(1.0)
    assert robot.say("turn left", seconds=30.0).state == "done"
    assert robot.snapshot.slam.mode == "paper"
    assert robot.snapshot.floor.match_score is None
    assert robot.snapshot.estimate.pose.heading == pytest.approx(math.pi / 2, abs=0.3)
