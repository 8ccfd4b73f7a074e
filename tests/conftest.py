"""Fixtures that every room shares."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

for library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(library, "1")  # as in the console; must come before the first import of numpy

REPOSITORY = Path(__file__).resolve().parent.parent
LIVE = ("benchmarks/", "browser/", "console/", "core/gate/test_gate_process.py")  # these keep real time


class Sharing(LoadScopeScheduling):
    """Tests that keep real time run one after another in one process, the others beside them, file by file."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return "live" if file.removeprefix("tests/").startswith(LIVE) else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Sharing:
    return Sharing(config, log)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """What only computes takes the time that is left over by what keeps real time."""
    if "PYTEST_XDIST_WORKER" in os.environ and hasattr(os, "SCHED_IDLE"):
        policy = os.SCHED_OTHER if is_live(item) else os.SCHED_IDLE
        if os.sched_getscheduler(0) != policy:
            with contextlib.suppress(PermissionError):  # some systems let nobody out of idleness
                os.sched_setscheduler(0, policy, os.sched_param(0))


def is_live(item: pytest.Item) -> bool:
    """Whether a test keeps real time, with processes of a running console."""
    return item.path.relative_to(REPOSITORY / "tests").as_posix().startswith(LIVE)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--require-browser", action="store_true", help="fail where browser tests would skip")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings beside the repository; tests that need it skip where it is absent."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"The real recordings are not here: {folder.name}/ is expected beside the repository in shared/.")
    return folder
