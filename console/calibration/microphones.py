"""Calibration of the robot's microphones: whether they are wired as their profile says, and how they are turned."""

from __future__ import annotations

import asyncio
import json
import logging
import math
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from console.http.problems import Problem
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from console.workers.array_worker import ArrayWorker
from console.workers.job import Answer, Job
from console.workers.tasks import end
from console.workers.worker import Worker, WorkerLost
from core.calibration.files.camera_files import read_json
from core.errors import BadInput, BeckonError, Refused, Unavailable
from core.files import SEAL, is_intact, saving, sealed, sync_folder, write_atomic
from core.perception.sound.array_diagnostics import ArrayFault
from core.perception.sound.array_orientation import Orientation, OrientationWizard, oriented
from core.robots import Profile
from core.robots.requests import AnswerT, Ask, ReadTruth, RobotRequest, SetListening, Speak
from core.sensors import SensorFrame
from core.sensors.microphones import MicrophoneArray, Sound, joined
from core.sensors.resampling import resampled
from core.snapshot import Snapshot
from core.speech.practice_voice import practice_voice
from core.speech.synthesis import VoiceSettings, speak

log = logging.getLogger(__name__)

CHECKED_S = 3.0  # of sound that the self-check looks at
CLAP_S = 3.0  # within which a person claps
BUDGET_S = 30.0  # of processor time
MOVING_SPEED = 0.02  # [m/s, rad/s]
MOST_CLAPS = 24
FILE = "microphones.json"
RECORDING_TIMEOUT_S = 20.0  # by the clock for a recording of any length
RATE_HZ = 16_000  # of speech in the simulated room
TRIED_DISTANCES_M = (1.5, 1.2, 0.9, 2.0, 0.6)  # that are tried
NAME = "demo"


class MicrophoneRecorder:
    """Lives on the event loop. One recording at a time."""

    def __init__(self, ask: Ask) -> None:
        self._ask = ask
        self._sound: Sound | None = None
        self._seconds = 0.0  # that are wanted; 0: nobody records
        self._news = asyncio.Event()

    def took(self, sound: Sound | None) -> None:
        if sound is not None and self._seconds:
            self._sound = joined(self._sound, sound, self._seconds)
            self._news.set()

    async def record(self, seconds: float, listening: Callable[[], bool], say_from: float | None = None) -> Sound:
        """So many seconds [s] without a gap. `listening`: whether it is to listen afterwards.

        `say_from`: the azimuth [rad] from the simulated robot from which someone speaks meanwhile. Raises Refused
        while another recording is made, and Unavailable when no sound comes.
        """
        if self._seconds:
            raise Refused("A recording is being made already; wait a moment.")
        self._sound, self._seconds = None, seconds
        try:
            await self._ask(SetListening(on=True))
            if say_from is not None:
                await self._say(say_from)
            async with asyncio.timeout(RECORDING_TIMEOUT_S + seconds):
                while self._sound is None or self._sound.duration < seconds - 0.5 / self._sound.rate:
                    self._news.clear()
                    await self._news.wait()
            return self._sound
        except TimeoutError:
            raise Unavailable("No sound comes from the robot's microphones; are they connected?") from None
        finally:
            self._seconds = 0.0
            if not listening():
                await self._ask(SetListening(on=False))

    async def _say(self, azimuth: float) -> None:
        """Let a person speak from there, as far away as the room allows."""
        robot = await self._ask(ReadTruth())
        samples = await asyncio.to_thread(words)
        angle = robot.heading_rad + azimuth
        trouble: BeckonError = BadInput("Nobody can speak from there: the robot stands too close to the walls.")
        for distance in TRIED_DISTANCES_M:
            x, y = robot.x_m + distance * math.cos(angle), robot.y_m + distance * math.sin(angle)
            try:
                await self._ask(Speak(pcm=samples, x_m=x, y_m=y))
                return
            except BadInput as blocked:
                trouble = blocked
        raise trouble


def words() -> bytes:
    """Return a word of the demo: 16-bit samples at RATE; without text to speech a made-up voice."""
    try:
        sound = speak("Here I am, here.", VoiceSettings())
        samples = resampled(sound.samples[:, 0], sound.rate, RATE_HZ)
    except Unavailable:
        samples = practice_voice(np.random.default_rng(0), 1.5, RATE_HZ)
    level = np.clip(0.3 * samples / np.abs(samples).max(), -1, 1)
    return np.round(32767 * level).astype("<i2").tobytes()


class AcceptedOrientation(msgspec.Struct, frozen=True):
    """The file of an orientation, under a checksum; one that was written by hand may do without the lower half."""

    yaw: float  # [rad] robot_from_microphones
    yaw_sd: float  # [rad]
    mirrored: bool  # the array is mounted upside down
    residual: float  # [rad] rms
    claps: int | None = None
    accepted_s: float | None = None
    who: str | None = None

    @property
    def orientation(self) -> Orientation:
        return Orientation(yaw=self.yaw, yaw_sd=self.yaw_sd, mirrored=self.mirrored, residual=self.residual)


def read_orientation(path: Path) -> tuple[AcceptedOrientation | None, bool]:
    """Return the orientation in the file, or None without a file, and whether it has its checksum.

    Raises BadInput if it cannot be used.
    """
    try:
        document = read_json(path.read_text(encoding="utf-8"))
        found = msgspec.convert(document, AcceptedOrientation)
        why = ""
        if not all(abs(number) <= math.tau for number in (found.yaw, found.yaw_sd, found.residual)):
            why = "its numbers cannot be"
        if is_intact(document) is False:
            why = f"it was changed after it was saved (if you changed it yourself, remove its “{SEAL}”)"
        if not why:
            return found, SEAL in document
    except FileNotFoundError:
        return None, False
    except (OSError, ValueError, BadInput, msgspec.ValidationError) as trouble:
        why = trouble.strerror if isinstance(trouble, OSError) else "it is damaged"
    raise BadInput(f"The microphones' orientation in {path.name} cannot be used: {why}. Measure it again.")


def write_orientation(path: Path, found: AcceptedOrientation | None) -> None:
    """Put the orientation into the file, whole or not at all; None removes it. Raises OSError."""
    if found is None:
        path.unlink(missing_ok=True)
        if path.parent.is_dir():
            sync_folder(path.parent)
        return
    write_atomic(path, json.dumps(sealed(msgspec.structs.asdict(found))))


@dataclass(frozen=True)
class ArrayCheck:
    """The result of the newest self-check; `well`: null before the first."""

    busy: bool
    well: bool | None
    faults: tuple[ArrayFault, ...]
    trouble: str


@dataclass(frozen=True)
class ClapRow:
    """A clap: where it was asked for, and where the array heard it."""

    asked_rad: float  # in the robot frame
    heard_rad: float  # in the array frame
    sd_rad: float
    gap_rad: float | None  # between the solution and what was heard


@dataclass(frozen=True)
class OrientationRow:
    """How the array is turned on the robot."""

    yaw_rad: float
    sd_yaw_rad: float
    mirrored: bool
    residual_rad: float

    @classmethod
    def of(cls, found: Orientation) -> OrientationRow:
        return cls(found.yaw, found.yaw_sd, found.mirrored, found.residual)


@dataclass(frozen=True)
class ActiveOrientationRow(OrientationRow):
    """The orientation in use: who accepted it when, and why it is not used, or ''."""

    claps: int | None
    accepted_s: float | None
    who: str | None
    verified: bool
    not_used: str


@dataclass(frozen=True)
class MicrophonesState:
    """Everything that the wizard's page shows."""

    microphones: bool
    simulated: bool
    busy: bool
    listens_s: float
    asked_rad: list[float]
    claps: list[ClapRow]
    advice: str
    verdict: str
    trouble: str
    missing: str
    solution: OrientationRow | None
    active: ActiveOrientationRow | None


class MicrophoneCalibration(Part):
    """Lives on the event loop."""

    def __init__(self, home: Path, robot: RobotSupervisor, changed: Callable[[], None]) -> None:
        """`changed`: another orientation is in use."""
        self.wizard = OrientationWizard()
        self.active: AcceptedOrientation | None = None
        self._verified = False  # the file of the accepted orientation has its checksum
        self.left_out = ""  # why the accepted orientation is not used in this run
        self.verdict = ""  # of the newest clap
        self.busy = False
        self.trouble = ""  # why the newest measurement could not be made
        self.faults: tuple[ArrayFault, ...] | None = None  # of the newest self-check; None: nothing was checked
        self.helped = False  # a person in the simulated room speaks for the measurement: no command
        self.moves = False  # the robot does, so that nothing can be measured
        self._path = home / "calibration" / FILE
        self._robot, self._changed = robot, changed
        self._recorder = MicrophoneRecorder(self._ask)
        self._worker = Worker("array")
        self.listening = False  # as a person wants it, whatever is measured
        self._task: asyncio.Task[None] | None = None

    async def open(self) -> None:
        try:
            self.active, self._verified = await asyncio.to_thread(read_orientation, self._path)
        except BadInput as wrong:
            self.trouble = str(wrong)
            log.warning(self.trouble)

    async def close(self) -> None:
        await end(self._task)
        self._worker.kill()
        await self._worker.gone()

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        self.moves = abs(snapshot.velocity.v) > MOVING_SPEED or abs(snapshot.velocity.w) > MOVING_SPEED
        if not self.busy:
            self.listening = snapshot.hearing is not None and snapshot.hearing.listening
        self._recorder.took(frame.sound)

    def calibrated(self, profile: Profile) -> Profile:
        """The robot with its microphones as they were found to be mounted."""
        if profile.microphones is None or self.active is None or self.left_out:
            return profile
        return profile.with_microphones(oriented(profile.microphones, self.active.orientation))

    def leave_out(self, why: str) -> list[str]:
        """Use the accepted orientation no more in this run → its file, if it was in use until now."""
        if self._array is None or self.active is None or self.left_out:
            return []
        self.left_out = why
        return [FILE]

    def check(self, *, show: bool) -> None:
        """Listen for a moment, and check the channels; `show`: in the simulated room a person speaks meanwhile.

        Raises Problem 404 or 409. What comes of it stands in `faults`. What is said in the room meanwhile is no
        order, not even a stop: so the robot has to stand.
        """
        if show and self.moves:
            raise Problem(409, "The robot moves; let it stand while its microphones are checked.")
        self._start(self._check(0.0 if show else None), show=show)

    def clap(self, asked: float, *, show: bool) -> None:
        """A person claps at `asked` [rad] from the robot; `show`: in the simulated room a person speaks from there.

        Raises Problem 404, and 409 while the robot moves. What is wrong with the clap stands in the verdict.
        """
        if self.moves:
            raise Problem(409, "The robot moves; let it stand while its microphones are measured.")
        if len(self.wizard.claps) >= MOST_CLAPS:
            raise Problem(409, f"{MOST_CLAPS} claps are enough; begin again to take others.")
        self._start(self._clap(asked, asked if show else None), show=show)

    def forget(self) -> None:
        self.wizard, self.verdict = OrientationWizard(), ""

    def drop(self, number: int) -> None:
        """Leave a clap out. Raises Problem 404."""
        if not 0 <= number < len(self.wizard.claps):
            raise Problem(404, "There is no such clap.")
        self.wizard.drop(number)
        self.verdict = ""

    async def accept(self, who: str) -> None:
        """Use the measured orientation. Raises Refused with the missing claps."""
        found = self.wizard.solve()
        if isinstance(found, str):
            raise Refused(found)
        claps = len(self.wizard.claps)
        await self._use(
            AcceptedOrientation(found.yaw, found.yaw_sd, found.mirrored, found.residual, claps, time.time(), who)
        )

    async def undo(self) -> None:
        """The profile's own orientation again."""
        await self._use(None)

    def checked(self) -> ArrayCheck:
        found = self.faults
        well = None if found is None else not any(fault.serious for fault in found)
        return ArrayCheck(self.busy, well, found or (), self.trouble)

    @property
    def state(self) -> MicrophonesState:
        solved = self.wizard.solve()
        found = None if isinstance(solved, str) else solved
        return MicrophonesState(
            microphones=self._array is not None,
            simulated=self._robot.profile.simulated,
            busy=self.busy,
            listens_s=CLAP_S,
            asked_rad=list(self.wizard.asked),
            claps=[
                ClapRow(one.asked, one.heard, one.sd, None if found is None else one.gap(found))
                for one in self.wizard.claps
            ],
            advice=self.wizard.advice,
            verdict=self.verdict,
            trouble=self.trouble,
            missing=solved if isinstance(solved, str) else "",
            solution=None if found is None else OrientationRow.of(found),
            active=self._active_row(),
        )

    def _active_row(self) -> ActiveOrientationRow | None:
        one = self.active
        if one is None:
            return None
        return ActiveOrientationRow(
            **vars(OrientationRow.of(one.orientation)),
            claps=one.claps,
            accepted_s=one.accepted_s,
            who=one.who,
            verified=self._verified,
            not_used=self.left_out,
        )

    @property
    def _array(self) -> MicrophoneArray | None:
        return self._robot.profile.microphones

    async def _ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        return await asyncio.to_thread(self._robot.ask, request)

    def _start(self, work: Coroutine[Any, Any, None], *, show: bool) -> None:
        """Work that takes some seconds. Raises Problem."""
        try:
            self._ready(show=show)
        except Problem:
            work.close()
            raise
        self.busy, self.helped, self.trouble = True, show, ""
        self._task = asyncio.get_running_loop().create_task(self._to_the_end(work))

    def _ready(self, *, show: bool) -> None:
        if self._array is None:
            raise Problem(404, "This robot has no microphones.")
        if self.busy:
            raise Problem(409, "The microphones are being listened to already; wait a moment.")
        if show and not self._robot.profile.simulated:
            raise Problem(409, "Only in the simulated room someone is there to help; clap yourself.")

    async def _to_the_end(self, work: Coroutine[Any, Any, None]) -> None:
        try:
            await work
        except BeckonError as trouble:
            self.trouble = str(trouble)
        finally:
            self.busy = self.helped = False

    async def _check(self, say_from: float | None) -> None:
        self.faults = None
        self.faults = await self._asked(ArrayWorker.check(*await self._recorded(CHECKED_S, say_from)))

    async def _clap(self, asked: float, say_from: float | None) -> None:
        recorded = await self._recorded(CLAP_S, say_from)
        try:
            clap = await self._asked(ArrayWorker.find_clap(*recorded, asked))
        except BadInput as wrong:
            self.verdict = str(wrong)
            return
        self.verdict = self.wizard.take(clap)

    async def _recorded(self, seconds: float, say_from: float | None) -> tuple[Sound, MicrophoneArray]:
        array = self._array
        assert array is not None
        return await self._recorder.record(seconds, lambda: self.listening, say_from), array

    async def _asked(self, job: Job[Answer]) -> Answer:
        """Raises what the worker raises, and Unavailable when it breaks."""
        try:
            return await self._worker.ask(job, budget=BUDGET_S)
        except WorkerLost as lost:
            log.warning("The worker that looks at the array was lost: %s", lost)
            raise Unavailable("What looks at the microphones broke; try once more.") from None

    async def _use(self, found: AcceptedOrientation | None) -> None:
        with saving("The microphones' orientation could not be saved"):
            await asyncio.to_thread(write_orientation, self._path, found)
        self.active, self._verified, self.left_out = found, found is not None, ""
        self._changed()
