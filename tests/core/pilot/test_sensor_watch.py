"""Every sensor has an age and a rate of its own."""

from dataclasses import replace

import numpy as np

from core.geometry import Pose
from core.pilot.sensor_watch import SensorWatch, loss
from core.robots import Profile
from core.sensors import Camera, Image, Laser, Scan, SensorFrame, Wheels
from core.snapshot import SensorStatus

PROFILE = Profile(
    name="two lasers",
    url="",
    lasers=(Laser(name="front", rate=10.0), Laser(name="rear", rate=2.0)),
    cameras=(Camera(rate=10.0),),
)


def frame(stamp: float, *lasers: str, image: bool = False, wheels: bool = True) -> SensorFrame:
    return SensorFrame(
        stamp=stamp,
        wheels=Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0) if wheels else None,
        scan=Scan(stamp=stamp, laser=lasers[0], ranges=np.ones(3), angle_min=0.0, angle_step=0.1) if lasers else None,
        image=Image(stamp=stamp, pixels=np.zeros((2, 2, 3), np.uint8)) if image else None,
    )


def states(watch: SensorWatch, seen: SensorFrame) -> dict[str, str]:
    return {f"{one.kind} {one.name}".strip(): one.state for one in watch.update(seen)}


def test_each_sensor_is_late_and_lost_by_its_own_rate() -> None:
    watch = SensorWatch(PROFILE, float("inf"))
    assert set(states(watch, frame(0.0, "front")).values()) == {"live"}
    states(watch, frame(0.1, "rear", image=True))
    assert states(watch, frame(0.45, "front")) == {
        "wheels": "live",
        "laser front": "live",
        "laser rear": "live",
        "camera camera": "stale",
    }
    found = states(watch, frame(1.2, wheels=False))
    assert found == {"wheels": "lost", "laser front": "lost", "laser rear": "live", "camera camera": "lost"}
    assert states(watch, frame(3.3))["laser rear"] == "lost"


def test_what_is_lost_is_named_where_there_are_several() -> None:
    watch = SensorWatch(PROFILE, 0.0)
    rear = next(one for one in watch.update(frame(9.0, "front", image=True)) if one.name == "rear")
    assert loss(rear, alone=False) == "No scan comes from the laser rear."
    assert loss(rear, alone=True) == "No scan comes from the laser."


def test_a_recording_promises_nothing() -> None:
    profile = Profile(name="log", url="", lasers=(Laser(),), capabilities=frozenset({"replay"}))
    assert SensorWatch(profile, 0.0).update(frame(9.0)) == ()


def test_odometry_is_as_old_as_its_reading_and_due_at_the_rate_it_came() -> None:
    watch = SensorWatch(PROFILE, 0.0)

    def wheels(stamp: float, age: float, rate: float | None) -> SensorStatus:
        reading = Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0, age=age, rate=rate)
        return next(one for one in watch.update(SensorFrame(stamp=stamp, wheels=reading)) if one.kind == "wheels")

    assert wheels(1.0, 0.01, None).rate == 10.0
    assert wheels(2.0, 0.01, 50.0).rate == 50.0
    slower = wheels(3.0, 0.3, 3.0)
    assert (slower.rate, slower.state, round(slower.age, 3)) == (50.0, "stale", 0.3)
    assert wheels(4.0, 0.6, 3.0).state == "lost"


def test_a_scan_is_judged_by_its_stamp_with_the_lasers_time_offset() -> None:
    watch = SensorWatch(replace(PROFILE, lasers=(Laser(name="front", time_offset=0.6),)), 0.0)
    seen = replace(frame(1.0), scan=frame(0.4, "front").scan)
    assert states(watch, seen)["laser front"] == "live" and not watch.untimely("laser")
    ahead = frame(1.1, "front")
    states(watch, ahead)
    assert watch.untimely("laser") and watch.believed(ahead).scan is None
