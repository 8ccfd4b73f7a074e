"""A robot that stands and has nothing to do is shown less often."""

from dataclasses import replace

import numpy as np

from console.broadcast import Broadcaster, Subscriber
from console.camera_stream import REST_GAP_S, CameraStream
from console.rest import REST_GAP_S as STATE_REST_GAP_S
from console.rest import STANDING_S, StatePace
from core.gate import Twist
from core.pilot import Pilot
from core.sensors import Image
from core.simulation.robot import SimulatedRobot


def test_states_come_seldom_at_rest_and_at_once_when_something_happens() -> None:
    robot = SimulatedRobot("lab")
    snapshot = Pilot(robot.profile).step(robot.read())
    pace = StatePace()
    pace.saw(snapshot)
    pace.sent(10.0, ("nothing",))
    assert pace.due(10.05, ("nothing",))
    assert pace.saw(replace(snapshot, stamp=snapshot.stamp + STANDING_S + 0.1))
    assert not pace.due(10.1, ("nothing",)) and pace.due(10.21, ("nothing",))
    assert pace.due(10.05, ("a notice",))
    pace.saw(replace(snapshot, stamp=snapshot.stamp + STANDING_S + 0.2, velocity=Twist(0.1, 0.0)))
    assert pace.due(10.05, ("nothing",))


def test_where_the_robots_clock_runs_slowly_states_are_as_many_by_it_and_what_happens_comes_at_once() -> None:
    robot = SimulatedRobot("lab")
    snapshot, pace = Pilot(robot.profile).step(robot.read()), StatePace()
    pace.sent(10.0, ("nothing",))
    for share, gap in ((1.0, 0.045), (0.5, 0.09), (0.25, 0.18), (0.03, STATE_REST_GAP_S), (0.0, STATE_REST_GAP_S)):
        pace.saw(replace(snapshot, pace=share))
        assert pace.due(10.001 + gap, ("nothing",)) and not pace.due(9.999 + gap, ("nothing",))
        assert pace.due(10.05, ("a notice",))


def test_pictures_that_look_alike_are_sent_now_and_then_and_a_change_at_once() -> None:
    broadcaster = Broadcaster()
    broadcaster.join(Subscriber("camera"))
    stream, chance = CameraStream(broadcaster), np.random.default_rng(0)
    grey = np.full((256, 320), 100, np.uint8)

    def picture(stamp: float, pixels: np.ndarray) -> Image:
        return Image(stamp=stamp, pixels=pixels)

    def sent(stamp: float, pixels: np.ndarray, at_rest: bool = True) -> bool:
        noise = chance.integers(-6, 7, pixels.shape)
        return stream.encoded(picture(stamp, (pixels + noise).astype(np.uint8)), at_rest) is not None

    assert sent(1.0, grey)
    assert not sent(1.1, grey) and not sent(1.2, grey)
    assert sent(1.25, grey, at_rest=False)
    someone = grey.copy()
    someone[100:200, 150:180] = 60
    assert sent(1.3, someone)
    assert sent(1.3 + REST_GAP_S, someone)
    assert stream.encoded(None) is None
    broadcaster.join(Subscriber("camera"))
    newest = stream.encoded(None)
    assert newest is not None and newest[0] == 1.3 + REST_GAP_S and stream.encoded(None) is None
