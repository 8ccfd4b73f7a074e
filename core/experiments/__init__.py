"""One file per figure or table; EXPERIMENTS is the table of contents."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from core.experiments.result import ExperimentResult
from core.files import check_folder

Experiment = Callable[..., ExperimentResult]
"""`run(runs=, seed=, out=, tell=)` → what came out, ready for JSON. Raises Unwritable for `out` beforehand."""


def _in(module: str) -> Experiment:
    """The experiment of that module, imported when it is run."""

    def run(**options: Any) -> ExperimentResult:
        if options.get("out") is not None:
            check_folder(options["out"])
        return import_module(f"core.experiments.{module}").run(**options)

    return run


EXPERIMENTS: dict[str, Experiment] = {
    "audio-visual": _in("audio_visual"),
    "camera-table": _in("camera_table"),
    "dead-reckoning-vs-slam": _in("dead_reckoning_vs_slam"),
    "direction-of-arrival": _in("direction_of_arrival"),
    "figure-16-conditions": _in("figure_16_conditions"),
    "printed-and-ours": _in("printed_and_ours"),
    "speech-quality": _in("speech_quality"),
    "table-2": _in("table_2"),
    "tour": _in("tour"),
}
