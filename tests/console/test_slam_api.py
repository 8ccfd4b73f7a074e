"""The map's part of the HTTP interface: closures, "I am here", saved maps, and what can be taken along."""

import io
import json
import re
import time
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from console.api.reports import lasting
from console.maps.service import MapService
from console.messages.map import MAX_CLOSURES
from core.geometry import Pose
from core.pilot import Pilot
from core.sensors import SensorFrame
from core.slam.consistency import faded_band
from core.slam.map.status import ClosureStatus, LostStatus, MapStatus, SubmapView
from core.snapshot import Snapshot
from tests.console.live import Live, hear
from tests.core.pipelines.test_nav2_map import load_as_nav2

LOST = LostStatus(
    phase="asking", words="I am lost. Show me where I am.", since=1.0, candidates=np.array([[1.0, 2.0, 0.5]])
)


def closure(number: int, state: Any = "accepted") -> ClosureStatus:
    here, there = np.array([1.0, 2.0]), np.array([0.5, 0.25])
    return ClosureStatus(
        id=number,
        stamp=3.0,
        submap_from=2,
        submap_to=0,
        position_from=here,
        position_to=there,
        score=0.91,
        state=state,
    )


ROOM = SubmapView(id=0, pose=Pose(0.1, 0.2, 0.3), extent=np.array([[-1.0, -2.0], [3.0, 4.0]]), active=True)
FLOOR = MapStatus(submaps=(ROOM,), closures=(closure(1), closure(2, "undone")), match_score=0.87, graph_revision=4)


class Led(Pilot):
    """A pilot that tells the floor that the test gives it, and writes down what it is asked; all else is real."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.floor = FLOOR
        self.asked: list[tuple[Any, ...]] = []

    def step(self, frame: SensorFrame, **how: Any) -> Snapshot:
        return replace(super().step(frame, **how), floor=self.floor)

    def believe_closure(self, number: int, believed: bool) -> None:
        self.asked.append(("redo" if believed else "undo", number))

    def place_at(self, x: float, y: float, heading: float | None) -> None:
        self.asked.append(("here", x, y, heading))


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    live = Live(tmp_path_factory.mktemp("maps"))
    live.runtime._make_pilot = lambda: Led(live.robot.profile)
    with live:
        live.until(lambda: (live.runtime.snapshot.grid.log_odds < -1).any())  # seen free more than once
        yield live


@pytest.fixture
def live(opened: Live) -> Live:
    opened.calm()
    led(opened).floor = FLOOR
    led(opened).asked.clear()
    settled(opened, FLOOR)
    return opened


def led(live: Live) -> Led:
    pilot = live.runtime.dispatcher.pilot
    assert isinstance(pilot, Led)
    return pilot


def settled(live: Live, floor: MapStatus) -> None:
    led(live).floor = floor
    live.until(lambda: live.runtime.snapshot.floor is floor)


def post(live: Live, path: str, body: Any = None, *, token: str | None = None) -> Any:
    return live.ask("POST", path, body if body is not None else {}, token=token or live.operator)


def sentence(answer: Any, status: int) -> str:
    assert answer.status == status, answer.body
    assert answer.headers["content-type"] == "application/problem+json"
    return answer.json["detail"]


def test_the_state_tells_rooms_closures_and_how_true_it_all_is(live: Live) -> None:
    with live.open() as page:
        told = hear(page, "state")
    floor, slam = told["floor"], told["slam"]
    assert floor["submaps"] == [
        {"id": 0, "x_m": 0.1, "y_m": 0.2, "heading_rad": 0.3, "extent_m": [-1.0, -2.0, 3.0, 4.0], "active": True}
    ]
    first = floor["closures"][0]
    assert (first["id"], first["position_from"], first["score"]) == (1, {"x_m": 1.0, "y_m": 2.0}, 0.91)
    assert floor["lost"] is None and floor["match_score"] == 0.87 and floor["closures_count"] == 2
    assert 0 <= slam["error_m"] < 0.1 and slam["nis_band"] == pytest.approx(faded_band(0.98))
    counted = {name: told["map"][name] for name in ("revision", "marks")}
    assert told["map"] == {"name": None, "unsaved": False, **counted}


def test_many_closures_do_not_make_every_state_long(live: Live) -> None:
    settled(live, replace(FLOOR, closures=tuple(closure(number) for number in range(500))))
    floor = live.ask("GET", "/api/state", token=live.viewer).json["floor"]
    assert len(floor["closures"]) == MAX_CLOSURES and floor["closures_count"] == 500
    assert floor["closures"][-1]["id"] == 499
    assert len(live.ask("GET", "/api/slam/closures", token=live.viewer).json["closures"]) == 500


def test_a_closure_is_undone_and_redone_by_an_operator(live: Live) -> None:
    assert post(live, "/api/slam/closures/1/undo").status == 202
    assert post(live, "/api/slam/closures/2/redo").status == 202
    assert led(live).asked == [("undo", 1), ("redo", 2)]
    entries = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
    assert [entry["words"] for entry in entries[:2]] == ["redo 2", "undo 1"] and entries[0]["who"] == "operator"


def test_what_is_wrong_with_a_closure_is_told(live: Live) -> None:
    assert "no such closure" in sentence(post(live, "/api/slam/closures/77/undo"), 404)
    assert "undone already" in sentence(post(live, "/api/slam/closures/2/undo"), 409)
    assert "not undone" in sentence(post(live, "/api/slam/closures/1/redo"), 409)
    assert sentence(post(live, "/api/slam/closures/1/undo", token=live.viewer), 403)
    assert led(live).asked == []


def test_a_lost_robot_is_told_where_it_is(live: Live) -> None:
    assert "not lost" in sentence(post(live, "/api/slam/here", {"x_m": 1.0, "y_m": 2.0}), 409)
    settled(live, replace(FLOOR, lost=LOST))
    told = live.ask("GET", "/api/state", token=live.viewer).json["floor"]["lost"]
    assert told["words"] == LOST.words and told["candidates"] == [{"x_m": 1.0, "y_m": 2.0, "heading_rad": 0.5}]
    assert post(live, "/api/slam/here", {"x_m": 1.0, "y_m": 2.0}).status == 202
    assert post(live, "/api/slam/here", {"x_m": 1.0, "y_m": 2.0, "heading_rad": -1.5}).status == 202
    assert led(live).asked == [("here", 1.0, 2.0, None), ("here", 1.0, 2.0, -1.5)]


def test_who_insists_may_place_a_robot_that_does_not_think_it_is_lost(live: Live) -> None:
    assert post(live, "/api/slam/here", {"x_m": 1.0, "y_m": 2.0, "force": True}).status == 202
    assert led(live).asked == [("here", 1.0, 2.0, None)]


def test_nobody_moves_the_ground_under_someone_who_drives(live: Live) -> None:
    other = live.runtime.access.logins.issue("Bob", "operator")
    assert post(live, "/api/lease", {"do": "acquire"}, token=other).status == 200
    told = {"x_m": 0, "y_m": 0, "force": True}
    for path, body in (("here", told), ("closures/1/undo", None), ("closures/2/redo", None)):
        assert "Bob drives now" in sentence(post(live, f"/api/slam/{path}", body), 409)
    assert led(live).asked == []


def test_the_scan_is_seen_from_the_robot(live: Live) -> None:
    points = np.array(live.ask("GET", "/api/scan", token=live.viewer).json["points_m"])
    assert len(points) > 100 and np.hypot(*points.T).min() > 0.2 and np.hypot(*points.T).max() < 6


def test_the_map_loads_as_navs_map_server_would_load_it(live: Live) -> None:
    answer = live.ask("GET", "/api/map", token=live.viewer)
    with zipfile.ZipFile(io.BytesIO(answer.body)) as box:
        settings, cells = load_as_nav2(box.read("map.yaml").decode(), box.read("map.pgm"))
    assert settings["free_thresh"] == 0.196 and settings["mode"] == "trinary"
    assert {-1, 0, 100} == set(np.unique(cells))
    log_odds = live.runtime.snapshot.grid.log_odds
    unknown = np.argwhere(log_odds == 0)
    assert (cells[tuple(unknown.T)] == -1).mean() > 0.99  # the map grows while it is read


def test_the_map_is_had_as_picture_polygons_and_plan(live: Live) -> None:
    answer = live.ask("GET", "/api/map.png", token=live.viewer)
    assert answer.body.startswith(b"\x89PNG")
    cells = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_UNCHANGED)
    assert all((edge != 205).any() for edge in (cells[0], cells[-1], cells[:, 0], cells[:, -1]))  # nothing around it
    x, y = (float(part) for part in answer.headers["map-origin-m"].split(","))
    assert x < 0 and y < 0 and float(answer.headers["map-resolution-m"]) == 0.05  # the robot woke at (0, 0)
    told = live.ask("GET", "/api/map/outline", token=live.viewer).json
    rings = [np.reshape(ring, (-1, 2)) for ring in told["walls_cm"]]
    assert rings and all(len(ring) > 2 for ring in rings)
    reach = np.concatenate(rings)
    assert (reach.min(axis=0) < 0).all() and (reach.max(axis=0) > 0).all()
    plan, drawing = (live.ask("GET", f"/api/map.{kind}", token=live.viewer) for kind in ("pdf", "svg"))
    assert plan.body.startswith(b"%PDF-1.4") and plan.body.endswith(b"%%EOF\n")
    assert drawing.body.startswith(b"<svg ") and b"evenodd" in drawing.body


def test_landmarks_and_trajectory_go_along(live: Live) -> None:
    live.until(
        lambda: len(live.runtime.snapshot.landmarks) > 2 and len(live.runtime.parts[MapService].trajectory) > 3
    )
    lines = live.ask("GET", "/api/landmarks.csv", token=live.viewer).body.decode().splitlines()
    assert lines[0].startswith("id,x_m,y_m,var_x_m2") and len(lines) > 3
    rows = [
        line.split() for line in live.ask("GET", "/api/trajectory.tum", token=live.viewer).body.decode().splitlines()
    ]
    assert all(len(row) == 8 for row in rows)
    stamps = np.array([float(row[0]) for row in rows])
    assert (np.diff(stamps) > 0.09).all()
    assert np.hypot(*np.array([[float(row[6]), float(row[7])] for row in rows]).T) == pytest.approx(1.0)


# saved maps


@pytest.fixture
def lab(live: Live) -> Iterator[Live]:
    """With a saved map "lab"."""
    answer = post(live, "/api/maps", {"name": "lab", "replace": True})
    assert answer.status == 201, answer.body
    yield live
    live.ask("DELETE", "/api/maps/lab", token=live.operator)


def test_a_map_is_saved_listed_and_packed_with_all_that_belongs_to_it(lab: Live) -> None:
    told = lab.ask("GET", "/api/maps", token=lab.viewer).json
    [row] = told["maps"]
    assert told["current"] == "lab" == row["name"] and row["by"] == "operator"
    assert row["submaps"] == 1 and row["closures"] == 1 and row["width_m"] > 1
    packed = lab.ask("GET", "/api/maps/lab.zip", token=lab.viewer)
    assert int(packed.headers["content-length"]) == len(packed.body)
    with zipfile.ZipFile(io.BytesIO(packed.body)) as box:
        names = set(box.namelist())
        settings, cells = load_as_nav2(box.read("map.yaml").decode(), box.read("map.pgm"))
    assert {"card.json", "landmarks.csv", "trajectory.tum", "preview.png", "floor/map.npz"} <= names
    assert settings["free_thresh"] == 0.196 and (cells == -1).any() and (cells == 0).any()
    assert lab.ask("GET", "/api/maps/lab.png", token=lab.viewer).body.startswith(b"\x89PNG")


def test_what_is_wrong_with_a_saved_map_is_told(lab: Live) -> None:
    assert "“lab” already" in sentence(post(lab, "/api/maps", {"name": "LAB"}), 409)
    assert "1 to 40" in sentence(post(lab, "/api/maps", {"name": "../lab"}), 422)
    for path in ("/api/maps/hall.zip", "/api/maps/hall.png"):
        assert "no saved map" in sentence(lab.ask("GET", path, token=lab.viewer), 404)
    assert "no saved map" in sentence(post(lab, "/api/maps/hall/load"), 404)
    assert "no saved map" in sentence(lab.ask("DELETE", "/api/maps/hall", token=lab.operator), 404)
    for method, path in (("POST", "/api/maps"), ("POST", "/api/maps/lab/load"), ("DELETE", "/api/maps/lab")):
        assert sentence(lab.ask(method, path, {"name": "x"}, token=lab.viewer), 403)


@pytest.mark.parametrize(
    ("key", "value", "words"), [("robot", "Elsie", "made by “Elsie”"), ("resolution_m", 0.1, "10 cm")]
)
def test_a_map_of_another_robot_or_resolution_is_refused(lab: Live, key: str, value: Any, words: str) -> None:
    [card] = (lab.runtime.parts[MapService]._store._base).glob("lab-*/card.json")
    told = json.loads(card.read_text())
    card.write_text(json.dumps({**told, key: value}))
    assert words in sentence(post(lab, "/api/maps/lab/load"), 409)


def test_a_damaged_map_is_refused_and_the_robot_goes_on_as_it_was(lab: Live) -> None:
    [arrays] = (lab.runtime.parts[MapService]._store._base).glob("lab-*/floor/map.npz")
    arrays.write_bytes(arrays.read_bytes()[:200])
    assert "damaged" in sentence(post(lab, "/api/maps/lab/load"), 422)
    assert lab.runtime.snapshot is not None and lab.runtime.pilots.failure == ""


def test_the_report_of_a_drive_lists_the_commands_of_this_drive_alone(
    live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    def report() -> str:
        return live.ask("GET", "/api/reports/drive", token=live.viewer).body.decode()

    trajectory = live.runtime.parts[MapService].trajectory
    live.until(lambda: len(trajectory) > 0)
    live.ask("POST", "/api/commands", {"text": "fly to the old moon"}, token=live.operator)
    assert "old moon" in report()
    time.sleep(0.01)
    trajectory.forget()  # as a restart, or another map, does
    live.until(lambda: len(trajectory) > 0)
    live.ask("POST", "/api/commands", {"text": "fly to the new moon"}, token=live.operator)
    assert "new moon" in report() and "old moon" not in report()
    assert "<td>1</td>" in report()
    day = time.strftime("%Y-%m-%d")
    assert f"<title>Drive: {live.robot.profile.name} · {day}</title>" in report(), "a map without a name has none"
    assert report().count(day) == 3 and re.search(r"<td>\d\d:\d\d:\d\d</td><td>fly to the new moon", report())
    live.ask("POST", "/api/commands", {"text": "fly to -1.5"}, token=live.operator)
    assert "<td>fly to −1.5</td>" in report()
    assert [lasting(seconds) for seconds in (41.6, 575.2, 7531.0)] == ["42 s", "9 min 35 s", "2 h 5 min"]
    german = live.ask("GET", "/api/reports/drive?language=de", token=live.viewer).body.decode()
    assert '<html lang="de">' in german and "<title>Fahrt: simulierter Roboter (lab) · " in german
    assert "<td>abgelehnt</td><td>Einen solchen Befehl kenne ich nicht." in german
    plan = live.ask("GET", "/api/map.svg?language=de", token=live.viewer).body.decode()
    assert "<title>simulierter Roboter (lab) · " in plan
    assert live.ask("GET", "/api/reports/map?language=xx", token=live.viewer).status == 422
    monkeypatch.setattr("console.api.reports.MAX_LISTED", 1)
    assert "<td>the newest 1</td>" in report()
