"""Fixtures that every room shares."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

for library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(library, "1")  # as in the console; must come before the first import of numpy

REPOSITORY = Path(__file__).resolve().parent.parent
BEHIND = 10  # niceness of tests that only compute
LIVE = ("browser", "console")  # folders whose tests share a running console, which keeps real time


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that keep real time run one after another in one process, the others beside them, file by file."""
    items.sort(key=lambda item: folder_of(item) not in LIVE)
    for item in items:
        group = "live" if folder_of(item) in LIVE else item.path.name
        item.add_marker(pytest.mark.xdist_group(group))


def pytest_runtest_setup(item: pytest.Item) -> None:
    """What only computes steps back behind what keeps real time."""
    if "PYTEST_XDIST_WORKER" in os.environ and folder_of(item) not in LIVE and hasattr(os, "nice"):
        os.nice(BEHIND - os.nice(0))


def folder_of(item: pytest.Item) -> str:
    """The first folder under tests/."""
    return item.path.relative_to(REPOSITORY / "tests").parts[0]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--require-browser", action="store_true", help="fail where browser tests would skip")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real recordings beside the repository; tests that need it skip where it is absent."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"The real recordings are not here: {folder.name}/ is expected beside the repository in shared/.")
    return folder
