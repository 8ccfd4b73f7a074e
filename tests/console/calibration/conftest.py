"""The console that all tests of this folder's parent share, left as it was found."""

from collections.abc import Iterator

import pytest

from tests.console.live import Live


@pytest.fixture(scope="module")
def bench(shared_live: Live) -> Iterator[Live]:
    """One console for the tests of a module; its sessions are gone afterwards."""
    yield shared_live
    for row in shared_live.ask("GET", "/api/calibration/sessions", token=shared_live.viewer).json["sessions"]:
        shared_live.ask("DELETE", f"/api/calibration/sessions/{row['id']}", token=shared_live.operator)
