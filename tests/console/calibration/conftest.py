"""A console with the fixed simulated robot, for the wizards' tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.console.live import Live


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """One console for the tests of a module."""
    with Live(tmp_path_factory.mktemp("bench")) as live:
        yield live
