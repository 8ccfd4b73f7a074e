"""Runs of a benchmark by number, on several processes."""

import sys
from collections.abc import Callable
from typing import Any

from core.experiments.campaign import Campaign
from core.experiments.plan import ExperimentPlan, RunBatch


def carried_out(work: Callable[[int], Any], count: int, workers: int | None) -> list[Any]:
    """`work` on 0 … count - 1 → the answers in that order; how far it is stands on standard error."""
    plan = ExperimentPlan((RunBatch(work, count, object),), dict)
    return Campaign("benchmark", tell=lambda words: sys.stderr.write(f"{words}\n"), workers=workers).answers(plan)[0]
