"""The console's hand on the gate: a stop is final, whatever the pilot was just computing."""

import threading
from typing import Any

import numpy as np

from console.messages.inbound import JogMessage
from console.robot.setpoint_sender import SetpointSender
from core.gate import Twist
from core.gate.setpoint import Setpoint
from core.geometry import Pose
from core.slam.estimate import Estimate, SlamHealth
from core.slam.map.occupancy import OccupancyGrid
from core.slam.motion import Increment
from core.snapshot import Snapshot

SURE = Estimate(pose=Pose(), covariance=np.zeros((3, 3)))
EMPTY = OccupancyGrid(revision=0, resolution=0.05, origin=np.zeros(2), log_odds=np.zeros((0, 0), np.float32))


def wanting(press: int, v: float) -> Snapshot:
    """A snapshot whose undertaking asks for a speed."""
    nothing = np.zeros((0, 2))
    return Snapshot(
        increment=Increment(),
        stamp=0.0,
        estimate=SURE,
        dead_reckoning=SURE,
        velocity=Twist(),
        setpoint=Twist(v, 0.0),
        setpoint_command_id=press,
        nonce=7,
        scan_points=nothing,
        slam=SlamHealth(),
        grid=EMPTY,
        trail=nothing,
        dead_reckoning_trail=nothing,
        path=nothing,
    )


class Diary:
    """Writes down what the robot is told, in its order."""

    def __init__(self) -> None:
        self.told: list[Any] = []

    def send(self, setpoint: Setpoint) -> None:
        self.told.append(setpoint)

    def __getattr__(self, name: str) -> Any:
        return lambda *given: self.told.append((name, *given))


def test_only_what_is_entrusted_drives_and_under_its_own_lease() -> None:
    diary = Diary()
    setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
    setpoint_sender.follow(wanting(5, 0.1))
    assert diary.told == []
    setpoint_sender.authorize(5, 3)
    setpoint_sender.follow(wanting(5, 0.1))
    (order,) = diary.told
    assert (order.epoch, order.press, order.v, order.nonce, order.source) == (3, 5, 0.1, 7, "goal")
    setpoint_sender.follow(wanting(6, 0.2))
    assert diary.told[-1].v == 0.0 and diary.told[-1].press == 5


def test_after_a_stop_nothing_that_was_entrusted_before_moves() -> None:
    for stop in ("stop", "halt"):
        diary = Diary()
        setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
        setpoint_sender.authorize(5, 3)
        setpoint_sender.follow(wanting(5, 0.1))
        getattr(setpoint_sender, stop)()
        setpoint_sender.follow(wanting(5, 0.1))
        setpoint_sender.follow(wanting(5, 0.1))
        after = diary.told[diary.told.index((stop,)) :]
        assert not any(isinstance(order, Setpoint) and order.v for order in after)
        setpoint_sender.authorize(6, 3)
        setpoint_sender.follow(wanting(6, 0.1))
        assert diary.told[-1].v == 0.1


def test_a_hand_over_goes_through_zero_and_forgets_the_goals() -> None:
    diary = Diary()
    setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
    setpoint_sender.authorize(5, 3)
    setpoint_sender.hand_over(4, "Bert")
    setpoint_sender.follow(wanting(5, 0.1))
    assert diary.told == [("disarm",), ("arm", 4, "Bert")]
    setpoint_sender.hand_over(5, None)
    assert diary.told[-1] == ("disarm",)


def test_numbers_rise_so_that_no_order_looks_older_than_one_before() -> None:
    diary = Diary()
    setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
    setpoint_sender.authorize(1, 1)
    for _ in range(10):
        setpoint_sender.follow(wanting(1, 0.1))
    numbers = [order.seq for order in diary.told]
    assert numbers == sorted(set(numbers))


def test_a_jog_goes_as_the_hand_gave_it() -> None:
    diary = Diary()
    SetpointSender(diary).jog(JogMessage(v=0.2, w=-0.1, press=9, seq=8, nonce=7, epoch=6))  # type: ignore[arg-type]
    assert diary.told == [Setpoint(6, 8, "jog", 9, 0.2, -0.1, 7)]


def test_no_order_slips_between_a_stop_and_its_end_however_the_threads_run() -> None:
    diary = Diary()
    setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
    over = threading.Event()

    def pilot() -> None:
        while not over.is_set():
            setpoint_sender.follow(wanting(1, 0.1))

    thread = threading.Thread(target=pilot)
    thread.start()
    for _ in range(200):
        setpoint_sender.authorize(1, 1)
        setpoint_sender.stop()
    over.set()
    thread.join()
    last_stop = len(diary.told) - 1 - diary.told[::-1].index(("stop",))
    assert not any(isinstance(order, Setpoint) and order.v for order in diary.told[last_stop:])


def test_a_flood_of_stops_is_few_until_something_is_ordered() -> None:
    diary = Diary()
    setpoint_sender = SetpointSender(diary)  # type: ignore[arg-type]
    for _ in range(1000):
        setpoint_sender.stop()
    assert 1 <= diary.told.count(("stop",)) < 100
    diary.told.clear()
    for _ in range(3):
        setpoint_sender.jog(JogMessage(v=0.1, w=0.0, press=1, seq=1, nonce=1, epoch=1))
        setpoint_sender.stop()
        setpoint_sender.halt()
        setpoint_sender.arm(1, "Anna")
        setpoint_sender.stop()
    assert diary.told.count(("stop",)) == 6 and diary.told.count(("halt",)) == 3
    setpoint_sender.authorize(5, 3)
    setpoint_sender.stop()
    setpoint_sender.follow(wanting(5, 0.1))
    assert diary.told[-1] == ("stop",)
