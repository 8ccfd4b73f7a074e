"""One file per figure or table; EXPERIMENTS is the table of contents."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from core.experiments.about import About
from core.experiments.result import ExperimentResult
from core.files import check_folder


class Experiment:
    """One experiment; its module is imported when it is first needed."""

    def __init__(self, module: str) -> None:
        self._module = f"core.experiments.{module}"

    def __call__(self, **options: Any) -> ExperimentResult:
        """`run(runs=, seed=, out=, tell=)` → the result, ready for JSON. Raises Unwritable for `out` beforehand."""
        if options.get("out") is not None:
            check_folder(options["out"])
        return import_module(self._module).run(**options)

    @property
    def about(self) -> About:
        """The experiment's declaration of itself."""
        return import_module(self._module).ABOUT


def _in(module: str) -> Experiment:
    """The experiment of that module."""
    return Experiment(module)


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
