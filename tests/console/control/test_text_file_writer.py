"""The writing half of the paper's text files: what it writes, the reading half reads."""

import asyncio
import math
import os
import time
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from console.control.command_freshness import Spoken
from console.control.text_files import SOURCE, SPEECH, TextFileCommand, TextFileReader, TextFileSource, TextFileWriter
from console.options import Options, check
from console.speech.listener import SpokenOutcome
from console.speech.spoken_text_files import SpokenTextFiles
from core.commands import VOCABULARY
from core.errors import BadInput, Unwritable
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.understanding.grammar import Refusal, understand
from tests.console.live import until
from tests.core.speech.ears import sure


@pytest.mark.parametrize("degrees", [0.0, 40.0, -170.0, 200.0])
def test_the_reader_reads_what_the_writer_wrote(tmp_path: Path, degrees: float) -> None:
    writer, reader = TextFileWriter(tmp_path, "--text-files"), TextFileReader(tmp_path)
    source = TextFileSource(azimuth=math.radians(degrees), sd=math.radians(3), age=0.5)
    writer.write(TextFileCommand("come here", age=0.5), source)
    assert sorted(os.listdir(tmp_path)) == [SOURCE, SPEECH]
    reader.look(time.time())
    told, read = reader.look(time.time()), reader.source(time.time())
    assert told is not None and (told.words, told.trouble) == ("come here", "")
    assert 0.5 <= told.age < 1.5
    assert math.remainder(read.azimuth - source.azimuth, math.tau) == pytest.approx(0.0, abs=1e-3)
    assert read.sd == pytest.approx(source.sd)
    writer.write(TextFileCommand("stop moving"), None)
    assert os.listdir(tmp_path) == [SPEECH]  # a direction of other words would be worse than none


def test_a_sign_of_life_never_makes_unread_words_new(tmp_path: Path) -> None:
    writer, speech = TextFileWriter(tmp_path, "--text-files"), tmp_path / SPEECH
    writer.renew()
    assert not speech.exists()
    writer.write(TextFileCommand("follow me", age=5.0), None)
    writer.renew()
    assert time.time() - speech.stat().st_mtime > 4.0
    speech.write_text("")
    os.utime(speech, (0, 0))
    writer.renew()
    assert time.time() - speech.stat().st_mtime < 4.0


def test_a_folder_that_is_gone_is_said(tmp_path: Path) -> None:
    (tmp_path / "exchange").mkdir()
    writer = TextFileWriter(tmp_path / "exchange", "--text-files")
    (tmp_path / "exchange").rmdir()
    with pytest.raises(Unwritable, match="could not be written"):
        writer.write(TextFileCommand("stop moving"), None)


@pytest.mark.parametrize("spec", VOCABULARY, ids=lambda spec: spec.name)
def test_a_command_that_was_heard_is_written_in_words_that_mean_it(spec: Any) -> None:
    said = understand(spec.example, spoken=True)
    assert not isinstance(said, Refusal)
    read = understand(said.heard_as, spoken=True)
    assert not isinstance(read, Refusal)
    assert (read.name, read.numbers) == (said.name, said.numbers)


def test_the_console_writes_what_was_accepted(tmp_path: Path) -> None:
    files = SpokenTextFiles(TextFileWriter(tmp_path, "--write-text-files"), SimpleNamespace())  # type: ignore[arg-type]
    voice: Any = SimpleNamespace(azimuth=math.radians(-20), sd_heard=math.radians(2))

    async def write() -> None:
        task = asyncio.create_task(files.run())
        now = time.monotonic()
        for decision in (replace(sure("turn right"), verdict="confirm"), sure("follow me")):
            utterance = RecognizedUtterance(begin=0.0, end=1.0, decision=decision)
            files.heard(SpokenOutcome(utterance, Spoken(now - 1.0, now)), voice)
        await until(lambda: (tmp_path / SPEECH).exists() and (tmp_path / SOURCE).exists())
        task.cancel()

    asyncio.run(write())
    assert (tmp_path / SPEECH).read_text() == "follow me\n"
    assert (tmp_path / SOURCE).read_text() == "-20.0 2.0\n"


def test_a_robot_does_not_obey_its_own_files(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="another folder"):
        check(Options(text_files=tmp_path, write_text_files=tmp_path / "."))
