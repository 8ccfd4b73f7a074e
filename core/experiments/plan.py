"""Plan of an experiment: its runs by number, and the result that their answers make; a campaign carries it out."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

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
