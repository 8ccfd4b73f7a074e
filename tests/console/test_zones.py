"""Zones over REST: the way leads round them, a goal in one is refused by its name, slow ones reach the gate."""

import io
import itertools
import math
import re
import zipfile
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest

from console.access.logins import Person
from console.http.problems import Problem
from console.maps.zones import ZoneService
from console.messages.inbound import JogMessage
from core.pipelines.nav2_map import read_nav2_map
from core.sentences import Statement
from tests.console.live import Live


def call(live: Live, method: str, path: str, body: Any = None, *, status: int = 200) -> Any:
    answer = live.ask(method, path, body, token=live.operator)
    assert answer.status == status, answer.body
    return answer.json if answer.body else None


def square(x: float, y: float, half: float) -> list[list[float]]:
    return [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]]


@pytest.fixture
def bare(rough_live: Live) -> Any:
    """A console without zones, before and after; no other file's tests have driven its robot up to a wall."""
    live = rough_live
    live.calm()
    live.until(lambda: not live.runtime.snapshot.slam.looking_around, 60)
    yield live
    live.calm()
    live.ask("POST", "/api/stop", token=live.operator)
    for one in call(live, "GET", "/api/zones")["zones"]:
        call(live, "DELETE", f"/api/zones/{quote(one['name'])}", status=204)


def ahead(live: Live, metres: float) -> tuple[float, float]:
    pose = live.runtime.snapshot.estimate.pose
    return pose.x + metres * math.cos(pose.heading), pose.y + metres * math.sin(pose.heading)


def test_no_command_enters_a_zone_to_keep_out_of(bare: Live) -> None:
    x, y = ahead(bare, 0.5)
    made = call(
        bare, "POST", "/api/zones", {"name": "hole", "kind": "keep_out", "points_m": square(x, y, 0.15)}, status=201
    )
    assert made["kind"] == "keep_out" and len(made["points_m"]) == 4 and made["max_speed_m_s"] is None
    inside = bare.ask("POST", "/api/commands", {"text": f"stop at {x:.2f} and {y:.2f}"}, token=bare.operator)
    assert inside.status == 409 and "“hole”" in inside.json["detail"]
    begun = call(bare, "POST", "/api/commands", {"text": "continue 1 meters"}, status=202)
    entry = bare.until(lambda: (one := bare.runtime.history.find(begun["id"])).state != "running" and one, 60)
    assert entry.state == "failed" and "“hole”" in entry.remark
    (zone,) = bare.runtime.parts[ZoneService].zones
    true = bare.ask("GET", "/api/sim/truth", token=bare.viewer).json
    assert zone.depth(true["x_m"], true["y_m"]) < 0.0


def test_a_slow_zone_caps_what_the_gate_lets_through(bare: Live) -> None:
    pose = bare.runtime.snapshot.estimate.pose
    body = {"name": "shop", "kind": "slow", "points_m": square(pose.x, pose.y, 3.0), "max_speed_m_s": 0.04}
    call(bare, "POST", "/api/zones", {**body, "max_speed_m_s": None}, status=422)
    call(bare, "POST", "/api/zones", body, status=201)
    call(bare, "POST", "/api/zones", body, status=409)
    bare.until(lambda: bare.robot.gate._cap == 0.04)
    rows = bare.robot.writer.rows
    first = len(rows)
    call(bare, "POST", "/api/commands", {"text": "continue 0.2 meters"}, status=202)
    bare.until(lambda: any(row.v > 0.03 for row in rows[first:]))
    call(bare, "POST", "/api/stop", {}, status=200)
    assert max(row.v for row in rows[first:]) <= 0.04 + 1e-9
    call(bare, "DELETE", "/api/zones/shop", status=204)
    bare.until(lambda: bare.robot.gate._cap == math.inf)
    call(bare, "DELETE", "/api/zones/shop", status=404)


def test_a_command_keeps_to_a_slow_zone_by_itself(bare: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    """The cap of the gate comes from the event loop, which may be late."""
    monkeypatch.setattr(bare.robot, "cap", lambda speed: None)
    pose = bare.runtime.snapshot.estimate.pose
    body = {"name": "shop", "kind": "slow", "points_m": square(pose.x, pose.y, 3.0), "max_speed_m_s": 0.04}
    call(bare, "POST", "/api/zones", body, status=201)
    rows = bare.robot.writer.rows
    first = len(rows)
    call(bare, "POST", "/api/commands", {"text": "continue 0.2 meters"}, status=202)
    bare.until(lambda: any(row.v > 0.03 for row in rows[first:]))
    bare.until(lambda: bare.runtime.snapshot.active_command is None, 60)
    assert max(row.v for row in rows[first:]) <= 0.04 + 1e-9
    assert bare.robot.gate._cap == math.inf


def test_a_hand_is_warned_and_enters_with_a_second_press(bare: Live) -> None:
    x, y = ahead(bare, 0.2)
    call(bare, "POST", "/api/zones", {"name": "hole", "kind": "keep_out", "points_m": square(x, y, 0.1)}, status=201)
    hand, dispatcher, numbers = Person("hand", "Hand", "operator"), bare.runtime.dispatcher, itertools.count(1)

    def jog(press: int, speed: float) -> None:
        gate = bare.robot.status()
        dispatcher.drive(
            JogMessage(v=speed, w=0.0, press=press, seq=next(numbers), nonce=gate.nonce, epoch=gate.epoch), hand
        )

    def moved(press: int) -> bool:
        bare.on_loop(lambda: jog(press, 0.1))
        return bare.runtime.snapshot.estimate.pose.distance_to(begun.x, begun.y) > 0.08

    begun = bare.runtime.snapshot.estimate.pose
    with pytest.raises(Problem, match=r"“hole”.*Press again"):
        bare.until(lambda: moved(1), 20)
    bare.on_loop(lambda: jog(1, 0.1))  # the same press again: nothing, and it is not said again
    bare.until(lambda: bare.robot.status().v == 0.0)
    bare.on_loop(lambda: jog(1, 0.0))
    bare.until(lambda: moved(2), 20)
    bare.on_loop(lambda: jog(2, 0.0))


def test_a_hand_that_is_warned_ends_the_goal_that_was_under_way(bare: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    dispatcher, ended = bare.runtime.dispatcher, list[str]()
    begun = call(bare, "POST", "/api/commands", {"text": "continue 1 meters"}, status=202)
    bare.until(lambda: bare.robot.status().v > 0.0)
    monkeypatch.setattr(dispatcher, "hand_warning", lambda _: "A zone is ahead.")
    monkeypatch.setattr(dispatcher, "when_cancelled", [lambda state, why, _: ended.append(state)])
    holder = bare.runtime.lease.holder
    assert holder is not None
    with pytest.raises(Problem, match="A zone is ahead"):
        bare.on_loop(lambda: dispatcher.drive(JogMessage(v=0.1, w=0.0, press=9, seq=1, nonce=0, epoch=0), holder))
    assert ended == ["pre-empted"]
    entry = bare.until(lambda: (one := bare.runtime.history.find(begun["id"])).state != "running" and one)
    assert entry.state == "pre-empted"
    bare.on_loop(lambda: dispatcher.forget(holder))


def zip_of(files: dict[str, bytes]) -> bytes:
    box = io.BytesIO()
    with zipfile.ZipFile(box, "w") as made:
        for name, content in files.items():
            made.writestr(name, content)
    return box.getvalue()


def send(live: Live, path: str, packed: bytes) -> Any:
    return live.ask("POST", path, raw=packed, token=live.operator, headers={"Content-Type": "application/zip"})


def members(packed: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(packed)) as box:
        return {name: box.read(name) for name in box.namelist()}


def test_zones_go_out_as_masks_of_nav2_and_come_back_with_the_same_cells(bare: Live) -> None:
    x, y = (round(value, 2) for value in ahead(bare, 1.5))
    call(bare, "POST", "/api/zones", {"name": "hole", "kind": "keep_out", "points_m": square(x, y, 0.3)}, status=201)
    slow = {"name": "shop", "kind": "slow", "points_m": square(x + 1, y, 0.4), "max_speed_m_s": 0.07}
    call(bare, "POST", "/api/zones", slow, status=201)
    out = bare.ask("GET", "/api/zones/masks", token=bare.viewer)
    first = members(out.body)
    for name in ("hole", "shop"):
        call(bare, "DELETE", f"/api/zones/{name}", status=204)
    keep = zip_of({name: one for name, one in first.items() if name.startswith("keepout")})
    told = send(bare, "/api/zones/masks?name=walls&kind=keep_out", keep)
    assert (
        told.status == 201 and [one["name"] for one in told.json["zones"]] == ["walls"] and not told.json["left_out"]
    )
    speed = zip_of({name: one for name, one in first.items() if name.startswith("speed")})
    told = send(bare, "/api/zones/masks?name=calm&kind=slow&type=2&base=0&multiplier=0.01", speed)
    assert [one["max_speed_m_s"] for one in told.json["zones"]] == [0.07]
    again = members(bare.ask("GET", "/api/zones/masks", token=bare.viewer).body)
    for name in ("keepout_mask", "speed_mask"):
        cells = [read_nav2_map(one[f"{name}.yaml"], one[f"{name}.pgm"]) for one in (first, again)]
        at = [np.argwhere(one.values > 0) * one.resolution + one.origin[1::-1] for one in cells]
        assert len(at[0]) and np.allclose(*at)
    assert send(bare, "/api/zones/masks?name=walls&kind=keep_out", keep).status == 409
    dark = members(keep)["keepout_mask.pgm"]
    grey = zip_of(members(keep) | {"keepout_mask.pgm": dark[:-9] + bytes([100] * 9)})
    assert (
        "9 cells of the mask are unknown"
        in send(bare, "/api/zones/masks?name=dark&kind=keep_out", grey).json["left_out"]
    )
    assert "zip" in send(bare, "/api/zones/masks?name=w&kind=keep_out", b"PK").json["detail"]


def test_a_mask_that_would_protect_nothing_or_nearly_all_says_so(bare: Live) -> None:
    files = members(bare.ask("GET", "/api/zones/masks", token=bare.viewer).body)
    size = files["keepout_mask.pgm"].split()[1:3]
    columns, rows = map(int, size)

    def mask(pixels: np.ndarray, origin: str = "", **extra: str) -> bytes:
        text = files["keepout_mask.yaml"].decode().replace("trinary", extra.get("mode", "trinary"))
        if origin:
            text = re.sub(r"origin: .*", f"origin: {origin}", text)
        return zip_of(
            {"m.yaml": text.encode(), "keepout_mask.pgm": b"P5\n%d %d\n255\n" % (columns, rows) + pixels.tobytes()}
        )

    def told(name: str, packed: bytes, query: str = "kind=keep_out") -> Any:
        return send(bare, f"/api/zones/masks?name={name}&{query}", packed).json

    pixels = np.full((rows, columns), 254, np.uint8)
    pixels[2:6, 2:6] = 0
    assert told("far", mask(pixels, "[9000, 0, 0]"))["detail"] == Statement("zones.mask_outside")
    pixels[-6:-2, -6:-2] = 0
    away = 0.05 * (columns // 2)
    partly = told(
        "partly", mask(pixels, f"[{away + float(files_origin(files)[0])}, {files_origin(files)[1]}, 6.283185307]")
    )
    assert "1 of 2 zones of the mask lie outside the map" in partly["left_out"]
    assert "are to be kept out of" in told("most", mask(254 - pixels))["left_out"]
    fast = mask(np.where(pixels == 0, 90, 0).astype(np.uint8), mode="raw")
    slowed = told("fast", fast, "kind=slow&type=2&base=0&multiplier=0.1")
    assert "slow nothing" in slowed["left_out"]


def files_origin(files: dict[str, bytes]) -> list[str]:
    found = re.search(rb"origin: \[(.*)\]", files["keepout_mask.yaml"])
    assert found is not None
    return found[1].decode().split(", ")


def test_a_map_of_nav2_is_kept_as_a_saved_map_to_the_bit(bare: Live) -> None:
    out = bare.ask("GET", "/api/map", token=bare.viewer).body
    told = send(bare, "/api/maps/import?name=from+nav2", out)
    assert told.status == 201 and told.json["landmarks"] == 0 and told.json["remark"] == "", told.json
    files = members(out)
    own = files["map.yaml"].replace(b"0.196", b"0.25")
    doubted = send(bare, "/api/maps/import?name=of+nav2s+own", zip_of({"m.yaml": own, "map.pgm": files["map.pgm"]}))
    assert "free_thresh is 0.25" in doubted.json["remark"], doubted.json
    call(bare, "DELETE", "/api/maps/of%20nav2s%20own", status=204)
    kept = members(bare.ask("GET", "/api/maps/from%20nav2.zip", token=bare.viewer).body)
    assert kept["map.pgm"] == members(out)["map.pgm"] and kept["map.yaml"] == members(out)["map.yaml"]
    assert send(bare, "/api/maps/import?name=from+nav2", out).status == 409
    call(bare, "DELETE", "/api/maps/from%20nav2", status=204)
    assert "YAML" in send(bare, "/api/maps/import?name=x", zip_of({"m.yaml": b"{", "m.pgm": b"P5"})).json["detail"]


RING = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]


@pytest.mark.parametrize(
    ("points", "code"),
    [
        (RING, None),
        (RING[::-1], None),
        ([*RING, RING[0]], None),  # closed, as GeoJSON writes it
        ([RING[0], *RING], None),
        ([*RING[:2], [3.0, 1.0], *RING[1:]], None),  # with a spike
        ([RING[0], RING[2], RING[1], RING[3]], "zones.crossed"),  # a bow tie
        ([[0.0, 1.0], [0.6, -0.8], [-0.95, 0.3], [0.95, 0.3], [-0.6, -0.8]], "zones.crossed"),  # a star
        ([*RING, *RING], "zones.crossed"),  # twice around: nothing is inside
        ([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], "zones.small"),
        ([[1000 * x, 1000 * y] for x, y in RING], "places.beyond"),
        ([[x - 300, y] for x, y in RING], "places.beyond"),
        ([[-60.0, -60.0], [60.0, -60.0], [0.0, 60.0]], None),  # around the whole map
    ],
)
def test_a_zone_that_nobody_can_have_meant_is_refused(
    bare: Live, points: list[list[float]], code: str | None
) -> None:
    told = call(
        bare,
        "POST",
        "/api/zones",
        {"name": "odd", "kind": "slow", "max_speed_m_s": 1.0, "points_m": points},
        status=422 if code else 201,
    )
    assert told.get("code") == code
