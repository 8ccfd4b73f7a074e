import math

import pytest

from core.gate import GateStatus, Setpoint
from core.gate.packets import Packet
from core.gate.requests import (
    DriverReport,
    GateArm,
    GateDisarm,
    GateHalt,
    GateHeartbeat,
    GateLeave,
    GateReach,
    GateRequest,
    GateReset,
    GateStop,
    read_report,
    read_request,
)

SET: Packet = {"epoch": 1, "seq": 2, "source": "jog", "press": 3, "v": 0.1, "w": -0.5, "nonce": 4}


@pytest.mark.parametrize(
    ("packet", "request_"),
    [
        ({"kind": "set", **SET}, Setpoint(epoch=1, seq=2, source="jog", press=3, v=0.1, w=-0.5, nonce=4)),
        ({"kind": "beat"}, GateHeartbeat()),
        ({"kind": "stop"}, GateStop()),
        ({"kind": "halt", "number": 7}, GateHalt(7)),
        ({"kind": "reset"}, GateReset()),
        ({"kind": "arm", "epoch": 5, "owner": "x" * 300}, GateArm(5, "x" * 200)),
        ({"kind": "disarm"}, GateDisarm()),
        ({"kind": "leave"}, GateLeave()),
        ({"kind": "reach", "stamp": 7.5}, GateReach(7.5)),
        ({"kind": "reach", "stamp": None, "part": "ears"}, GateReach(None, "ears")),
        ({"kind": "reach", "stamp": "soon"}, GateReach(None)),
    ],
)
def test_every_packet_of_the_console_has_its_request(packet: Packet, request_: GateRequest) -> None:
    assert read_request(packet) == request_


@pytest.mark.parametrize("kind", ["stop", "halt", "disarm", "leave"])
@pytest.mark.parametrize("more", [{"number": "seven"}, {"number": -1}, {"number": True}, {"epoch": [], "": {}}])
def test_what_stops_the_robot_is_understood_whatever_else_the_packet_holds(kind: str, more: Packet) -> None:
    plain = read_request({"kind": kind})
    assert plain is not None and read_request({"kind": kind, **more}) == plain


@pytest.mark.parametrize(
    "packet",
    [
        {},
        {"kind": "fly"},
        {"kind": ["set"], **SET},
        {"kind": "set"},
        {"kind": "set", **SET, "more": 1},
        {"kind": "set", **{name: value for name, value in SET.items() if name != "nonce"}},
        {"kind": "arm", "epoch": 1},
        {"kind": "arm", "owner": "ann"},
    ],
)
def test_a_packet_of_another_form_is_no_request(packet: Packet) -> None:
    assert read_request(packet) is None


@pytest.mark.parametrize(
    ("packet", "report"),
    [
        ({"contact": True}, DriverReport(True, None, math.pi)),
        ({"contact": 1, "points": {}, "field": "wide", "age": "old"}, DriverReport(False, None, math.pi)),
        ({"points": [[1, 2]], "field": 2, "age": 0}, DriverReport(False, [[1, 2]], 2.0, age=0.0)),
        ({"points": [], "field": True}, DriverReport(False, [], math.pi)),
        ({"stamp": 7.5, "age": -60.5}, DriverReport(False, None, math.pi, 7.5, -60.5)),
    ],
)
def test_a_part_of_a_report_that_is_not_of_its_form_counts_as_left_out(packet: Packet, report: DriverReport) -> None:
    assert read_report(packet) == report


@pytest.mark.parametrize("point", [None, (1.0, -0.5)])
def test_a_status_survives_its_packet(point: tuple[float, float] | None) -> None:
    status = GateStatus(state="armed", epoch=3, owner="ann", v=0.1, limit_v=0.2, blocked_by=point, latched=4)
    assert GateStatus.of_packet(status.to_packet()) == status
