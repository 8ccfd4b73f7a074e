"""An experiment's declaration of itself, in its own file as ABOUT, and its plan, which a campaign carries out.

A plan has runs by number, and the result that their answers make.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from core.message import message

T = TypeVar("T")


@dataclass(frozen=True)
class RunBatch(Generic[T]):
    """Runs of one kind. `work` comes from a module, draws its chance from the number alone, and keeps nothing."""

    work: Callable[[int], T]  # 0 … count - 1 → the answer
    count: int
    kind: type[T]  # of an answer: a message, a TypedDict or a list of them


@dataclass(frozen=True)
class ExperimentPlan:
    """Batches of runs, and `result(out, answers of the first batch, …)`, which writes the files of `out` if any."""

    batches: tuple[RunBatch[Any], ...]
    result: Callable[..., Any]

    @property
    def count(self) -> int:
        """Number of all runs."""
        return sum(batch.count for batch in self.batches)

    def batch_of(self, number: int) -> tuple[RunBatch[Any], int]:
        """The batch of a run, and the run's number in it."""
        for batch in self.batches:
            if number < batch.count:
                return batch, number
            number -= batch.count
        raise IndexError(number)

    def finish(self, answers: list[Any], out: Path | None) -> Any:
        """Make the result of all answers, in the order of their runs. Raises Unwritable."""
        parts: list[list[Any]] = []
        begin = 0
        for batch in self.batches:
            parts.append(answers[begin : begin + batch.count])
            begin += batch.count
        return self.result(out, *parts)


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
