"""Named places over REST: made, moved, renamed, gone to; they lie with their map and survive the console."""

import json
import math
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from console.api.places import NamePlaceRequest
from console.api.places import row_of as place_row
from console.api.routes import RouteRequest
from console.api.zones import ZoneRequest
from console.api.zones import row_of as zone_row
from console.maps.marks import (
    MARKS,
    Anchor,
    MapMarks,
    PlaceMark,
    RouteMark,
    RouteStop,
    anchor_at,
    read_marks,
    write_marks,
)
from console.maps.places import PlaceService
from console.maps.service import MapService
from core.errors import BadInput
from core.geometry import Pose
from core.navigation.places import NamedPlace
from core.navigation.zones import MapZone
from core.slam.map.status import SubmapView
from tests.console.live import Live


def call(live: Live, method: str, path: str, body: Any = None, *, status: int = 200) -> Any:
    answer = live.ask(method, path, body, token=live.operator)
    assert answer.status == status, answer.body
    return answer.json if answer.body else None


def test_a_place_is_named_moved_gone_to_and_kept_with_its_map(live: Live) -> None:
    live.until(lambda: not live.runtime.snapshot.slam.looking_around)
    here = live.runtime.snapshot.estimate.pose
    made = call(live, "POST", "/api/places", {"name": " the  Window "}, status=201)
    assert made["name"] == "Window" and math.hypot(made["x_m"] - here.x, made["y_m"] - here.y) < 0.05
    call(live, "POST", "/api/places", {"name": "desk", "x_m": 0.4, "y_m": 0.1, "heading_rad": 1.5}, status=201)
    live.until(lambda: live.ask("GET", "/api/state", token=live.viewer).json["map"]["marks"] > 1)

    far = call(live, "POST", "/api/places", {"name": "moon", "x_m": 400.0, "y_m": 0.1}, status=422)
    assert "outside the map" in far["detail"]
    for method, path, half in (
        ("POST", "/api/places", {"name": "shelf", "x_m": 0.3}),
        ("POST", "/api/places", {"name": "shelf", "y_m": 0.3, "x_m": None}),
        ("PATCH", "/api/places/desk", {"y_m": 0.3}),
    ):
        wrong = call(live, method, path, half, status=422)
        assert "both x_m and y_m" in wrong["detail"] and wrong["code"] == "places.half"
    alike = call(live, "POST", "/api/places", {"name": "windows", "x_m": 0.1, "y_m": 0.1}, status=422)
    assert "“windows” and “Window” sound too much alike" in alike["detail"]
    call(live, "POST", "/api/places", {"name": "WINDOW", "x_m": 0.1, "y_m": 0.1}, status=409)

    moved = call(live, "PATCH", "/api/places/desk", {"name": "table", "heading_rad": None})
    wall = moved.pop("wall_m")
    assert moved == {"name": "table", "x_m": 0.4, "y_m": 0.1, "heading_rad": None, "outline_m": []}
    assert wall is None
    grid = live.runtime.parts[MapService].grid
    row, column = np.argwhere(grid.log_odds > 1.0)[0]
    x, y = (grid.origin + grid.resolution * (np.array([column, row]) + 0.5)).tolist()
    inside = call(live, "PATCH", "/api/places/table", {"x_m": x, "y_m": y})
    assert inside["wall_m"] < grid.resolution
    call(live, "PATCH", "/api/places/table", {"x_m": 0.4, "y_m": 0.1})
    call(live, "PATCH", "/api/places/desk", {"name": "chair"}, status=404)

    begun = live.ask("POST", "/api/commands", {"text": "Go to the table."}, token=live.operator)
    assert begun.status == 202, begun.body
    assert begun.json["heard_as"] == "go to table" and begun.json["command"]["x_m"] == pytest.approx(0.4)
    live.until(lambda: live.runtime.history.find(begun.json["id"]).state == "done", 60)
    pose = live.ask("GET", "/api/sim/truth", token=live.operator).json
    assert math.hypot(pose["x_m"] - 0.4, pose["y_m"] - 0.1) < 0.1
    refused = live.ask("POST", "/api/commands", {"text": "go to the desk"}, token=live.operator)
    assert refused.status == 422 and "no place of that name" in refused.json["detail"]

    call(live, "POST", "/api/maps", {"name": "lab"}, status=201)
    call(live, "POST", "/api/places", {"name": "piano", "x_m": 0.2, "y_m": 0.2}, status=201)  # goes to the saved map
    call(live, "DELETE", "/api/places/window", status=204)
    (folder,) = live.home.glob("maps/lab-*")
    assert [one.name for one in read_marks(folder).places] == ["table", "piano"]
    assert call(live, "DELETE", "/api/places/window", status=404)
    call(live, "POST", "/api/maps/lab/load", {}, status=202)
    assert [one["name"] for one in call(live, "GET", "/api/places")["places"]] == ["table", "piano"]
    assert [one.place.name for one in live.runtime.dispatcher.phrases[::4]] == ["table", "piano"]
    assert [one.name for one in live.runtime.parts[PlaceService].places] == ["table", "piano"]
    damaged = folder / MARKS
    damaged.write_text(damaged.read_text().replace("piano", "pianx"))
    assert "damaged" in call(live, "POST", "/api/maps/lab/load", {}, status=422)["detail"]


def test_a_row_of_one_robot_is_what_another_takes() -> None:
    """A fleet gives the marks of one robot to another; it leaves `wall_m` out."""
    place = NamedPlace(name="desk", x_m=0.4, y_m=0.1, heading_rad=1.5, outline_m=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0)))
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    zone = MapZone(name="stairs", kind="slow", points=corners, max_speed=0.1)
    route = RouteMark("round", (RouteStop("desk", 2.0, "say", "Hello"),), True, "08:30", "17:00", 5.0)
    rows = ((NamePlaceRequest, place_row(place)), (ZoneRequest, zone_row(zone)), (RouteRequest, route))
    for asked, row in rows:
        fields = msgspec.json.decode(msgspec.json.encode(row))
        fields.pop("wall_m", None)
        assert asked.model_validate(fields).model_dump(mode="json").items() >= fields.items()


def test_marks_are_read_as_they_were_written_and_not_when_they_were_changed(tmp_path: Path) -> None:
    anchor = Anchor(3, 1.0, 2.0, 0.5)
    marks = MapMarks((PlaceMark("kitchen", 1.5, -2.0, 0.25, anchor, "Ada"), PlaceMark("lab", 0.0, 0.0)))
    assert read_marks(tmp_path) == MapMarks()
    write_marks(tmp_path, marks)
    assert read_marks(tmp_path) == marks
    document = json.loads((tmp_path / MARKS).read_text())
    for broken in ("", "{", "[]", "null", json.dumps({**document, "places": []}), json.dumps({"version": 1})):
        (tmp_path / MARKS).write_text(broken)
        with pytest.raises(BadInput, match="damaged"):
            read_marks(tmp_path)


def test_a_place_moves_with_the_submap_that_it_was_made_in() -> None:
    extent = np.array([[-1.0, -1.0], [1.0, 1.0]])
    before = (
        SubmapView(id=0, pose=Pose(), extent=extent, active=True),
        SubmapView(id=1, pose=Pose(4.0, 0.0, 0.2), extent=extent, active=False),
    )
    anchor = anchor_at(np.array([[3.8, 0.5]]), before)
    assert anchor is not None and anchor.submap == 1
    mark = PlaceMark("kitchen", 3.8, 0.5, 0.7, anchor)
    bent = Pose(4.3, 0.4, 0.5)
    after = (before[0], SubmapView(id=1, pose=bent, extent=extent, active=True))
    then, now = Pose(4.0, 0.0, 0.2).inverse() @ Pose(3.8, 0.5, 0.7), mark.now(after)
    kept = bent.inverse() @ Pose(now.x_m, now.y_m, now.heading_rad or 0.0)
    assert (kept.x, kept.y, kept.heading) == pytest.approx((then.x, then.y, then.heading))
    still = mark.now(before)
    assert (still.x_m, still.y_m, still.heading_rad) == pytest.approx((3.8, 0.5, 0.7))
    assert mark.now(()).x_m == 3.8  # the submap is gone: it stays where it was
    assert anchor_at(np.array([[0.0, 0.0]]), ()) is None
