"""Who is looked at, as viewers get it."""

import numpy as np
import pytest

from console.messages import person
from console.scene.overlays.people import strokes_of
from core.geometry import Ray
from core.perception.people.detector import Rectangle, SeenPart
from core.perception.people.tracked_person import TrackedPerson

SEEN = TrackedPerson(
    stamp=10.0,
    position=np.array([2.0, 1.0]),
    covariance=np.diag([0.01, 0.02]),
    velocity=np.zeros(2),
    rectangle=Rectangle(
        value=0.9123,
        shown=0.7,
        distance=2.2,
        bearing=0.4,
        height=1.75,
        parts=(
            SeenPart(name="head", likelihood=None, box=(100.0, -20.0, 140.0, 5.0)),
            SeenPart(name="torso", likelihood=0.95, box=(90.0, 5.0, 150.0, 80.0)),
        ),
        centre=(120.0, 60.0),
        box=(90.0, -20.0, 150.0, 140.0),
    ),
    rectangle_stamp=9.9,
    laser=np.array([2.02, 1.01]),
    camera=Ray(x=0.0, y=0.0, azimuth=0.46, sd=0.02),
    sound=None,
    used=("laser", "camera"),
)


def test_every_sense_is_told_by_itself_and_all_together() -> None:
    told = person.person(SEEN, 10.5, "Ann")
    assert told is not None and told.name == "Ann"
    assert (told.x_m, told.y_m, told.age_s, told.picture_age_s) == (2.0, 1.0, 0.5, pytest.approx(0.6))
    assert told.cov_m2 == [[0.01, 0.0], [0.0, 0.02]]
    assert told.laser == (2.02, 1.01)
    assert told.camera is not None
    assert told.camera.azimuth_world_rad == 0.46
    assert told.sound is None
    assert told.value == 0.912
    assert [(part.name, part.likelihood) for part in told.parts] == [("head", None), ("torso", 0.95)]
    assert person.person(None, 10.5, "Ann") is None


def test_the_scene_draws_ring_ellipse_cross_and_bearing() -> None:
    pieces = strokes_of(SEEN)
    assert len(pieces) == 4
    points = np.concatenate([segment for segment, _ in pieces])[:, :, :2].reshape(-1, 2)
    assert np.hypot(*(points - SEEN.position).T).min() < 0.2
    assert np.isfinite(points).all()
