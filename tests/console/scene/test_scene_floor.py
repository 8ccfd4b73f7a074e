"""Rooms, closures, candidates and rejected sightings as strokes of the scene."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from console.scene.overlays.landmarks import crosses, dashes, places
from console.scene.overlays.marks import outlines
from console.scene.overlays.occupancy import Occupancy
from console.scene.overlays.pose_ellipse import POINTER_RADII, outline, stood
from console.scene.overlays.submaps import MAX_ARCH_M, MIN_ARCH_M, arch, frame, strokes_of
from core.geometry import Pose
from core.message import Array
from core.navigation.zones import MapZone
from core.robots import Profile
from core.slam.estimate import Association
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import ClosureStatus, SubmapView


def closure(state: str, end: tuple[float, float] = (4.0, 3.0)) -> ClosureStatus:
    return ClosureStatus(
        id=1, stamp=1.0, submap_from=2, submap_to=0, position_from=np.zeros(2), position_to=np.array(end),
        score=0.9, state=state,  # type: ignore[arg-type]
    )  # fmt: skip


@pytest.mark.parametrize("length", [0.01, 1.0, 5.0, 100.0])
def test_an_arch_stands_on_both_its_places_and_can_be_seen(length: float) -> None:
    spans = arch(np.zeros(2), np.array([length, 0.0]))
    assert spans[0, 0, :2] == pytest.approx([0, 0]) and spans[-1, 1, :2] == pytest.approx([length, 0])
    assert MIN_ARCH_M <= spans[..., 2].max() <= MAX_ARCH_M + 0.1
    assert spans[1:, 0] == pytest.approx(spans[:-1, 1])  # without gaps


def test_a_zone_is_outlined_all_around() -> None:
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    spans = outlines([MapZone(name="hole", kind="keep_out", points=corners)])
    assert spans[:, 0, :2] == pytest.approx(corners) and spans[:, 1, :2] == pytest.approx(
        np.roll(corners, -1, axis=0)
    )
    assert len(outlines([])) == 0


def test_an_undone_closure_is_drawn_broken() -> None:
    assert len(strokes_of(closure("undone"))) < len(strokes_of(closure("accepted")))


def test_a_rooms_frame_turns_with_the_room() -> None:
    extent = np.array([[-1.0, -2.0], [3.0, 2.0]])
    room = SubmapView(id=0, pose=Pose(5, 1, math.pi / 2), extent=extent, active=True)
    corners = frame(room)[:, 0, :2]
    expected = room.pose.apply(np.array([[-1, -2], [3, -2], [3, 2], [-1, 2]], float))
    assert np.unique(corners.round(6), axis=0) == pytest.approx(np.unique(expected.round(6), axis=0))


def test_a_candidate_looks_where_the_robot_would() -> None:
    segments = stood(outline(0.1), np.array([2.0, 1.0, math.pi / 2]))
    assert segments[-1, 1] == pytest.approx([2.0, 1.0 + 0.1 * POINTER_RADII, 0.02])
    assert np.hypot(*(segments[:-1, 0, :2] - (2.0, 1.0)).T) == pytest.approx(0.1)


def test_rejected_sightings_are_told_from_those_on_trial() -> None:
    fates = ("matched", "ignored", "tentative", "new")
    seen = tuple(
        Association(position=np.array([float(row), 0.0]), landmark=None, fate=fate) for row, fate in enumerate(fates)
    )
    assert places(seen, ("ignored",)).tolist() == [[1.0, 0.0]]
    assert places(seen, ("tentative", "new"))[:, 0].tolist() == [2.0, 3.0]
    assert places((), ("matched",)).shape == (0, 2)
    assert len(crosses(places((), ("matched",)))) == 0 and len(dashes(np.zeros(2), np.zeros((0, 2)))) == 0
    broken = dashes(np.zeros(2), np.array([[1.0, 0.0]]))
    assert 0.3 < np.abs(np.diff(broken[..., 0], axis=1)).sum() < 0.7


class Picture:
    """What the scene keeps of an image."""

    def __init__(self, image: Array) -> None:
        self.image = image

    def remove(self) -> None: ...


class Sheet:
    """A scene that counts its pictures."""

    def __init__(self) -> None:
        self.pictures: list[Picture] = []

    def add_image(self, name: str, image: Array, **_: Any) -> Picture:
        self.pictures.append(Picture(image))
        return self.pictures[-1]


def test_the_map_is_drawn_when_it_changed_at_most_twice_a_second_and_another_map_of_the_same_number_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = [100.0]
    monkeypatch.setattr("console.scene.overlays.occupancy.time", SimpleNamespace(monotonic=lambda: now[0]))
    sheet = Sheet()
    overlay = Occupancy(sheet, Profile(name="r", url="sim:"))  # type: ignore[arg-type]

    def shown(number: float, seconds: float) -> Array:
        now[0] += seconds
        overlay.show(SimpleNamespace(grid=grids[number]))  # type: ignore[arg-type]
        return sheet.pictures[-1].image

    grids = {
        value: OccupancyGrid(
            revision=1, resolution=0.1, origin=np.zeros(2), log_odds=np.full((4, 5), value, np.float32)
        )
        for value in (-2.0, 2.0)
    }
    free = shown(-2.0, 1.0)
    assert shown(2.0, 0.1) is free  # too soon
    wall = shown(2.0, 0.5)
    assert wall is not free and (wall != free).any()
    assert shown(2.0, 5.0) is wall and len(sheet.pictures) == 1  # nothing new, and the node stays
