"""The writing half of the paper's text files (4.2): words into speech.txt, their direction into source.txt.

Both are written under another name and renamed, so that no reader sees half of them. The direction comes first: who
reads the words finds it there. Their date is the moment at which the words ended, however long it took to read them.
"""

import contextlib
import math
import os
import time
from pathlib import Path

from console.control.text_file_reader import SOURCE, SPEECH, WIDEST, TextFileCommand, TextFileSource, check_folder
from core.files import replacing, saving

RENEWAL_S = 1.0  # between two signs of life: *follow wall* and *follow me* end without them
LEAST_SD = 0.1  # [degrees] that are written


class TextFileWriter:
    """A folder into which understood words are written."""

    def __init__(self, folder: Path, option: str) -> None:
        """`option`: the one that named the folder. Raises BadInput where it cannot be used."""
        check_folder(option, folder)
        self._folder = folder

    def write(self, said: TextFileCommand, source: TextFileSource | None) -> None:
        """Write words and from where they came; without a direction of use, none is left. Raises Unwritable."""
        with saving(f"{SPEECH} could not be written"):
            self._folder.stat()  # a folder that is gone is not created again
            if source is None or source.sd > WIDEST:
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
