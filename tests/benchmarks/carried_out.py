"""Runs of a benchmark by number, on several processes."""

from collections.abc import Callable
from typing import Any

from core.experiments.campaign import Campaign
from core.experiments.plan import ExperimentPlan, RunBatch


def carried_out(
    work: Callable[[int], Any], count: int, workers: int | None, tell: Callable[[str], None] | None = None
) -> list[Any]:
    """`work` on 0 … count - 1 → the answers in that order."""
    plan = ExperimentPlan((RunBatch(work, count, object),), dict)
    return Campaign("benchmark", tell=tell, workers=workers).answers(plan)[0]
