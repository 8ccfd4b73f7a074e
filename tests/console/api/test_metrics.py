"""Figures for a monitoring system: well-formed, true, and for nobody elsewhere who is not signed in."""

import math
import re

import pytest

from console.api.state import quoted
from tests.console.live import Live

LINE = re.compile(r'beckon_[a-z_]+(\{[a-z_]+="[^"]*"(,[a-z_]+="[^"]*")*\})? (\S+)')


def read(text: str) -> dict[str, float]:
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    assert all(LINE.fullmatch(row) for row in rows), rows
    return {row.rpartition(" ")[0]: float(row.rpartition(" ")[2]) for row in rows}


def test_figures_are_well_formed_and_those_of_the_robot(live: Live) -> None:
    live.until(lambda: live.ask("GET", "/api/health").status == 200)
    answer = live.ask("GET", "/metrics")
    assert answer.status == 200 and answer.headers["content-type"].startswith("text/plain; version=0.0.4")
    text = answer.body.decode()
    kinds = dict(re.findall(r"^# TYPE (\S+) (\S+)$", text, re.M))
    told = read(text)
    assert {name.partition("{")[0] for name in told} == set(kinds) and kinds["beckon_gate_trips_total"] == "counter"
    assert told["beckon_healthy"] == told["beckon_robot_live"] == 1.0
    assert 0 <= told["beckon_frame_age_seconds"] < 100 and told["beckon_disk_free_bytes"] > 0
    assert 1e7 < told["beckon_memory_bytes"] < 1e11
    assert any(name.startswith('beckon_sensor_age_seconds{sensor="') for name in told)
    assert all(math.isfinite(figure) for figure in told.values())


def test_who_is_elsewhere_shows_a_key(live: Live) -> None:
    for header in ("X-Forwarded-For", "X-Forwarded-Proto", "Forwarded"):
        told = {header: "https" if header.endswith("Proto") else "203.0.113.9"}
        assert live.ask("GET", "/metrics", headers=told).status == 401
        assert live.ask("GET", "/metrics", headers=told, token=live.viewer).status == 200


@pytest.mark.parametrize(("value", "told"), [('a"b', 'a\\"b'), ("a\\b", "a\\\\b"), ("a\nb", "a\\nb")])
def test_a_label_cannot_end_its_quotes(value: str, told: str) -> None:
    assert quoted(value) == told
