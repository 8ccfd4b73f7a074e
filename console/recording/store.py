"""Finished recordings: a folder of files, a note for each, and what is made of them."""

import asyncio
import contextlib
import logging
import re
import shutil
import stat
import unicodedata
from datetime import datetime
from pathlib import Path

import msgspec

from console.access.logins import Person
from console.control.history import History
from console.control.notices import Notifications
from console.http.problems import Problem
from console.part import Part
from console.recording import work
from console.recording.work import RecorderWorker
from console.workers.worker import Worker, WorkerLost
from core.errors import BadInput, BeckonError
from core.files import replacing, saving, write_atomic
from core.pipelines.drive_film import FilmForm
from core.recording.mcap_writing import PART
from core.recording.settings import RecordingSettings
from core.sentences import Statement

log = logging.getLogger(__name__)

FOLDER, NOTES = "recordings", "recordings.json"  # in the data folder
ENDING = ".mcap"
MAX_NAME_LETTERS, MAX_NOTE_LETTERS = 80, 2000
NAME = re.compile(r"[\w][\w .-]*")
NO_NAME = re.compile(r"^[^\w]|[^\w .-]")  # letters of a file of elsewhere that a name cannot have
FILE_BUDGET_S = 120.0  # [s] of processor time
BYTES_PER_MB, BYTES_PER_GB = 1e6, 1e9
NEARLY_FULL = 0.9  # of the folder's largest size: from here on the page says which recording goes next
CUT = Statement("recording.cut")
OLD_GOES, NEXT_GOES = Statement("recording.old_goes"), Statement("recording.next_goes")


class RecordingNote(msgspec.Struct):
    note: str = ""


class RecordingStore(Part):
    """Lives on the event loop. `folder/NAME.mcap` holds a recording; one of another form has its whole name there."""

    def __init__(
        self, home: Path, settings: RecordingSettings, history: History, notifications: Notifications
    ) -> None:
        self.revision = 0  # of the list of recordings
        self.folder, self._notes_file = home / FOLDER, home / NOTES
        self.naming = asyncio.Lock()  # of who chooses a name, until a file has it
        self._settings, self._history, self._notifications = settings, history, notifications
        self._worker = Worker("recorder")  # beside the one that records: to read a file holds up no recording
        self._known: dict[tuple[str, float], work.FinishedRecording] = {}  # by name and time of change
        self._notes: dict[str, RecordingNote] = {}
        self._notes_readable = True  # if not, nobody knows which recordings have a note, and none is deleted
        self._noting, self._making = asyncio.Lock(), asyncio.Lock()  # of who writes the notes; of who makes a file
        self._next_to_go = ""  # name of the recording of which that was said
        self._room_revision = -1  # of the list when the folder's size was looked at

    async def open(self) -> None:
        """Read the notes."""
        self._notes = await asyncio.to_thread(self._read_notes)

    async def close(self) -> None:
        self._worker.kill()
        await self._worker.gone()

    # the list

    async def all(self, running: work.FinishedRecording | None, kept: str) -> list[work.FinishedRecording]:
        """Every recording, the newest first, with the one that runs. `kept`: name of a part that is being kept."""
        found: list[work.FinishedRecording] = []
        for name, changed, size in await asyncio.to_thread(self._sizes):
            one = await self._description(name, changed, size)
            note = self._notes.get(name, RecordingNote(one.note)).note
            cut = {} if one.complete else work.with_cause(CUT)
            found.append(msgspec.structs.replace(one, note=note, file=self.path(name).name, **cut))
        for name, changed, size in await asyncio.to_thread(self.parts):
            if name not in (running and running.name, kept):
                cause = work.with_cause(Statement("recording.recovering"))
                found.append(work.FinishedRecording(name, 0.0, size, {}, changed, complete=False, **cause))
        if running is not None:
            found.append(msgspec.structs.replace(running, **work.with_cause(Statement("recording.records"))))
        return sorted(found, key=lambda one: one.started_s, reverse=True)

    async def _description(self, name: str, changed: float, size: int) -> work.FinishedRecording:
        """Describe a file. It is read once, or again where its reader was not to blame."""
        path, known = self.path(name), self._known.get((name, changed))
        if path.suffix != ENDING:  # its reader judges it when it is opened
            known = work.FinishedRecording(name, 0.0, size, {}, changed)
        if known is not None:
            return known
        try:  # in a process: what a stranger wrote may break its reader
            read = await self._worker.ask(RecorderWorker.read(str(path)), budget=FILE_BUDGET_S)
        except BeckonError as trouble:
            unread = work.with_cause(Statement("recording.unread", trouble=trouble))
            read = work.FinishedRecording(name, 0.0, size, {}, changed, **unread)
            if isinstance(trouble, WorkerLost) and trouble.killed:
                return read
        self._known[name, changed] = read
        return read

    def file(self, name: str) -> Path:
        """The file of a finished recording. Raises Problem 404."""
        path = self.path(name) if NAME.fullmatch(name) else None
        if path is None or not path.is_file():
            raise Problem(404, Statement("recording.unknown"))
        return path

    async def rewrite(self, name: str, note: str | None, new_name: str | None) -> None:
        """Give a recording another note, or another name. Raises BadInput, Problem 404, 409, Unwritable."""
        path = self.file(name)
        if note is not None and len(note) > MAX_NOTE_LETTERS:
            raise BadInput(f"A note has at most {MAX_NOTE_LETTERS} letters.")
        if new_name is not None and (fresh := bare_name(new_name)) != name:
            if path.name == name:  # of another form, which its ending may say
                fresh = fresh if fresh.endswith(path.suffix) else f"{fresh}{path.suffix}"
            ending = "" if path.name == name else ENDING
            async with self.naming:
                path = self.file(name)
                self._check_free(fresh)
                with saving("The recording could not be renamed"):
                    await asyncio.to_thread(path.rename, path.with_name(f"{fresh}{ending}"))
            self.revision += 1
            before = self._notes.pop(name, None)
            note = before.note if note is None and before is not None else note
            name = fresh
        if note is not None:
            await self.set_note(name, note)
        self.revision += 1

    async def delete(self, name: str, who: Person) -> None:
        """Remove a recording. Raises Problem 404, Unwritable."""
        path = self.file(name)
        with saving("The recording could not be deleted"):
            await asyncio.to_thread(path.unlink)
        if self._notes.pop(name, None) is not None:
            await self._save_notes()
        self.revision += 1
        self._history.add("delete_recording", who, words=name)

    # files that are made

    async def picture(self, name: str) -> bytes:
        """A small picture of a finished recording, as a JPEG. Raises Problem 404 where it has none."""
        job = RecorderWorker.picture(str(await asyncio.to_thread(self.file, name)))
        picture = await self._worker.ask(job, budget=FILE_BUDGET_S)
        if not picture:
            raise Problem(404, Statement("recording.no_picture"))
        return picture

    async def film(self, path: Path, begin_s: float, end_s: float, form: FilmForm) -> bytes:
        """A film of a part of a finished recording. Raises BadInput, Unavailable."""
        return await self._worker.ask(RecorderWorker.film(str(path), begin_s, end_s, form), budget=FILE_BUDGET_S)

    async def cut(self, path: Path, begin_s: float, end_s: float, who: Person) -> work.FinishedRecording:
        """Save a part of a finished recording as one of its own. Raises BadInput, Unwritable."""
        await asyncio.to_thread(self.make_folder)
        place = f" {begin_s:.0f}-{end_s:.0f} s"
        async with self._making:
            fresh = self.fresh_name(NO_NAME.sub("-", path.stem)[: MAX_NAME_LETTERS - len(place)] + place)
            job = RecorderWorker.cut(str(path), str(self.path(fresh)), begin_s, end_s)
            done = await self._worker.ask(job, budget=FILE_BUDGET_S)
        await self._keep(done.name, done.note, who)
        return done

    async def take_in(self, file: str, content: bytes, who: Person) -> str:
        """Keep a recording that was made elsewhere, as it came → the name of its file.

        Its reader judges it when it is opened. Raises BadInput, Problem 409, 507, Unwritable.
        """
        path = self.folder / checked_name(file)
        if not content:
            raise BadInput(Statement("recording.empty", name=path.name))

        def write() -> float:
            with saving("The recording could not be kept"):
                with replacing(path, lambda: self._check_free(path.name)) as file:
                    file.write(content)
                return path.stat().st_mtime

        self._check_free(path.name)
        await self._check_room()
        changed, name = await asyncio.to_thread(write), path.name.removesuffix(ENDING)
        self.revision += 1
        await self._keep(name, (await self._description(name, changed, len(content))).note, who, path.name)
        return path.name

    async def sample(self, sample: str, who: Person) -> str:
        """Record a sample, unless it was before → the name of its file. Raises Unwritable, Problem 507."""
        path = self.path(f"sample {sample}")
        async with self._making:
            if not await asyncio.to_thread(path.exists):
                await self._check_room()
                await self._worker.ask(RecorderWorker.sample(sample, str(path)), budget=FILE_BUDGET_S)
                await self._keep(path.stem, "", who)
        return path.name

    async def _keep(self, name: str, note: str, who: Person, words: str = "") -> None:
        """A file was made: keep the note that stands in it, which saves it from being deleted to make room."""
        self.revision += 1
        if note:
            await self.set_note(name, note)
        self._history.add("keep_recording", who, words=words or name)

    # room on the disk

    def free_mb(self) -> float:
        """Free space of the disk [MB]. Raises OSError."""
        return shutil.disk_usage(self.folder).free / BYTES_PER_MB

    async def _check_room(self) -> None:
        """Make the folder. Raises Problem 507 where the disk takes no more."""
        await asyncio.to_thread(self.make_folder)
        free = await asyncio.to_thread(self.free_mb)
        if free < self._settings.free_mb:
            raise Problem(507, Statement("recording.no_room", free=f"{free:.0f}"))

    @property
    def has_changed(self) -> bool:
        """True when the list has changed since `make_room`."""
        return self._room_revision != self.revision

    async def make_room(self) -> None:
        """Delete the oldest files that nobody gave a note while all are too large, and say before which is next."""
        self._room_revision = self.revision
        if not self._notes_readable:
            return
        most, files = BYTES_PER_GB * self._settings.folder_gb, await asyncio.to_thread(self._sizes)
        total = sum(size for _, _, size in [*files, *await asyncio.to_thread(self.parts)])
        for name, _, size in sorted(files, key=lambda one: one[1]):
            if total <= NEARLY_FULL * most:
                return
            if self._notes.get(name, RecordingNote()).note:
                continue
            if total <= most:
                if name != self._next_to_go:
                    self._next_to_go = name
                    self._notifications.tell("warning", NEXT_GOES(name=name), "recorder")
                return
            await asyncio.to_thread(self.path(name).unlink, missing_ok=True)
            self._notifications.tell("warning", OLD_GOES(name=name), "recorder")
            self.revision += 1
            total -= size

    # names

    def path(self, name: str) -> Path:
        """The file of a recording; one of another form than ours has the whole name."""
        whole = self.folder / name
        return whole if whole.suffix != ENDING and whole.is_file() else self.folder / f"{name}{ENDING}"

    def fresh_name(self, wanted: str) -> str:
        """This name, or one like it that is free; "": the date."""
        base = wanted or datetime.now().astimezone().strftime("%Y-%m-%d %H.%M.%S")
        name, number = base, 1
        while self._is_taken(name):
            number += 1
            name = f"{base} {number}"
        return name

    def _is_taken(self, name: str) -> bool:
        names, ends = {name, name.removesuffix(ENDING)}, ("", ENDING, f"{ENDING}{PART}")
        return any((self.folder / f"{one}{end}").exists() for one in names for end in ends)

    def _check_free(self, name: str) -> None:
        """Raises Problem 409 where a recording has this name."""
        if self._is_taken(name):
            raise Problem(409, Statement("recording.taken", name=name))

    def make_folder(self) -> None:
        """Raises Unwritable."""
        with saving("Nothing can be recorded"):
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)

    def _sizes(self, *, parts: bool = False) -> list[tuple[str, float, int]]:
        """Name, time of change [s] and bytes of every finished file, or of those that are still written."""
        found: list[tuple[str, float, int]] = []
        for path in self.folder.glob("[!.]*"):
            with contextlib.suppress(FileNotFoundError):  # deleted or renamed meanwhile
                facts = path.stat()
                if stat.S_ISREG(facts.st_mode) and path.name.endswith(f"{ENDING}{PART}") == parts:
                    name = path.name.removesuffix(PART).removesuffix(ENDING)
                    found.append((name, facts.st_mtime, facts.st_size))
        return found

    def parts(self) -> list[tuple[str, float, int]]:
        """Name, time of change [s] and bytes of every file that is written, or was left half-written."""
        return self._sizes(parts=True)

    # notes

    def _read_notes(self) -> dict[str, RecordingNote]:
        try:
            return msgspec.json.decode(self._notes_file.read_bytes(), type=dict[str, RecordingNote])
        except FileNotFoundError:
            return {}
        except (OSError, msgspec.MsgspecError) as trouble:
            self._notes_readable = False
            self._notifications.tell(
                "warning", f"The notes of the recordings cannot be read, so none is deleted to make room: {trouble}"
            )
            return {}

    async def set_note(self, name: str, note: str) -> None:
        """Keep a note. Raises Unwritable."""
        self._notes[name] = RecordingNote(note)
        await self._save_notes()

    async def _save_notes(self) -> None:
        async with self._noting:
            content = msgspec.json.encode(self._notes)
            with saving("The note could not be saved"):
                await asyncio.to_thread(write_atomic, self._notes_file, content)


def checked_name(name: str) -> str:
    """A name as it is kept. Raises BadInput with what a name may be."""
    tidy = unicodedata.normalize("NFC", " ".join(name.split()))
    if not 0 < len(tidy) <= MAX_NAME_LETTERS or not NAME.fullmatch(tidy):
        raise BadInput(Statement("recording.bad_name", letters=MAX_NAME_LETTERS))
    return tidy


def bare_name(name: str) -> str:
    """A name without the ending of its file. Raises BadInput as `checked_name`."""
    return checked_name(checked_name(name).removesuffix(ENDING))
