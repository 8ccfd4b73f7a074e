import copy
import math

import numpy as np

from core.geometry import Pose
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.slam.ekf_slam import EkfSettings
from tests.core.slam.frame_slam import FrameSlam

SPREAD = np.diag([0.02**2, math.radians(0.5) ** 2])
ROOM = [(2.0, 1.5), (2.0, -1.5), (-1.5, 1.2), (0.5, 2.0), (3.0, 0.2), (1.0, -2.2)]


def seen_from(pose: Pose, places: list[tuple[float, float]], opening: float | None = None) -> list[Sighting]:
    return [
        Sighting(range=pose.distance_to(*p), bearing=pose.bearing_to(*p), covariance=SPREAD, opening=opening)
        for p in places
    ]


def test_a_landmark_on_probation_takes_no_sighting_from_one_that_is_believed() -> None:
    """Alone, the ghost would fit best. Were it a rival, the sighting would be doubtful and unused."""
    slam = FrameSlam(EkfSettings(still_every=1))
    for _ in range(4):
        slam.see(seen_from(Pose(), ROOM))
    ghost = (ROOM[0][0] + 0.05, ROOM[0][1])
    slam.filter.add(np.array([math.hypot(*ghost), math.atan2(ghost[1], ghost[0])]), SPREAD)
    slam.table.add(seen_from(Pose(), [ghost])[0], 0.0)
    assert slam.health.tentative == 1
    slam.see(seen_from(Pose(), [(ROOM[0][0] + 0.04, ROOM[0][1])]))
    assert [association.landmark for association in slam.associations] == [1]


def test_a_corner_that_opens_elsewhere_is_another_one() -> None:
    slam = FrameSlam(EkfSettings(still_every=1))
    for _ in range(4):
        slam.see(seen_from(Pose(), ROOM[:1], opening=0.0))
    turned = copy.deepcopy(slam)
    slam.see(seen_from(Pose(), ROOM[:1], opening=0.3))
    turned.see(seen_from(Pose(), ROOM[:1], opening=1.6))
    assert slam.associations[0].landmark == 1
    assert turned.associations[0].landmark is None


def test_what_stands_in_plain_sight_and_is_not_made_out_is_missed_until_it_goes() -> None:
    laser, place = Laser(), (2.0, 0.0)
    slam = FrameSlam(EkfSettings(still_every=1, misses=2.0, misses_share=0.5), laser=laser)
    frame = SensorFrame(
        stamp=0.0,
        wheels=Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0),
        scan=Scan(
            stamp=0.0, ranges=np.full(laser.beams, 2.0), angle_min=laser.angle_min, angle_step=laser.angle_step
        ),
    )
    for _ in range(4):
        slam.update(frame, seen_from(Pose(), [(4.0, 0.0)]))  # farther: from 2 m it should be made out all the more
    slam.filter.places[0] = place
    counted = []
    for _ in range(5):
        slam.update(frame, [])
        counted += [landmark.misses for landmark in slam.landmarks]
    assert counted == [1, 2, 3, 4]
