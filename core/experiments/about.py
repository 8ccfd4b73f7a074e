"""Declaration that every experiment makes of itself, in its own file as ABOUT."""

from collections.abc import Mapping, Sequence
from typing import cast

from core.message import message


@message
class ChapterValue:
    """A figure that the chapter prints, and where ours stands in the result."""

    name: str
    value: float
    unit: str = ""
    ours: str  # keys of the result, joined by dots; numbers are places in a list


@message
class About:
    """Description of an experiment."""

    title: str
    reproduces: str  # of the chapter, in a sentence; conditions that make the result easier belong here
    runs: int  # when nobody says anything else
    seed: int = 0  # of the figures that the documentation holds
    counts: str = "runs"  # what `runs` counts
    base_s: float  # [s] of processor time before the first run, and
    run_s: float  # for each run, both measured on one core of a server; 0 and 0: not measured
    chapter: tuple[ChapterValue, ...] = ()
    swept: tuple[str, ...] = ()  # keys of the figures that a sweep over settings shows


def figure_at(result: Mapping[str, object], keys: str) -> float | None:
    """The number at "estimators.ekf_slam.worst_average_error_m" of a result; None where there is none."""
    here: object = result
    for key in keys.split("."):
        if isinstance(here, Mapping):
            here = here.get(key)
        elif isinstance(here, Sequence) and not isinstance(here, str) and key.isdigit():
            listed = cast(Sequence[object], here)
            here = listed[int(key)] if int(key) < len(listed) else None
        else:
            return None
    return float(here) if isinstance(here, (int, float)) and not isinstance(here, bool) else None
