"""Experiments that compute the chapter's figures and tables again: what there is, runs, and their files."""

from typing import Annotated

import msgspec
from fastapi import Path
from fastapi.responses import FileResponse
from pydantic import Field

from console.access.roles import ANY_FILE, needs
from console.api import HistoryInUse, RequestBody, Who, part, router, sends_file
from console.experiments.runs import ExperimentEntry, ExperimentRuns, ExperimentRunState
from console.http.downloads import named

experiments = router("experiments", 404, 409, 503, 507)
ExperimentsInUse = Annotated[ExperimentRuns, part(ExperimentRuns)]

Id = Annotated[str, Path(max_length=40)]
MOST_RUNS = 10_000
CLOSED = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; sandbox"
FIGURES = {".svg": "image/svg+xml", ".png": "image/png"}


class ExperimentRequest(RequestBody):
    """A run of an experiment; without `runs` as many as it names itself. The same seed gives the same answer."""

    experiment: str = Field(max_length=60)
    runs: int | None = Field(default=None, ge=1, le=MOST_RUNS)
    seed: int = Field(default=0, ge=0, le=10**15)


class ExperimentList(msgspec.Struct, frozen=True):
    """All experiments, and all runs."""

    experiments: list[ExperimentEntry] | None  # None: still being read; ask again in a moment
    runs: list[ExperimentRunState]  # newest first


@experiments.get("/experiments")
@needs("viewer")
async def every(kept: ExperimentsInUse) -> ExperimentList:
    """Every experiment with what it reproduces and how long it takes, and all runs, newest first. The first time the
    experiments take a moment.
    """
    return ExperimentList(kept.catalogue.known, [run.shown for run in reversed(kept.runs.values())])


@experiments.post("/experiments/runs", status_code=202)
@needs("operator")
async def begin(
    asked: ExperimentRequest, kept: ExperimentsInUse, history: HistoryInUse, who: Who
) -> ExperimentRunState:
    """Run one in processes of its own, one at a time; how it goes stands in the run. The robot is not asked."""
    run = kept.begin(asked.experiment, asked.runs, asked.seed, who)
    history.add("experiment", who, words=run.entry.name)
    return run.shown


@experiments.get("/experiments/runs/{id}")
@needs("viewer")
async def one(id: Id, kept: ExperimentsInUse) -> ExperimentRunState:
    """One run: how far it is, its figures beside the chapter's, its text and its files."""
    return kept.find(id).shown


@experiments.post("/experiments/runs/{id}/cancel")
@needs("operator")
async def cancel(id: Id, kept: ExperimentsInUse) -> ExperimentRunState:
    """End it with all its processes; the files so far stay."""
    run = kept.find(id)
    await kept.cancel(run)
    return run.shown


@experiments.delete("/experiments/runs/{id}", status_code=204)
@needs("operator")
async def delete(id: Id, kept: ExperimentsInUse) -> None:
    """Delete it and its files for good."""
    await kept.delete(kept.find(id))


@experiments.get("/experiments/runs/{id}/files/{name}", **sends_file(ANY_FILE, *FIGURES.values()))
@needs("viewer")
async def file(id: Id, name: Annotated[str, Path(max_length=100)], kept: ExperimentsInUse) -> FileResponse:
    """One of its files, the same as the command line writes: a figure to look at, or a download."""
    path = kept.file(kept.find(id), name)
    kind = FIGURES.get(path.suffix)
    headers = {"Content-Security-Policy": CLOSED} if kind else named(f"{id}-{name}")
    return FileResponse(path, media_type=kind or ANY_FILE, headers=headers)
