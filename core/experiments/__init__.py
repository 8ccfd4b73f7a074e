"""One file per figure or table; EXPERIMENTS is the table of contents."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

from core.experiments.campaign import Campaign
from core.experiments.plan import About, ExperimentPlan
from core.experiments.result import ExperimentResult
from core.files import check_folder


class Experiment:
    """One experiment; its module is imported when it is first needed."""

    def __init__(self, name: str) -> None:
        self._name, self._module = name, f"core.experiments.{name.replace('-', '_')}"

    def __call__(
        self,
        *,
        seed: int = 0,
        out: Path | None = None,
        tell: Callable[[str], None] | None = None,
        workers: int | None = None,
        cluster: str = "",
        resume: bool = False,
        **options: Any,
    ) -> ExperimentResult:
        """Plan it with its options (`runs=` …) and carry it out → the result, ready for JSON.

        Raises Unwritable for `out` beforehand.
        """
        if out is not None:
            check_folder(out)
        return self.carry_out(Campaign(self._name, seed, out, tell, workers, cluster, resume), options)

    def carry_out(self, campaign: Campaign, options: Mapping[str, Any]) -> ExperimentResult:
        """Plan it with its options and carry it out as a campaign; one that takes workers starts them itself."""
        if "workers" in self.options:
            options = {**options, "workers": campaign.workers, "cluster": campaign.cluster}
            campaign = replace(campaign, workers=1, cluster="")
        return campaign.carry_out(self.plan(seed=campaign.seed, **options))

    def plan(self, **options: Any) -> ExperimentPlan:
        """The experiment with these options. Raises BadInput, Unavailable."""
        return import_module(self._module).plan(**options)

    @property
    def options(self) -> frozenset[str]:
        """The names of what `plan` takes."""
        return frozenset(signature(import_module(self._module).plan).parameters)

    @property
    def about(self) -> About:
        """The experiment's declaration of itself."""
        return import_module(self._module).ABOUT


EXPERIMENTS: dict[str, Experiment] = {
    name: Experiment(name)
    for name in (
        "audio-visual",
        "audio-visual-recorded",
        "camera-table",
        "dead-reckoning-vs-slam",
        "direction-ablation",
        "direction-of-arrival",
        "drawn-rooms",
        "figure-16-conditions",
        "parallel",
        "printed-and-ours",
        "speech-quality",
        "stereo",
        "table-2",
        "tour",
    )
}
