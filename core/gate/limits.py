"""The limits that no setpoint may exceed."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TypeGuard

_RANGES = {
    "max_speed": (0.01, 1.0),
    "max_turn_rate": (0.05, 6.0),
    "max_acceleration": (0.05, 5.0),
    "max_turn_acceleration": (0.1, 30.0),
    "deadman": (0.1, 1.0),
    "ticket_age": (0.15, 1.0),
    "scan_age": (0.1, 1.0),
    "heartbeat": (0.1, 1.0),
    "radius": (0.02, 1.0),
    "margin": (0.005, 0.3),
}


@dataclass(frozen=True)
class Limits:
    """The gate's settings. Every one has a hard range: outside it raises ValueError, and none can be switched off."""

    max_speed: float = 0.3  # [m/s]
    max_turn_rate: float = 1.5  # [rad/s]
    max_acceleration: float = 1.0  # [m/s²]
    max_turn_acceleration: float = 6.0  # [rad/s²]
    deadman: float = 0.25  # [s] of silence after which a setpoint ends
    ticket_age: float = 0.4  # [s] that may pass from a ticket to the setpoint that returns it: covers the round trip
    scan_age: float = 0.3  # [s] after which a scan says nothing about what is in the way
    heartbeat: float = 0.15  # [s] without the console's: three are missing
    radius: float = 0.09  # [m] of the round body
    margin: float = 0.03  # [m] that the guard keeps around the body
    guard: bool = True  # False (a robot without a laser): slower, see `UNGUARDED_SPEED`

    def __post_init__(self) -> None:
        if type(self.guard) is not bool:
            raise ValueError("guard must be true or false.")
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not is_number(value) or not low <= value <= high:
                raise ValueError(f"{name} must be a number between {low:g} and {high:g}.")

    @staticmethod
    def of(given: dict[str, object]) -> Limits:
        """Names and values → limits; raises ValueError with a sentence for an unknown name or a bad value."""
        known = {field.name for field in fields(Limits)}
        for name in given:
            if name not in known:
                raise ValueError(f"There is no limit called {name!r}; known are {', '.join(sorted(known))}.")
        return Limits(**given)  # type: ignore[arg-type]


UNGUARDED_SPEED = 0.2  # [m/s], the most when nothing looks where the robot goes
STOPPING_WAY = 0.5  # [m] within which a robot must stand whose operator sees late


def speed_cap(limits: Limits, age: float) -> float:
    """The highest speed [m/s] for setpoints of `age` [s]: v·(age + 0.3) + v²/(2a) ≤ STOPPING_WAY."""
    reach = limits.max_acceleration * (age + 0.3)
    cap = math.sqrt(reach * reach + 2 * limits.max_acceleration * STOPPING_WAY) - reach
    return min(cap, limits.max_speed if limits.guard else min(limits.max_speed, UNGUARDED_SPEED))


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number; a bool is not."""
    if type(value) is int:
        return abs(value) < 2**53
    return type(value) is float and math.isfinite(value)


def is_count(value: object) -> TypeGuard[int]:
    """Return whether a value is an integer from 0 to what a browser can count; a bool is not."""
    return type(value) is int and 0 <= value < 2**53
