"""Presence and order of the robots of a fleet, on a clock that is passed in."""

from dataclasses import replace

import msgspec
import pytest

from console.fleet.bus import CommandReport, NoticeReport, RobotReport
from console.fleet.table import LOW_BATTERY, RETURN_TIME_S, STALE_AGE_S, FleetTable, Presence

IDLE = RobotReport(address="http://127.0.0.1:1/", robot="r", simulated=True, robot_link="live", robot_age_s=0.1)
BUSY = msgspec.structs.replace(IDLE, command=CommandReport("turn_left", "turn left", "Ann"))


def table_of(**reports: RobotReport | None) -> FleetTable:
    table = FleetTable()
    table.know(reports, 0.0)
    for name, report in reports.items():
        if report is not None:
            table.came(name, 100.0)
            table.hear(name, report, 100.0)
    return table


@pytest.mark.parametrize(
    ("happens", "then", "link"),
    [
        ("reports", 100.2, "live"),
        ("frozen: no report", 100.0 + STALE_AGE_S + 0.1, "stale"),
        ("killed: its token goes", 100.01, "gone"),
        ("router anew", 100.1, "stale"),
        ("router anew", 100.0 + RETURN_TIME_S + 0.1, "gone"),
        ("router anew and back", 100.4, "live"),
    ],
)
def test_a_robot_is_live_stale_or_gone_and_stays_in_the_table(happens: str, then: float, link: Presence) -> None:
    table = table_of(r1=IDLE)
    if happens.startswith("killed"):
        table.went("r1", 100.01)
    elif happens.startswith("router"):
        table.restarted(100.0)
        if happens.endswith("back"):
            table.came("r1", 100.3)
            table.hear("r1", IDLE, 100.3)
    table.tick(then)
    assert table.robots["r1"].link == link


def test_who_needs_help_stands_first_then_who_works_then_who_idles_and_last_who_was_never_there() -> None:
    table = table_of(
        never=None,
        idle=IDLE,
        works=BUSY,
        empty=msgspec.structs.replace(IDLE, battery=LOW_BATTERY - 0.01),
        halted=msgspec.structs.replace(IDLE, gate="halted"),
        lost=msgspec.structs.replace(IDLE, lost=True),
        faulty=msgspec.structs.replace(IDLE, notice=NoticeReport("error", "No frames.")),
        cut=msgspec.structs.replace(IDLE, robot_link="lost"),
        dead=IDLE,
        silent=IDLE,
    )
    table.went("dead", 100.0)
    table.robots["silent"].unanswered = True
    assert [robot.name for robot in table.sorted()] == (
        ["silent", "dead", "cut", "lost", "halted", "faulty", "empty", "works", "idle", "never"]
    )
    assert [robot.need for robot in table.sorted()][-3:] == ["", "", ""]


def test_a_name_without_a_certificate_is_nobody_and_a_known_one_keeps_what_it_said() -> None:
    table = table_of(r1=IDLE)
    table.hear("stranger", IDLE, 100.0)
    table.came("stranger", 100.0)
    before = replace(table.robots["r1"])
    table.know(["r1", "r2"], 101.0)
    assert set(table.robots) == {"r1", "r2"} and table.robots["r1"] == before
