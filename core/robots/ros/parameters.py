"""Parameters of a robot's nodes that the console asks for: after how long a silence its base stops by itself."""

from collections.abc import Iterable

TIMEOUT = "cmd_vel_timeout"  # of the robot's controller
LONGEST_TIMEOUT = 60.0  # [s]


def stopping(values: Iterable[object]) -> float | None:
    """Values of `cmd_vel_timeout` [s] → the worst of them: 0, which is never, else the longest; None: no value."""
    usable = [
        float(value)
        for value in values
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < LONGEST_TIMEOUT
    ]
    return 0.0 if 0.0 in usable else max(usable, default=None)
