"""Straight walls tell whether something was added to every range, and whether ranges are distances at all."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.message import Array
from core.sensors import Laser
from core.slam.scan_matching.wall_shapes import WallShapes, bent_walls
from tests.core.slam.scan_matching.test_agreement import LASER, Member, sound_drive


@pytest.fixture(scope="module")
def drives() -> dict[str, list[Member]]:
    return {world: sound_drive(world) for world in ("lab", "floor", "corridor")}


def codes(drive: list[Member], change: Callable[[Array], Array] = lambda ranges: ranges) -> list[str]:
    shapes = WallShapes(LASER)
    for one in drive:
        shapes.update(replace(one.scan, ranges=change(one.scan.ranges), range_max=30.0), 0.0)
    return [fault.code for fault in shapes.faults]


@pytest.mark.parametrize("world", ["lab", "floor", "corridor"])
def test_sound_scans_have_straight_walls(drives: dict[str, list[Member]], world: str) -> None:
    assert codes(drives[world]) == []


@pytest.mark.parametrize("world", ["floor", "corridor"])
@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda ranges: ranges + 0.3, "scan.offset"),
        (lambda ranges: 1.0 / ranges, "scan.no_distances"),
        (lambda ranges: 8.0 - ranges, "scan.no_distances"),
    ],
)
def test_bent_walls_are_named(
    drives: dict[str, list[Member]], world: str, change: Callable[[Array], Array], code: str
) -> None:
    assert codes(drives[world], change) == [code]


@pytest.mark.parametrize("offset", [-0.25, 0.0, 0.3])
def test_the_offset_of_a_straight_wall_is_measured(offset: float) -> None:
    angles = np.radians(np.arange(-30.0, 30.5, 0.5))
    noise = np.random.default_rng(5).normal(0.0, 0.01, len(angles))
    found, sds, _ = bent_walls(2.0 / np.cos(angles - 0.2) + offset + noise, np.radians(0.5), np.radians(36))
    assert len(found) > 2
    assert np.all(np.abs(found - offset) < 4 * sds + 0.05)


def test_a_corner_is_no_bent_wall() -> None:
    angles = np.radians(np.arange(-30.0, 30.5, 0.5))
    corner = np.minimum(2.0 / np.cos(angles - np.radians(45)), 2.0 / np.cos(angles + np.radians(45)))
    found, _, _ = bent_walls(corner, np.radians(0.5), np.radians(36))
    assert len(found) < 2


def test_no_offset_is_read_from_a_scan_that_turns_quickly(drives: dict[str, list[Member]]) -> None:
    shapes = WallShapes(Laser())
    for one in drives["corridor"]:
        shapes.update(replace(one.scan, ranges=one.scan.ranges + 0.3, range_max=30.0), 1.0)
    assert shapes.faults == ()
