"""The paper's interface by text files (4.2): words in speech.txt, and where they were said in source.txt.

Another program writes them, at best under another name that is then renamed. What it wrote is read whole, obeyed once
and emptied. The direction is only read for the commands that need one.

What is written here goes under another name first, too, so that no reader sees half of it. The direction comes first:
who reads the words finds it there. The date of both is the moment at which the words ended, however long it took to
read them.
"""

import contextlib
import hashlib
import math
import os
import stat
import time
from dataclasses import dataclass, replace
from pathlib import Path

from core.errors import BadInput
from core.files import replacing, saving

SPEECH, SOURCE = "speech.txt", "source.txt"
MAX_WORDS_AGE_S = 2.0  # after which words that were written are those of another situation
MAX_SENTENCE_BYTES = 2000  # bytes of a sentence
MAX_DIRECTION_SD_RAD = math.radians(45)  # of a direction's standard deviation
DEFAULT_BEARING_SD_RAD = math.radians(10)  # of a direction that comes without one
LEAST_SD = 0.1  # [degrees] that are written
RENEWAL_S = 1.0  # between two signs of life: *follow wall* and *follow me* end without them

Mark = tuple[int, int, int]  # inode, size [bytes], changed [ns]


@dataclass(frozen=True)
class TextFileCommand:
    words: str
    trouble: str = ""  # a sentence: why nobody should obey it
    age: float = 0.0  # [s] by the file's date


@dataclass(frozen=True)
class TextFileSource:
    azimuth: float  # [rad] from the robot's front, left is positive
    sd: float  # [rad]
    age: float  # [s] by the file's date


class TextFileReader:
    def __init__(self, folder: Path) -> None:
        """Raises BadInput where there is no such folder or nothing may be written into it."""
        check_folder("--text-files", folder)
        self._speech, self._source = folder / SPEECH, folder / SOURCE
        self.writer_lives = False  # whether another program touched speech.txt since the look before
        self._seen: Mark | None = None
        self._dated = 0  # [ns] the date of speech.txt at the last look
        self._taken = ""  # the words obeyed last: a file that cannot be emptied is not obeyed again

    def look(self, now: float) -> TextFileCommand | None:
        """Words that are whole and new, at `now` [s] of the wall clock; they are emptied from the file."""
        self.writer_lives = False
        try:
            file = os.open(self._speech, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
        except FileNotFoundError:
            self._seen = None
            return None
        except OSError as error:
            return self._once(f"{error.errno}", "", f"{SPEECH} cannot be opened: {error.strerror}.")
        try:
            return self._read(file, now)
        finally:
            os.close(file)

    def source(self, now: float) -> TextFileSource:
        """Return where the words came from, at `now` [s] of the wall clock. Raises BadInput with a sentence."""
        try:
            with open(os.open(self._source, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
                if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                    raise BadInput(f"{SOURCE} is no plain file.")
                words = file.read(MAX_SENTENCE_BYTES).decode("ascii", "replace").replace(",", " ").split()
                age = now - os.fstat(file.fileno()).st_mtime
        except OSError as error:
            raise BadInput(f"{SOURCE} cannot be read: {error.strerror}.") from error
        if abs(age) > MAX_WORDS_AGE_S:
            raise BadInput(
                f"{SOURCE} is not of now, its date is {abs(age):.0f} s off. Write it together with {SPEECH}."
            )
        try:
            azimuth, sd = [math.radians(float(word)) for word in words] + [DEFAULT_BEARING_SD_RAD] * (len(words) == 1)
        except ValueError:
            azimuth = sd = math.nan
        if not (abs(azimuth) <= math.tau and 0.0 < sd <= MAX_DIRECTION_SD_RAD):
            raise BadInput(
                f"{SOURCE} must hold one direction in degrees from the robot's front, left positive, and, if known,"
                f" its standard deviation of at most {math.degrees(MAX_DIRECTION_SD_RAD):.0f}."
            )
        return TextFileSource(math.remainder(azimuth, math.tau), sd, max(age, 0.0))

    def _read(self, file: int, now: float) -> TextFileCommand | None:
        mark = mark_of(file)
        if os.fstat(file).st_nlink > 1:
            trouble = f"{SPEECH} has another name as well (a hard link), so it is neither read nor emptied."
            return self._once(f"linked {mark[2]}", "", trouble)
        self.writer_lives, self._dated = mark[2] != self._dated, mark[2]
        whole, self._seen = mark == self._seen, mark
        if not mark[1] or not whole:
            return None
        content = os.read(file, MAX_SENTENCE_BYTES + 1)
        if mark_of(file) != mark:
            return None
        name = f"{hashlib.sha256(content).hexdigest()} {mark[2]}"
        age = now - mark[2] * 1e-9
        found = self._once(name, *judge(content, age))
        os.ftruncate(file, 0)
        self._seen, self._dated = None, mark_of(file)[2]
        return None if found is None else replace(found, age=max(age, 0.0))

    def _once(self, name: str, words: str, trouble: str) -> TextFileCommand | None:
        if name == self._taken:
            return None
        self._taken = name
        return TextFileCommand(words, trouble) if words or trouble else None


def check_folder(option: str, folder: Path) -> None:
    """Raises BadInput where an option names no folder, or one in which nothing may be written."""
    if not folder.is_dir():
        raise BadInput(f"{option} {folder}: there is no such folder. Make it, then start again.")
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise BadInput(f"{option} {folder}: this folder must be readable and writable.")


def judge(content: bytes, age: float) -> tuple[str, str]:
    """A file's content and age [s] → its words, and a sentence on why they must not be obeyed."""
    if len(content) > MAX_SENTENCE_BYTES:
        return "", f"{SPEECH} was longer than a sentence and is emptied."
    try:
        words = " ".join(content.decode("utf-8-sig").split())
    except UnicodeDecodeError:
        return "", f"{SPEECH} was no text and is emptied."
    if words and abs(age) > MAX_WORDS_AGE_S:
        return words, f"{SPEECH} held words that are not of now; they are deleted."
    return words, ""


def mark_of(file: int) -> Mark:
    """Return a mark that changes with every write to an open file; 0 bytes for a file that is no file of words."""
    status = os.fstat(file)
    return status.st_ino, status.st_size if stat.S_ISREG(status.st_mode) else 0, status.st_mtime_ns


class TextFileWriter:
    def __init__(self, folder: Path, option: str) -> None:
        """`option`: the one that named the folder. Raises BadInput where it cannot be used."""
        check_folder(option, folder)
        self._folder = folder

    def write(self, said: TextFileCommand, source: TextFileSource | None) -> None:
        """Write words and from where they came; without a direction of use, none is left. Raises Unwritable."""
        with saving(f"{SPEECH} could not be written"):
            self._folder.stat()  # a folder that is gone is not created again
            if source is None or source.sd > MAX_DIRECTION_SD_RAD:
                (self._folder / SOURCE).unlink(missing_ok=True)
            else:
                sd = max(math.degrees(source.sd), LEAST_SD)
                azimuth = math.degrees(math.remainder(source.azimuth, math.tau))
                self._replace(SOURCE, f"{azimuth:.1f} {sd:.1f}\n", source.age)
            self._replace(SPEECH, f"{said.words}\n", said.age)

    def renew(self) -> None:
        """Give a sign of life: the date of a speech.txt that was read, and so is empty, is now."""
        with contextlib.suppress(OSError):
            if not (self._folder / SPEECH).stat().st_size:
                os.utime(self._folder / SPEECH)

    def _replace(self, name: str, text: str, age: float) -> None:
        with replacing(self._folder / name) as file:
            file.write(text.encode())
            file.flush()
            dated = time.time_ns() - round(age * 1e9)
            os.utime(file.fileno(), ns=(dated, dated))
