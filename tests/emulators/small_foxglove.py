"""A server of foxglove_bridge's protocol, written from its table: for the dialects and for damaged messages.

It says what a test gives it, to whom connects; what the client sends is kept.
"""

import contextlib
import json
import struct
import threading
from collections.abc import Callable, Sequence
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve
from websockets.typing import Subprotocol

from tests.emulators.wires import serving


class SmallFoxglove:
    """`channels`: topic, type, definition, its form. They get the numbers 1, 2, 3 …"""

    def __init__(
        self,
        channels: Sequence[tuple[str, str, str, str]] = (),
        *,
        dialect: str = "foxglove.websocket.v1",
        encoding: str = "cdr",
        capabilities: Sequence[str] = ("clientPublish",),
    ) -> None:
        self.channels, self.dialect, self.encoding, self.capabilities = channels, dialect, encoding, capabilities
        self.subscriptions: dict[int, int] = {}  # channel → the client's number of it
        self.advertised: dict[int, dict[str, Any]] = {}
        self.published: list[tuple[str, bytes]] = []  # topic, payload
        self.on_subscribed: Callable[[SmallFoxglove], None] = lambda _: None
        self.clients: list[ServerConnection] = []
        self._server: Server | None = None
        self._thread: threading.Thread | None = None

    @property
    def port(self) -> int:
        assert self._server is not None
        return int(self._server.socket.getsockname()[1])

    @property
    def url(self) -> str:
        return f"foxglove://127.0.0.1:{self.port}"

    def start(self) -> None:
        self._server = serve(
            self._serve, "127.0.0.1", 0, subprotocols=[Subprotocol(self.dialect)], compression=None, max_size=None
        )
        self._thread = serving(self._server)

    def stop(self) -> None:
        if self._server is not None and self._thread is not None:
            for client in list(self.clients):
                client.close()
            self._server.shutdown()
            self._thread.join()

    def say(self, raw: str | bytes | dict[str, Any]) -> None:
        """To all clients."""
        for client in list(self.clients):
            with contextlib.suppress(ConnectionClosed):
                client.send(json.dumps(raw) if isinstance(raw, dict) else raw)

    def log(self, channel: int, payload: bytes) -> None:
        if channel in self.subscriptions:
            self.say(struct.pack("<BIQ", 1, self.subscriptions[channel], 0) + payload)

    def advertisement(self, channels: dict[int, tuple[str, str, str, str]]) -> dict[str, Any]:
        names = ("topic", "schemaName", "schema", "schemaEncoding")
        entries = [
            {"id": number, "encoding": self.encoding} | dict(zip(names, channel, strict=True))
            for number, channel in channels.items()
        ]
        return {"op": "advertise", "channels": entries}

    def _serve(self, client: ServerConnection) -> None:
        self.clients.append(client)
        self.subscriptions, self.advertised = {}, {}
        self.say(
            {
                "op": "serverInfo",
                "name": "small",
                "capabilities": list(self.capabilities),
                "supportedEncodings": [self.encoding],
            }
        )
        self.say(self.advertisement(dict(enumerate(self.channels, 1))))
        with contextlib.suppress(ConnectionClosed):
            for raw in client:
                self._hear(raw)
        self.clients.remove(client)

    def _hear(self, raw: str | bytes) -> None:
        if isinstance(raw, bytes):
            opcode, number = struct.unpack_from("<BI", raw)
            if opcode == 1:
                self.published.append((self.advertised[number]["topic"], raw[5:]))
            return
        fields = json.loads(raw)
        match fields["op"]:
            case "subscribe":
                self.subscriptions |= {one["channelId"]: one["id"] for one in fields["subscriptions"]}
                self.on_subscribed(self)
            case "advertise":
                self.advertised |= {one["id"]: one for one in fields["channels"]}
