"""viser inside the console: mounted without a socket, filtered by role, and deaf to all but looking and pointing."""

import gzip
import math
import re
import threading
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import psutil
import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection

from console.access.logins import Person
from console.scene import OVERLAYS
from console.scene.drawing.lines import ellipses, joined
from console.scene.drawing.shapes import rounded_disc, turned
from console.scene.overlays.occupancy import paint
from console.scene.viser_host import mount
from console.scene.viser_host.bridge import MOST_PER_SECOND
from console.scene.viser_host.connection import MAX_WAITING_MESSAGES, Connection, allowed
from console.scene.viser_host.mount import SUBPROTOCOL, close_viser, open_viser
from core.geometry import floor_point
from core.slam.map.occupancy import OccupancyGrid
from tests.console.live import Live, hear

OPERATOR, VIEWER = Person("o", "Olga", "operator"), Person("v", "Viktor", "viewer")

LOOK = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0, 0, 5],
    "fov": 0.8,
    "near": 0.01,
    "far": 100,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}
POINT = {
    "type": "ScenePointerMessage",
    "event_type": "click",
    "ray_origin": [0.0, 0.0, 5.0],
    "ray_direction": [0.1, 0.05, -1.0],
    "screen_pos": [[0.5, 0.5]],
    "modifier": None,
}


def packed(message: Any) -> bytes:
    return msgspec.msgpack.encode(message)


def enter(live: Live, tab: str = "tab", token: str | None = None) -> ClientConnection:
    return live.open(f"/scene/ws/{tab}", token=token, subprotocols=[SUBPROTOCOL])


def test_a_browser_gets_its_first_frame_and_then_more(live: Live) -> None:
    with enter(live) as line:
        first = line.recv(timeout=5)
        assert isinstance(first, bytes) and len(first) > 100
        length, squeezed = (int.from_bytes(first[at : at + 8], "little") for at in (0, 8))
        assert length > 0 and 0 < squeezed < len(first)
        line.send(packed(LOOK))
        for _ in range(5):
            assert len(line.recv(timeout=5)) > 16


def test_no_port_is_opened_for_it(live: Live) -> None:
    ports = {line.laddr.port for line in psutil.Process().net_connections("tcp") if line.status == "LISTEN"}
    assert ports and not any(8080 <= port < 8100 for port in ports)
    assert live.runtime.scene._server.get_port() == 0


def test_a_page_of_another_version_is_sent_away_before_any_data(live: Live) -> None:
    with live.open("/scene/ws/old", subprotocols=["viser-v0.0.1"]) as line, pytest.raises(ConnectionClosed):
        line.recv(timeout=5)


def test_without_a_login_there_is_no_scene(live: Live) -> None:
    with pytest.raises(InvalidStatus) as refused:
        live.open("/scene/ws/tab", token="wrong", subprotocols=[SUBPROTOCOL])
    assert refused.value.response.status_code == 401


def test_a_click_on_the_floor_becomes_an_order_of_the_person_at_that_tab(live: Live) -> None:
    live.until(lambda: not live.runtime.snapshot.slam.looking_around)
    with live.open() as page:
        tab = hear(page, "hello")["tab"]
        with enter(live, tab) as line:
            line.send(packed(LOOK))
            live.until(lambda: live.runtime.scene._server.get_clients())
            line.send(packed(POINT))
            answer = hear(page, "answer")
            assert answer["ok"] and answer["detail"] == "stop at 0.5 and 0.25"
            row = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"][0]
            assert row["source"] == "click" and row["who"] == "operator"
            assert live.ask("POST", "/api/stop", token=live.viewer).status == 200


def clicks(live: Live) -> int:
    return sum(entry.source == "click" for entry in live.runtime.history.newest_first(commands_only=True))


def test_a_viewers_click_is_dropped_at_the_door(live: Live) -> None:
    with enter(live, token=live.viewer) as line:
        line.send(packed(LOOK))
        live.until(lambda: live.runtime.scene._server.get_clients())
        before = clicks(live)
        line.send(packed(POINT))
        line.send(packed({**LOOK, "position": [1, 0, 5]}))
        live.until(lambda: any(c.camera.position[0] == 1 for c in live.runtime.scene._server.get_clients().values()))
        assert clicks(live) == before


@pytest.mark.parametrize("person", [VIEWER, OPERATOR], ids=lambda person: person.role)
def test_looking_is_for_all_pointing_for_operators_and_nothing_else_for_anybody(person: Person) -> None:
    assert allowed(packed(LOOK), person)
    assert allowed(packed(POINT), person) is (person is OPERATOR)
    for name in (
        "ShareUrlRequest",
        "ShareUrlDisconnect",
        "GuiUpdateMessage",
        "FileTransferStartUpload",
        "FileTransferPart",
        "TransformControlsUpdateMessage",
        "SceneNodeDragMessage",
        "GetRenderResponseMessage",
        "NoSuchMessage",
        "",
    ):
        assert not allowed(packed({"type": name, "uuid": "x", "updates": {}}), person)
    for raw in (b"", b"\xc1", b"\x93\x01", packed(7), packed([LOOK]), packed({**LOOK, "wxyz": "abcd"}), packed({})):
        assert not allowed(raw, person)
    assert not allowed(packed({**LOOK, "position": [0, 0]}), person)
    assert not allowed(packed({**POINT, "ray_origin": None}), person)


def test_garbage_and_floods_leave_nothing_behind(live: Live) -> None:
    server = live.runtime.scene._server
    for number in range(40):
        with enter(live, f"tab{number}") as line:
            line.send(packed(LOOK))
            for raw in (b"\xc1", packed({"type": "ShareUrlRequest"}), packed({**LOOK, "fov": "wide"}), b""):
                line.send(raw)
            if number % 2:
                line.socket.close()
    live.until(lambda: not server.get_clients() and not mount.websocket_server(server)._live_connections)
    live.until(lambda: len(live.runtime.sockets) == 0)


def test_a_browser_that_floods_the_scene_is_sent_away_and_turning_the_view_is_no_flood(live: Live) -> None:
    with enter(live, "calm") as calm:
        with enter(live, "flood") as flood:
            for number in range(MOST_PER_SECOND + 200):
                try:
                    flood.send(packed(LOOK) if number % 2 else b"\xc1")  # what is refused counts, too
                except ConnectionClosed:
                    break
            with pytest.raises(ConnectionClosed) as end:
                while True:
                    flood.recv(timeout=5)
        assert end.value.rcvd is not None and end.value.rcvd.code == 1008
        for number in range(120):
            calm.send(packed({**LOOK, "position": [number, 0, 5]}))
        live.until(
            lambda: any(c.camera.position[0] == 119 for c in live.runtime.scene._server.get_clients().values())
        )


def test_one_who_floods_is_let_go_before_memory_is() -> None:
    import asyncio

    async def story() -> None:
        async def send(_: bytes) -> None: ...

        line = Connection(SUBPROTOCOL, send)
        for _ in range(10 * MAX_WAITING_MESSAGES):
            line.feed(b"x")
        assert line._inbox.qsize() <= MAX_WAITING_MESSAGES + 1
        with pytest.raises(ConnectionClosed):
            while True:
                await line.recv()

    asyncio.run(story())


@pytest.mark.parametrize("turns", range(8))
def test_an_end_that_comes_with_the_last_bytes_of_a_frame_ends_the_sending(turns: int) -> None:
    """viser cancels what sends to a browser that left; an end that got lost kept that browser for ever."""
    import asyncio

    async def story() -> None:
        through = asyncio.get_running_loop().create_future()

        async def send(_: bytes) -> None:
            await through

        sending = asyncio.create_task(Connection(SUBPROTOCOL, send).send(b"frame"))
        await asyncio.sleep(0.01)
        through.set_result(None)
        for _ in range(turns):
            await asyncio.sleep(0)
        before = sending.done()
        sending.cancel()
        await asyncio.wait({sending})
        assert before or sending.cancelled()

    asyncio.run(story())


def test_the_tunnel_to_the_outside_is_gone(live: Live) -> None:
    server = live.runtime.scene._server
    handlers = {kind.__name__ for kind in mount.websocket_server(server)._incoming_handlers}
    assert not {"ShareUrlRequest", "ShareUrlDisconnect"} & handlers
    assert server.request_share_url() is None


def test_the_page_hides_the_panel_and_is_not_kept_without_asking(live: Live) -> None:
    answer = live.ask("GET", "/scene/", token=live.viewer, headers={"Accept-Encoding": "gzip"})
    assert answer.headers["content-encoding"] == "gzip" and answer.headers["cache-control"] == "no-cache"
    text = gzip.decompress(answer.body).decode()
    assert re.search(r"<head>\s*<style>[^<]*floating-panel[^<]*display:none", text)
    plain = live.ask("GET", "/scene/", token=live.viewer)
    assert plain.body.decode() == text
    again = live.ask("GET", "/scene/", token=live.viewer, headers={"If-None-Match": answer.headers["etag"]})
    assert again.status == 304 and again.body == b""


def test_it_starts_and_stops_again_and_again_without_a_thread_left() -> None:
    before = threading.active_count()
    for _ in range(3):
        server, inside = open_viser()
        assert inside.loop is not None and server.get_port() == 0
        close_viser(server)
        assert inside.loop.is_closed()
    assert threading.active_count() <= before + 1


def test_a_viser_that_starts_differently_is_told_and_never_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    from core.errors import Unavailable

    monkeypatch.setattr(mount, "build", lambda _: None)
    with pytest.raises(Unavailable, match="this version of viser starts differently"):
        open_viser()
    ended = threading.Event()
    monkeypatch.setattr(mount, "MAX_BUILD_S", 0.1)
    monkeypatch.setattr(mount, "build", lambda _: ended.wait())
    with pytest.raises(Unavailable, match=r"did not start within 0\.1 s"):
        open_viser()
    ended.set()


def test_other_servers_of_viser_in_this_process_are_as_before(capsys: pytest.CaptureFixture[str]) -> None:
    mount.install()
    ordinary = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        assert ordinary.get_port() > 0
    finally:
        ordinary.stop()


def test_without_a_scene_the_console_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from core.errors import Unavailable

    def cannot() -> None:
        raise Unavailable("The 3-D scene was mounted but says nothing.")

    monkeypatch.setattr("console.scene.open_viser", cannot)
    with Live(tmp_path) as live:
        assert live.ask("GET", "/api/health").json["scene"] == "The 3-D scene was mounted but says nothing."
        with live.open("/scene/ws/tab", subprotocols=[SUBPROTOCOL]) as line:
            with pytest.raises(ConnectionClosed) as end:
                line.recv(timeout=5)
            assert end.value.rcvd is not None and end.value.rcvd.code == 1011


class Fails:
    """An overlay that cannot be made, or cannot be shown."""

    makes = True

    def __init__(self, scene: Any, robot: Any) -> None:
        if not self.makes:
            raise ZeroDivisionError

    def show(self, snapshot: Any) -> None:
        raise ZeroDivisionError


@pytest.mark.parametrize("makes", [True, False])
def test_a_scene_that_cannot_be_drawn_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, makes: bool) -> None:
    monkeypatch.setattr("console.scene.OVERLAYS", (Fails,))
    monkeypatch.setattr(Fails, "makes", makes)
    with Live(tmp_path) as live, enter(live) as line:
        line.send(packed(LOOK))
        live.until(lambda: live.runtime.scene.why_not)
        told = live.ask("GET", "/api/health").json["scene"]
        assert "cannot be drawn" in told
        live.until(lambda: any(notice.text == told for notice in live.runtime.notifications.shown))


def test_every_overlay_shows_a_snapshot_twice(live: Live) -> None:
    server, _ = open_viser()
    try:
        overlays = [overlay(server.scene, live.robot.profile) for overlay in OVERLAYS]
        drawn = [set(server.scene._handle_from_node_name)]
        for _ in range(2):
            for overlay in overlays:
                overlay.show(live.runtime.snapshot)
            drawn.append(set(server.scene._handle_from_node_name))
        assert len(drawn[1]) > len(OVERLAYS) and drawn[2] == drawn[1]  # the second time nothing new is made
    finally:
        close_viser(server)


@pytest.mark.parametrize(
    ("origin", "direction", "place"),
    [
        ((1.0, 2.0, 5.0), (0.0, 0.0, -1.0), (1.0, 2.0)),
        ((0.0, 0.0, 2.0), (1.0, -0.5, -1.0), (2.0, -1.0)),
        ((0.0, 0.0, 2.0), (1.0, 0.0, 0.0), None),
        ((0.0, 0.0, 2.0), (0.0, 0.0, 1.0), None),
        ((math.nan, 0.0, 2.0), (0.0, 0.0, -1.0), None),
        ((0.0, 0.0, math.inf), (0.0, 0.0, -1.0), None),
    ],
)
def test_a_ray_meets_the_floor_where_it_must(origin: Any, direction: Any, place: Any) -> None:
    assert floor_point(origin, direction) == (None if place is None else pytest.approx(place))


def test_an_ellipse_encloses_what_its_covariance_says() -> None:
    covariance = np.array([[0.04, 0.012], [0.012, 0.01]])
    outline = ellipses(np.array([[1.0, -2.0]]), covariance[None], 2.0, 0.3)
    assert outline.shape == (32, 2, 3) and np.allclose(outline[..., 2], 0.3)
    offsets = outline[:, 0, :2] - (1.0, -2.0)
    distances = np.einsum("ni,ij,nj->n", offsets, np.linalg.inv(covariance), offsets)
    assert np.allclose(distances, 4.0, atol=1e-6)


def test_the_map_picture_has_north_up_and_the_unknown_transparent() -> None:
    odds = np.zeros((40, 60), np.float32)
    odds[:10, :] = 3.0
    odds[20:30, :] = -3.0
    picture = paint(OccupancyGrid(revision=1, resolution=0.05, origin=np.zeros(2), log_odds=odds))
    assert picture.shape[2] == 4 and picture.dtype == np.uint8
    height = picture.shape[0]
    assert picture[-15, 90, 3] > 180
    assert 0 < picture[int(height * 0.375), 90, 3] < 80
    assert picture[1, 90, 3] == 0


def test_a_turned_solid_is_closed_and_keeps_its_radius() -> None:
    vertices, faces = turned(rounded_disc(0.09, 0.01, 0.08, 0.01))
    assert np.hypot(vertices[:, 0], vertices[:, 1]).max() == pytest.approx(0.09)
    assert vertices[:, 2].min() == pytest.approx(0.01) and vertices[:, 2].max() == pytest.approx(0.08)
    assert faces.max() < len(vertices) and faces.min() == 0


def test_a_line_of_one_point_has_no_segment() -> None:
    assert joined(np.zeros((1, 2)), 0.1).shape == (0, 2, 3)
    assert joined(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.1).shape == (2, 2, 3)
