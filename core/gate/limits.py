"""The limits that no setpoint may exceed."""

import math
from dataclasses import dataclass, fields
from typing import Annotated, Self, TypeGuard

from core.errors import BadInput
from core.setting import Meta, Section


@dataclass(frozen=True)
class Limits(Section):
    """The gate's settings. Every one has a hard range, and none can be switched off.

    Watch:
        max_speed: time of a way, and the distance until the robot stands
        max_turn_rate: time of a turn, and walls that blur in it
        max_acceleration: slipping wheels (then lower it)
        max_turn_acceleration: slipping wheels in turns (then lower it)
        deadman: halts on a poor network (then raise it); the way driven without a console grows with it
        nonce_age: halts on a slow network (then raise it)
        scan_age: halts with a slow laser (then raise it)
        heartbeat: halts under load (then raise it); the way driven without a console grows with it
        radius: touched furniture, and halts before narrow doors
        margin: touched furniture (then raise it), halts before narrow doors (then lower it)
        guard: speed, and touched furniture: without a guard nobody else sees it
    """

    max_speed: Annotated[float, Meta("m/s", 0.01, 1, "highest speed", common=True)] = 0.3
    max_turn_rate: Annotated[float, Meta("rad/s", 0.05, 6, "highest turn rate", common=True)] = 1.5
    max_acceleration: Annotated[float, Meta("m/s²", 0.05, 5, "highest acceleration", common=True)] = 1.0
    max_turn_acceleration: Annotated[float, Meta("rad/s²", 0.1, 30, "highest turn acceleration")] = 6.0
    deadman: Annotated[float, Meta("s", 0.1, 1, "silence after which a setpoint ends")] = 0.25
    nonce_age: Annotated[
        float, Meta("s", 0.15, 1, "time from a nonce to the setpoint that returns it, at most: covers the round trip")
    ] = 0.4
    scan_age: Annotated[float, Meta("s", 0.1, 1, "age from which a scan says nothing about obstacles")] = 0.3
    heartbeat: Annotated[
        float, Meta("s", 0.1, 1, "silence of the console that stops the robot: three heartbeats missing")
    ] = 0.15
    radius: Annotated[float, Meta("m", 0.02, 1, "radius of the round body")] = 0.09
    margin: Annotated[float, Meta("m", 0.005, 0.3, "distance that the guard keeps around the body")] = 0.03
    guard: Annotated[bool, Meta(meaning="false (a robot without a laser): 0.2 m/s at most")] = True

    @classmethod
    def of(cls, given: dict[str, object]) -> Self:
        """Names and values → limits; raises BadInput with a sentence for an unknown name or a bad value."""
        known = {field.name for field in fields(cls)}
        for name in given:
            if name not in known:
                raise BadInput(f"There is no limit called {name!r}; known are {', '.join(sorted(known))}.")
        return cls(**given)  # type: ignore[arg-type]


UNGUARDED_SPEED_M_S = 0.2  # the most when nothing looks where the robot goes
STOPPING_WAY_M = 0.5  # within which a robot must stand whose operator sees late


def speed_cap(limits: Limits, age: float) -> float:
    """The highest speed [m/s] for setpoints of `age` [s]: v·(age + 0.3) + v²/(2a) ≤ STOPPING_WAY."""
    reach = limits.max_acceleration * (age + 0.3)
    cap = math.sqrt(reach * reach + 2 * limits.max_acceleration * STOPPING_WAY_M) - reach
    return min(cap, limits.max_speed if limits.guard else min(limits.max_speed, UNGUARDED_SPEED_M_S))


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number; a bool is not."""
    if type(value) is int:
        return abs(value) < 2**53
    return type(value) is float and math.isfinite(value)


def is_count(value: object) -> TypeGuard[int]:
    """Return whether a value is an integer from 0 to what a browser can count; a bool is not."""
    return type(value) is int and 0 <= value < 2**53
