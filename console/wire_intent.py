"""Orders, and a spoken one that waits, as they go over the sockets."""

from __future__ import annotations

import msgspec

Struct = msgspec.Struct


class Order(Struct):
    """An order as it was understood."""

    id: int
    name: str
    numbers: dict[str, float]
    heard_as: str
    source: str
    who: str


class IntentState(Order):
    """A spoken order that was understood and has not begun, and what it would do as the robot stands now."""

    begins_in_s: float
    moment_s: float  # that it waits in all
    unsure: bool  # a number in it may have been another
    way: list[tuple[float, float]]  # in the world frame; a straight line or an arc, not a plan
    goal: tuple[float, float] | None  # in the world frame
    heading_rad: float | None  # to which it would turn; world
    bearing_rad: float | None  # of who spoke, in the robot's frame as it stands now
    bearing_sd_rad: float | None
