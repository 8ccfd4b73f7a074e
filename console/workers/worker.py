"""Workers that may be killed: dangerous or slow jobs run in a process of their own."""

import asyncio
import logging
import signal
import socket
import threading

import msgspec

from console.workers.child_process import ChildProcess
from console.workers.job import (
    LENGTH,
    Answer,
    Content,
    Job,
    JobFailure,
    JobRequest,
    JobResult,
    answer_decoder,
    packed,
)
from core import errors
from core.errors import BadInput, Unavailable
from core.sentences import coded

log = logging.getLogger(__name__)

START_TIMEOUT_S = 90.0  # until a worker has to be ready, on a busy computer too
END_TIMEOUT_S = 1.0  # that a worker whose pipe is closed may take to end by itself
CLOCK_BUDGET_RATIO = 4.0  # times its processor time that a job may take by the clock
MAX_ANSWER_BYTES = 2**26  # of one answer
READY = msgspec.msgpack.Decoder(JobResult[None])  # what a worker says first


class WorkerLost(Unavailable):
    """The worker is gone, and with it the job; the text says why."""

    def __init__(self, words: str, *, killed: bool = False) -> None:
        super().__init__(words)
        self.killed = killed  # from outside, so that the job is not to blame


class Worker:
    """One process for one kind of work, started when first asked, started again after it was lost.

    Lives on the event loop. Jobs wait for each other; there is never more than one under way.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.starts = 0  # how often it was started: a caller that keeps something there notices that it is gone
        self._child: ChildProcess | None = None
        self._reader: asyncio.StreamReader | None = None
        self._writer: asyncio.StreamWriter | None = None
        self._turn = asyncio.Lock()
        self._reaper: threading.Thread | None = None

    @property
    def alive(self) -> bool:
        return self._child is not None and self._child.alive

    @property
    def pid(self) -> int | None:
        return self._child.pid if self._child is not None and self.alive else None

    @property
    def busy(self) -> bool:
        return self._turn.locked()

    async def ready(self) -> None:
        """Start it, if it is not there. Raises WorkerLost."""
        async with self._turn:
            await self._ready()

    async def ask(self, job: Job[Answer], *, budget: float) -> Answer:
        """One job with so much processor time [s] → its answer.

        Raises WorkerLost when the worker was killed or broke, otherwise what the job raised: BadInput, Refused.
        """
        async with self._turn:
            await self._ready()
            request = packed(JobRequest(job, budget))
            answer = await self._converse(request, CLOCK_BUDGET_RATIO * budget, answer_decoder(type(job)))
        if isinstance(answer, JobFailure):
            if answer.details:
                log.error("A worker failed: %s", answer.details)
            raise getattr(errors, answer.error)(coded(answer.sentence, answer.said))
        return answer.result

    def kill(self) -> None:
        """End it now; a job under way is lost. Nobody waits here until the process is gone."""
        if self._writer is not None:
            self._writer.close()
        if self._child is not None:
            self._child.kill()
            self._reaper = threading.Thread(target=self._child.end, args=(END_TIMEOUT_S,), daemon=True)
            self._reaper.start()
        self._child = self._reader = self._writer = None

    async def gone(self) -> None:
        """It was killed: wait a while until no process is left."""
        if self._reaper is not None:
            await asyncio.to_thread(self._reaper.join, END_TIMEOUT_S)

    async def _ready(self) -> None:
        if self.alive:
            return
        self.kill()
        ours, theirs = socket.socketpair()
        with theirs:
            arguments = [f"--pipe={theirs.fileno()}", f"--worker={self.kind}"]
            self._child = await asyncio.to_thread(ChildProcess, "console.workers.process", arguments, [theirs])
        self._reader, self._writer = await asyncio.open_connection(sock=ours, limit=2**20)
        self.starts += 1
        await self._converse(b"", START_TIMEOUT_S, READY)

    async def _converse(self, raw: bytes, patience: float, decoder: msgspec.msgpack.Decoder[Content]) -> Content:
        """Send, and wait for the answer. Raises WorkerLost; then the worker is gone."""
        reader, writer = self._reader, self._writer
        if reader is None or writer is None:
            raise WorkerLost("The worker process is gone.")
        try:
            async with asyncio.timeout(patience):
                writer.write(raw)
                await writer.drain()
                length = LENGTH.unpack(await reader.readexactly(LENGTH.size))[0]
                if length > MAX_ANSWER_BYTES:
                    raise WorkerLost("The worker process talks nonsense; it is started again.")
                return decoder.decode(await reader.readexactly(length))
        except TimeoutError:  # by the clock: its processor time has a limit of its own
            self.kill()
            raise WorkerLost("That took too long, so it was given up.", killed=True) from None
        except (OSError, asyncio.IncompleteReadError):
            raise await self._last_words() from None
        except (msgspec.MsgspecError, BadInput):
            self.kill()
            raise WorkerLost("The worker process talks nonsense; it is started again.") from None
        except BaseException:
            self.kill()
            raise

    async def _last_words(self) -> WorkerLost:
        child, code = self._child, None
        try:
            if child is not None:
                async with asyncio.timeout(2 * END_TIMEOUT_S):
                    await asyncio.to_thread(child.end, END_TIMEOUT_S)
                code = child.code
        except TimeoutError:
            log.warning("A worker does not end: process %d.", child.pid if child else 0)
        finally:
            self.kill()
        if code == -signal.SIGPROF:
            return WorkerLost("That took too long, so it was given up.")
        killed = code in (-signal.SIGKILL, -signal.SIGTERM)
        return WorkerLost("That broke the worker that looked at it; nothing else was lost.", killed=killed)
