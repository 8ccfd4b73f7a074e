"""A console for the tests of this folder."""

from collections.abc import Iterator

import pytest

from tests.console.live import Live


@pytest.fixture(scope="package")
def shared_live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """One console for all of this folder; tests take `live`, which finds it calm."""
    with Live(tmp_path_factory.mktemp("console")) as live:
        yield live


@pytest.fixture
def live(shared_live: Live) -> Live:
    shared_live.calm()
    return shared_live


@pytest.fixture(scope="module")
def rough_live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """A console that may be told anything, where the robot is, for one: nobody else's afterwards."""
    with Live(tmp_path_factory.mktemp("rough")) as live:
        yield live


@pytest.fixture(scope="module")
def open_live(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """A console that asks nobody to sign in."""
    with Live(tmp_path_factory.mktemp("open"), no_auth=True) as live:
        yield live
