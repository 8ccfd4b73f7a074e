"""A map that was saved by one console is gone on in by the next, and by another robot of the site."""

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from console.api.maps import zip_of
from console.maps.service import MapService
from core.files import sealed
from tests.console.live import Live, Reply

LONG = 60.0  # [s]; the machine may be busy


def post(live: Live, path: str, body: Any) -> int:
    return live.ask("POST", path, body, token=live.operator).status


SQUARE = [[1.0, 1.0], [1.4, 1.0], [1.4, 1.4], [1.0, 1.4]]
MARKS = {
    "/api/places": {"name": "dock", "x_m": 0.2, "y_m": 0.0, "heading_rad": None},
    "/api/zones": {"name": "hole", "kind": "keep_out", "points_m": SQUARE},
    "/api/routes": {"name": "round", "stops": [{"place": "dock"}], "loop": False},
}


def maps_of(live: Live) -> MapService:
    return live.runtime.parts[MapService]


def take(live: Live, name: str, packed: bytes) -> Reply:
    kind = {"Content-Type": "application/zip"}
    return live.ask("POST", f"/api/maps/import?name={name}", raw=packed, token=live.operator, headers=kind)


def changed(packed: bytes, change: Callable[[dict[str, bytes]], None]) -> bytes:
    """The same zip, but for this."""
    with zipfile.ZipFile(io.BytesIO(packed)) as box:
        files = {name: box.read(name) for name in box.namelist()}
    change(files)
    return zip_of(files)


def of_card(**values: Any) -> Callable[[dict[str, bytes]], None]:
    """Another card, which is as whole as the first."""

    def change(files: dict[str, bytes]) -> None:
        card = json.loads(files["card.json"])
        files["card.json"] = json.dumps(sealed({**card, **values})).encode()

    return change


def with_place(name: str) -> Callable[[dict[str, bytes]], None]:
    """One place more, named by the other robot since."""

    def change(files: dict[str, bytes]) -> None:
        marks = json.loads(files["marks.json"])
        marks["places"].append({**marks["places"][0], "name": name})
        files["marks.json"] = json.dumps(sealed(marks)).encode()

    return change


def check_taking(live: Live, packed: bytes) -> None:
    """A map of another robot is taken where it fits; else there is a sentence, and nothing is kept."""
    rows: list[tuple[Callable[[dict[str, bytes]], Any], int, str]] = [
        (of_card(laser_height_m=0.42), 409, "42 cm above the floor; the laser of this robot"),
        (of_card(resolution_m=0.1), 409, "cells of 10 cm"),
        (lambda files: files.update({"map.pgm": b"P5"}), 422, "damaged, or was changed"),
        (lambda files: files.pop("floor/map.npz"), 422, "damaged, or was changed"),
        (lambda files: files.update({"../evil.py": b""}), 422, "damaged, or was changed"),
        (lambda files: files.update({"card.json": b"{}"}), 422, "damaged, or was changed"),
        (lambda files: files.update({"marks.json": b"{}"}), 422, "places of this map are damaged"),
    ]
    for change, status, says in rows:
        answer = take(live, "taken", changed(packed, change))
        assert answer.status == status and says in answer.json["detail"], answer.json
    assert take(live, "lab", packed).status == 409
    taken = take(live, "taken", changed(packed, of_card(robot="another")))
    assert taken.status == 201 and taken.json["robot"] == live.robot.profile.name
    again = live.ask("GET", "/api/maps/taken.zip", token=live.viewer).body
    with zipfile.ZipFile(io.BytesIO(packed)) as one, zipfile.ZipFile(io.BytesIO(again)) as other:
        assert one.namelist() == other.namelist()
        assert all(one.read(name) == other.read(name) for name in one.namelist() if name != "card.json")


def test_a_saved_map_survives_the_console_and_is_gone_on_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Live(tmp_path) as before:
        before.until(lambda: len(before.runtime.snapshot.landmarks) > 2, LONG)
        assert post(before, "/api/maps", {"name": "lab"}) == 201
        assert [post(before, path, body) for path, body in MARKS.items()] == [201, 201, 201]
        packed, frame = before.ask("GET", "/api/maps/lab.zip", token=before.viewer).body, maps_of(before).frame
    with Live(tmp_path) as after:
        told = after.ask("GET", "/api/maps", token=after.viewer).json
        assert told["current"] is None and [row["name"] for row in told["maps"]] == ["lab"]
        check_taking(after, packed)
        assert maps_of(after).frame == ""
        assert post(after, "/api/maps/taken/load", {}) == 202
        after.until(lambda: after.runtime.state().floor.lost, LONG)  # it stands and looks for its place
        assert after.runtime.state().map.name == "taken" and maps_of(after).frame == frame != ""
        for path, body in MARKS.items():
            (one,) = after.ask("GET", path, token=after.viewer).json[path.rpartition("/")[2]]
            assert one["name"] == body["name"]
        assert post(after, "/api/places", {"name": "window", "x_m": 0.4, "y_m": 0.0}) == 201
        with monkeypatch.context() as patch:
            patch.setattr(after.runtime, "_on_snapshot", lambda *_: None)
            assert take(after, "taken&replace=true", changed(packed, with_place("desk"))).status == 201
            known = after.ask("GET", "/api/places", token=after.viewer).json["places"]
            assert {one["name"] for one in known} == {"dock", "desk", "window"}, "new ones are known before a frame"
        assert post(after, "/api/slam/here", {"x_m": 0.05, "y_m": -0.05, "heading_rad": 0.05}) == 202
        after.until(lambda: after.runtime.state().floor.lost is None, LONG)
        after.until(lambda: len(after.runtime.snapshot.landmarks) > 2, LONG)
        assert after.runtime.snapshot.estimate.pose.distance_to(0, 0) < 0.1
        assert after.runtime.pilots.failure == ""
