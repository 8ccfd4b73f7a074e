"""A fleet that really listens, in this process, with light robots on its bus."""

from __future__ import annotations

import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from console.access.guard import Access
from console.access.logins import Logins
from console.fleet.authority import Authority
from console.fleet.bus import FleetAddress
from console.fleet_server.runtime import FleetRuntime
from console.fleet_server.serve import create_fleet_app
from console.http.server import Server, configured
from tests.console.live import MORE, Served
from tests.core.robots.links import until
from tests.emulators.light_console import LightConsole
from tests.emulators.zenoh_robot import free_port

ROOM_CM = [-290, -190, 290, -190, 290, 190, -290, 190]
OUTLINE = {"walls_cm": [[-300, -200, 300, -200, 300, 200, -300, 200], ROOM_CM], "floor_cm": [ROOM_CM]}
ANSWERS = {
    "/api/map/outline": OUTLINE,
    "/api/maps": {"current": "lab", "maps": [{"name": "lab"}]},
    **{f"/api/{kind}": {kind: [{"name": kind}]} for kind in ("places", "zones", "routes")},
}


class ConsolesOfAll(ThreadingHTTPServer):
    """The HTTP side of the consoles of light robots: one map, which all of them have saved."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), ConsoleAnswer)
        self.posted: list[tuple[str, bytes]] = []
        threading.Thread(target=self.serve_forever, daemon=True).start()


class ConsoleAnswer(BaseHTTPRequestHandler):
    server: ConsolesOfAll

    def do_GET(self) -> None:
        self._send(b"PK" if self.path.endswith(".zip") else json.dumps(ANSWERS.get(self.path, {})).encode())

    def do_POST(self) -> None:
        self.server.posted.append((self.path, self.rfile.read(int(self.headers.get("content-length", 0)))))
        self._send(b"{}")

    def _send(self, body: bytes) -> None:
        self.send_response(200)
        self.send_header("content-length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Nothing."""


class LiveFleet(Served):
    """The fleet between `with` and its end; its robots have joined when it begins."""

    def __init__(self, folder: Path, *robots: str, away: tuple[str, ...] = ()) -> None:
        """`away` have a certificate, and do not join."""
        super().__init__()
        logins = Logins()
        self.operator, self.viewer = logins.issue("operator", "operator"), logins.issue("viewer", "viewer")
        self.url = f"http://127.0.0.1:{self.port}/"
        self.driving = f"{self.url}#t={self.operator}"
        self.consoles = ConsolesOfAll()
        authority, bus = Authority(folder), FleetAddress("127.0.0.1", free_port())
        authority.prepare(("127.0.0.1",))
        self.robots: dict[str, LightConsole] = {}
        for number, name in enumerate(robots):
            authority.issue(name, folder / name, kind="robot")
            page = f"http://127.0.0.1:{self.consoles.server_port}/"
            self.robots[name] = LightConsole(name, bus, folder / name, folder / f"{name}-home", number, page)
        for name in away:
            authority.issue(name, folder / name, kind="robot")
        self.runtime = FleetRuntime(folder, Access(logins, cookie=self.cookie_name), authority, bus)
        self.app = create_fleet_app(self.runtime)
        self.server = Server(configured(self.app), self.runtime, lambda: None)

    def __enter__(self) -> LiveFleet:
        self._thread.start()
        until(lambda: self.server.started)
        for robot in self.robots.values():
            self.on_loop(robot.open)
        until(lambda: all(self.link(name) == "live" for name in self.robots))
        return self

    def __exit__(self, *_: object) -> None:
        for robot in self.robots.values():
            self.run(robot.close())
        self.consoles.shutdown()
        self.runtime.shut_down_soon()
        self.server.should_exit = True
        self._thread.join(MORE)
        assert not self._thread.is_alive(), "the fleet did not end"

    def reset(self) -> None:
        """End a halt of all, and each robot's own."""
        self.ask("POST", "/api/fleet/halt/reset", token=self.operator, headers={"content-length": "0"})
        for robot in self.robots.values():
            self.on_loop(robot.robot.reset)

    def share_a_map(self, *names: str) -> None:
        """These go on in one map."""
        for name in names:
            self.robots[name].maps.frame, self.robots[name].maps.shown.name = "axes", "lab"
        until(lambda: all(self.runtime.router.table.robots[name].report.map.id for name in names))

    def link(self, name: str) -> str:
        """How a robot is there."""
        return self.runtime.router.table.robots[name].link
