"""One browser as viser sees it, and what that browser may say."""

import asyncio
from collections.abc import Awaitable, Callable

import msgspec
from websockets.exceptions import ConnectionClosedOK

from console.access.logins import Person

MAX_WAITING_MESSAGES = 256  # messages that may wait for viser; past that the browser floods
SEND_TIME_S = 10.0  # for one frame; a browser that takes longer is disconnected

Vector = tuple[float, float, float]


class ViewerCameraMessage(msgspec.Struct, tag=True):
    """The browser moved its view; viser counts a browser as connected after the first of these."""

    wxyz: tuple[float, float, float, float]
    position: Vector
    fov: float
    near: float
    far: float
    image_height: float
    image_width: float
    look_at: Vector
    up_direction: Vector


class ScenePointerMessage(msgspec.Struct, tag=True):
    event_type: str
    ray_origin: Vector
    ray_direction: Vector
    screen_pos: tuple[tuple[float, float], ...]
    modifier: str | None


LOOKING = msgspec.msgpack.Decoder(ViewerCameraMessage)
POINTING = msgspec.msgpack.Decoder(ViewerCameraMessage | ScenePointerMessage)


def allowed(raw: bytes, person: Person) -> bool:
    """Return whether viser may hear this: everybody looks around, operators also point. All else is dropped."""
    try:
        (POINTING if person.may("operator") else LOOKING).decode(raw)
    except msgspec.DecodeError:
        return False
    return True


class Connection:
    """The methods of a websocket that viser's handler uses. They run on viser's loop."""

    def __init__(
        self,
        subprotocol: str | None,
        send: Callable[[bytes], Awaitable[None]],
        *,
        person: Person | None = None,
        tab: str = "",
    ) -> None:
        self.subprotocol = subprotocol
        self.person = person
        self.tab = tab
        self._send = send
        self._inbox: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._closed = False

    async def recv(self) -> bytes:
        if self._closed and self._inbox.empty():
            raise ConnectionClosedOK(None, None)
        message = await self._inbox.get()
        if message is None:
            raise ConnectionClosedOK(None, None)
        return message

    async def send(self, frame: bytes) -> None:
        """A frame for the browser; one that does not read is let go."""
        if self._closed:
            raise ConnectionClosedOK(None, None)
        try:
            async with asyncio.timeout(SEND_TIME_S):
                await self._send(frame)
        except Exception:
            self.eof()
            raise ConnectionClosedOK(None, None) from None

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """viser ends the conversation; the socket itself is closed by the code that opened it."""
        self.eof()

    def feed(self, message: bytes) -> None:
        if self._inbox.qsize() >= MAX_WAITING_MESSAGES:
            self.eof()
        elif not self._closed:
            self._inbox.put_nowait(message)

    def eof(self) -> None:
        if not self._closed:
            self._closed = True
            self._inbox.put_nowait(None)
