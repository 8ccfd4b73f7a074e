"""Messages live for Foxglove, Lichtblick and other programs on this computer, to look at only."""

import importlib.util
from collections.abc import Iterable, Mapping
from typing import Any, cast

from core.errors import Unavailable
from core.install import install_extra
from core.recording.mcap_writing import NS_PER_S
from core.recording.ros_writing import LATCHED_TOPICS, RosMessage, definition

LOOPBACK_ADDRESS = "127.0.0.1"  # it asks nobody who he is
MAX_WAITING_MESSAGES = 256  # for a slow client; then its oldest are left out


def check_installed() -> None:
    """Raises Unavailable with the command that installs what is missing."""
    if importlib.util.find_spec("foxglove") is None:
        raise Unavailable(f"To serve Foxglove the extra foxglove is needed: {install_extra('foxglove')}")


class FoxgloveServer:
    """One server; it has no capability by which a client could publish, set a parameter or call a service."""

    def __init__(self, port: int, name: str, topics: Mapping[str, str]) -> None:
        """`port` 0 takes any free one; `topics`, with their types, are known to a client from its first moment.

        The package (0.30) announces a later topic before it takes a subscription to it: who asks at once is refused.
        Raises Unavailable.
        """
        check_installed()
        import foxglove  # 54 MB

        self._make_channel, self._make_schema = foxglove.Channel, foxglove.Schema
        self._context = foxglove.Context()
        self._channels: dict[str, Any] = {}
        self._latched: dict[str, tuple[RosMessage, int]] = {}  # and its time [ns]
        for topic, kind in topics.items():
            self._channel(topic, kind)
        try:
            self._server = foxglove.start_server(
                name=name,
                host=LOOPBACK_ADDRESS,
                port=port,
                capabilities=[],
                server_listener=cast("Any", self),
                context=self._context,
                message_backlog_size=MAX_WAITING_MESSAGES,
            )
        except (RuntimeError, OSError, ValueError) as trouble:
            raise Unavailable(f"Foxglove cannot be served on port {port}: {trouble}") from None

    @property
    def port(self) -> int:
        """The port it listens on."""
        return int(self._server.port)

    def publish(self, messages: Iterable[RosMessage], logged: float) -> None:
        """Send messages that came at `logged` [s], Unix time, to every client that wants them."""
        log_time = max(round(logged * NS_PER_S), 0)
        for one in messages:
            if one.topic in LATCHED_TOPICS:
                self._latched[one.topic] = one, log_time
            self._channel(one.topic, one.kind).log(one.data, log_time=log_time)

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """A client wants a topic: where its newest message holds until the next one, that is sent at once."""
        if channel.topic in self._latched:
            one, log_time = self._latched[channel.topic]
            self._channels[channel.topic].log(one.data, log_time=log_time, sink_id=client.id)

    def __getattr__(self, name: str) -> Any:
        """Everything else that a client does is nothing to this server."""
        if name.startswith("on_"):
            return lambda *_: None
        raise AttributeError(name)

    def close(self) -> None:
        """Hang up."""
        self._server.stop()

    def _channel(self, topic: str, kind: str) -> Any:
        if topic not in self._channels:
            schema = self._make_schema(name=kind, encoding="ros2msg", data=definition(kind).encode())
            self._channels[topic] = self._make_channel(
                topic, schema=schema, message_encoding="cdr", context=self._context
            )
        return self._channels[topic]
