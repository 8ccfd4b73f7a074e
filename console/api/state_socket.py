"""The socket `/ws`: state and camera down, hand and words up.

Two tasks a viewer: one sends the newest and blocks nobody but itself, one listens. A stop is acted on before anything
else is looked at. Every end has a code and a reason.
"""

import asyncio
import contextlib
import math
import secrets
import time
from typing import Any

import msgspec
from starlette.websockets import WebSocket, WebSocketDisconnect

from console import beckon_version
from console.access.logins import Person
from console.access.open_sockets import TooMany
from console.access.strict_json import read_json
from console.broadcast import CloseSocket, Subscriber
from console.calibration.service import CalibrationService
from console.control.command_freshness import Spoken
from console.control.pending_commands import PendingCommands
from console.control.playback import PlaybackController
from console.control.stop import latched
from console.http.problems import Problem, refused
from console.http.rate_counter import RateCounter, size_of
from console.messages import inbound
from console.messages import state as messages
from console.runtime import Runtime
from console.state_view import card
from console.workers.tasks import end
from core.errors import BadInput, BeckonError

GONE = CloseSocket(1000, "The browser left.")
SEND_TIME_S = 10.0  # for one message; a browser that takes longer is disconnected
MOST_PER_SECOND = 200  # messages; a stop is heard nevertheless
FLOOD = 5 * MOST_PER_SECOND  # messages a second, stops among them, that end the socket
# Silence after which a crowd of messages may have waited: the console stood, or the link.
STALLED_S = 0.5
MAX_STALL_S = 10.0  # of such a silence, at most, whose messages are excused
MOST_BYTES = 65536  # a second; a hand and its echoes take 5,000
MAX_STOP_MESSAGE = 512  # bytes of a stop or a halt


class StateSocket:
    def __init__(self, runtime: Runtime, socket: WebSocket, person: Person) -> None:
        self._runtime = runtime
        self._socket = socket
        self._person = person
        self._viewer = Subscriber("state", "camera")
        self._tab = secrets.token_hex(8)
        self._session: str | None = None  # of a calibration, the one this page looks at
        self._tally, self._volume = RateCounter(), RateCounter()
        self._heard_at = time.monotonic()  # when the newest message came [s]
        self._stall = -math.inf, 0.0  # when the newest long silence of this socket ended, and how long it was [s]
        self._press: int | None = None  # of the key that this socket's hand holds down

    async def run(self) -> None:
        try:
            with self._runtime.sockets.room_for(self._person, self._viewer.close):
                await self._socket.accept()
                await self._converse()
        except TooMany as crowded:
            await self._socket.accept()
            await self._end(CloseSocket(1013, str(crowded)))

    async def _converse(self) -> None:
        runtime, person = self._runtime, self._person
        runtime.broadcaster.join(self._viewer)
        runtime.scene.tabs[self._tab] = self._tell
        runtime.lease.connected(person, time.monotonic())
        you = messages.You(person.name, person.role, person.id)  # type: ignore[arg-type]
        self._tell(
            messages.HelloMessage(
                you,
                beckon_version(),
                card(runtime.robot.profile),
                runtime.name,
                self._tab,
                1000 * time.monotonic(),
                runtime.chapter,
            )
        )
        listener = asyncio.create_task(self._receive_all())
        try:
            await self._send_all()
        finally:
            await end(listener)
            if self._press is not None:
                runtime.dispatcher.abandon(self._press)
            runtime.broadcaster.viewers.discard(self._viewer)
            runtime.scene.tabs.pop(self._tab, None)
            runtime.lease.disconnected(person)
            runtime.parts[PendingCommands].left(person)

    # down

    async def _send_all(self) -> None:
        try:
            while (message := await self._viewer.next(self._runtime.broadcaster)) is not None:
                async with asyncio.timeout(SEND_TIME_S):
                    if isinstance(message, str):
                        await self._socket.send_text(message)
                    else:
                        await self._socket.send_bytes(message)
        except (TimeoutError, WebSocketDisconnect, RuntimeError):
            return
        if self._viewer.closing is not None and self._viewer.closing != GONE:
            await self._end(self._viewer.closing)

    async def _end(self, closing: CloseSocket) -> None:
        with contextlib.suppress(TimeoutError, WebSocketDisconnect, RuntimeError):
            async with asyncio.timeout(1.0):
                await self._socket.close(closing.code, closing.reason)

    def _tell(self, message: messages.Down) -> None:
        self._viewer.tell(messages.encode(message).decode())

    # up

    async def _receive_all(self) -> None:
        """Receive messages until the socket closes; then stop the sender."""
        try:
            while True:
                message = await self._socket.receive()
                if message["type"] == "websocket.disconnect":
                    self._viewer.close(GONE.code, GONE.reason)
                    return
                text = message.get("text")
                if text is None:
                    self._viewer.close(1003, "This socket takes text.")
                    return
                self._take(text, size_of(message))
        except Exception:
            self._viewer.close(1011, "The console could not take this message.")
            raise

    def _take(self, text: str, size: int) -> None:
        ref, now = 0, time.monotonic()
        heard = self._tally.add(now) - self._waited(now)
        if self._volume.add(now, size) > MOST_BYTES:
            self._viewer.close(1008, f"More than {MOST_BYTES} bytes a second.")
        if self._viewer.closing is not None and size > MAX_STOP_MESSAGE:
            return
        try:
            message = read_json(text)
            self._runtime.lease.active(self._person, now)
            if (stop_message := stop_of(message)) is not None:
                self._stop_controller(stop_message)
                self._bound(heard, FLOOD)
            elif self._bound(heard, MOST_PER_SECOND):
                ref = message["ref"] if isinstance(message, dict) and type(message.get("ref")) is int else 0
                answer = self._act(msgspec.convert(message, inbound.Up))
                if isinstance(answer, messages.AnswerMessage):
                    self._answer(answer)
                elif answer is not None:
                    self._tell(answer)
        except BadInput as trouble:
            self._viewer.close(1007, str(trouble))
        except msgspec.ValidationError:
            self._tell(messages.AnswerMessage(ref, False, 422, "This message has not the form that is asked for."))
        except (Problem, BeckonError) as error:
            self._answer(refused(ref, error))

    def _answer(self, answer: messages.AnswerMessage) -> None:
        self._runtime.keep(self._answer_settled(answer))

    async def _answer_settled(self, answer: messages.AnswerMessage) -> None:
        await self._runtime.history.settled()
        self._tell(answer)

    def _waited(self, now: float) -> float:
        """How many messages of this second may have waited while nothing came, at the rate that is allowed."""
        gap, self._heard_at = now - self._heard_at, now
        if gap > STALLED_S:
            self._stall = now, min(gap, MAX_STALL_S)
        ended, lasted = self._stall
        return MOST_PER_SECOND * lasted if now - ended < 1.0 else 0.0

    def _bound(self, heard: float, most: int) -> bool:
        if heard > most:
            self._viewer.close(1008, f"More than {most} messages a second.")
        return self._viewer.closing is None

    def _act(self, message: inbound.Up) -> messages.Down | None:
        dispatcher, person = self._runtime.dispatcher, self._person
        match message:
            case inbound.JogMessage():
                dispatcher.drive(message, person)
                self._press = message.press if message.v or message.w else None
            case inbound.EchoMessage():
                return messages.EchoBack(message.t)
            case inbound.SayMessage():
                now = time.monotonic()
                given = self._runtime.state_times.oldest(message.seen, now)
                entry = dispatcher.submit(message.text, message.source, person, said=Spoken(now, given))
                return messages.AnswerMessage(message.ref, True, 202, entry.heard_as, id=entry.id)
            case inbound.LeaseMessage():
                self._change_lease(message)
                return messages.AnswerMessage(message.ref, True, 200)
            case inbound.HaltResetMessage():
                dispatcher.reset(person, "page")
                return messages.AnswerMessage(message.ref, True, 200)
            case inbound.PlaybackMessage():
                self._runtime.keep(self._play(message))
            case inbound.SubscriptionMessage():
                self._want(message)
            case inbound.StopMessage() | inbound.HaltMessage():
                self._stop_controller(message)
        return None

    def _change_lease(self, asked: inbound.LeaseMessage) -> None:
        if asked.do != "leave":
            self._runtime.dispatcher.change_lease(asked.do, self._person)
        elif self._runtime.lease.is_last_page(self._person):
            self._runtime.dispatcher.change_lease("release", self._person)

    def _want(self, asked: inbound.SubscriptionMessage) -> None:
        if isinstance(asked.camera, bool):
            self._runtime.broadcaster.want(self._viewer, "camera", wanted=asked.camera)
        if asked.calibration is not msgspec.UNSET:
            self._viewer.want(f"calibration:{self._session}", wanted=False)
            self._session = asked.calibration
        if isinstance(asked.calibration, str):
            self._runtime.broadcaster.want(self._viewer, f"calibration:{self._session}", wanted=True)
            self._runtime.parts[CalibrationService].show(asked.calibration)

    def _stop_controller(self, message: inbound.StopMessage | inbound.HaltMessage) -> None:
        if isinstance(message, inbound.HaltMessage):
            self._runtime.dispatcher.halt(self._person, "page", message.press)
            self._runtime.keep(self._latched())
        else:
            self._runtime.dispatcher.stop(self._person, "page", message.press)

    async def _latched(self) -> None:
        """Tell this socket when its halt may not outlive a restart."""
        if why_not := await latched(self._runtime.robot, self._runtime.notifications):
            self._tell(messages.AnswerMessage(0, False, 507, why_not))

    async def _play(self, message: inbound.PlaybackMessage) -> None:
        """The recording's driver is asked without keeping this socket waiting."""
        answer = messages.AnswerMessage(message.ref, True, 200)
        try:
            await self._runtime.parts[PlaybackController].steer(message, self._person)
        except (Problem, BeckonError) as error:
            answer = refused(message.ref, error)
        self._tell(answer)


def stop_of(message: Any) -> inbound.StopMessage | inbound.HaltMessage | None:
    """A stop or a halt, however carelessly it is written."""
    if not isinstance(message, dict):
        return None
    kinds: dict[Any, type[inbound.StopMessage | inbound.HaltMessage]] = {
        "stop": inbound.StopMessage,
        "halt": inbound.HaltMessage,
    }
    kind = kinds.get(message.get("kind")) if isinstance(message.get("kind"), str) else None
    press = message.get("press")
    return kind(press if type(press) is int else 0) if kind else None
