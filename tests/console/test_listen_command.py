"""`beckon listen`, and a console that obeys what it writes: two programs joined by a folder (paper 4.2)."""

import asyncio
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.__main__ import main
from console.cli.listen import listen, not_written, take
from console.control.text_file_commands import TextFileCommands
from console.control.text_files import SOURCE, SPEECH, TextFileReader, TextFileWriter
from core.pipelines.listen import HeardSpeech
from core.recording.sound_file import read_sound, write_wav
from core.sensors.microphones import RESPEAKER_ODAS, Sound, load_array
from core.settings import Settings
from core.simulation.acoustics.shoebox import plane_waves
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.settings import PIECE_S, RATE_HZ, SpeechSettings
from core.speech.synthesis import can_speak, speak
from tests.console.live import Live
from tests.core.speech.ears import sure

AZIMUTH = math.radians(40)


def spoken_from(azimuth: float, words: str) -> Sound:
    """A synthetic sentence from `azimuth` [rad], as four microphones hear it in faint noise."""
    from scipy.signal import resample_poly

    sound = speak(words)
    dry = resample_poly(sound.samples[:, 0], RATE_HZ, sound.rate)
    whole = np.concatenate((np.zeros(RATE_HZ), dry, np.zeros(RATE_HZ)))
    towards = np.array([[math.cos(azimuth), math.sin(azimuth), 0.0]])
    heard = plane_waves(whole[None], towards, RESPEAKER_ODAS.positions, RATE_HZ)
    noise = 5e-4 * np.random.default_rng(3).normal(size=heard.shape)
    return Sound(stamp=0.0, rate=RATE_HZ, samples=heard + noise)


TRIES = 3


@pytest.mark.campaign
@pytest.mark.skipif(not can_speak(), reason="the sentence needs the extra voice")
def test_a_console_obeys_what_another_program_hears(live: Live, tmp_path: Path) -> None:
    write_wav(tmp_path / "said.wav", spoken_from(AZIMUTH, "turn left"))
    runtime, files = live.runtime, TextFileReader(tmp_path)
    parts = (runtime.dispatcher, runtime.lease, runtime.history, runtime.notifications)
    task = asyncio.run_coroutine_threadsafe(
        TextFileCommands(files, *parts, lambda: runtime.snapshot).run(), live.loop
    )

    def history() -> list[dict[str, Any]]:
        return live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"]

    before = {row["id"] for row in history()}

    def answered() -> dict[str, Any] | None:
        rows = [row for row in history() if row["id"] not in before and row["source"] == "file"]
        return next(iter(rows), None)

    try:
        settings = replace(Settings(), speech=SpeechSettings(engine="sphinx"))
        writer = TextFileWriter(tmp_path, "--text-files")
        for _ in range(TRIES):  # what a busy computer reads too late is refused, and said again
            listen(read_sound(tmp_path / "said.wav").pieces(PIECE_S), settings, load_array("respeaker-odas"), writer)
            live.until(lambda: (tmp_path / SPEECH).read_text() == "")
            if live.until(answered)["state"] in ("running", "done"):
                break
            before |= {row["id"] for row in history()}
        source = files.source((tmp_path / "source.txt").stat().st_mtime)
        assert source.azimuth == pytest.approx(AZIMUTH, abs=max(3 * source.sd, math.radians(2)))
        [row] = [row for row in history() if row["id"] not in before and row["source"] == "file"]
        assert row["words"] == "turn left" and row["state"] in ("running", "done")
        assert (tmp_path / SPEECH).read_text() == ""
    finally:
        task.cancel()
        live.calm()


def heard(words: str, verdict: str = "accept") -> HeardSpeech:
    decision = replace(sure(words), verdict=verdict)
    return HeardSpeech(utterance=RecognizedUtterance(begin=0.0, end=1.0, decision=decision), voice=None)


def test_only_what_was_accepted_is_written_and_the_rest_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    writer, ahead = TextFileWriter(tmp_path, "--text-files"), time.monotonic() - 1.0
    take(heard("turn left", "confirm"), "words", ahead, writer)
    take(heard("stop"), "stopped", ahead, writer)
    take(heard(""), "words", ahead, writer)
    assert not (tmp_path / SPEECH).exists()
    told = capsys.readouterr().out.splitlines()
    assert len(told) == 2 and all(line.startswith("Not written: ") for line in told)
    take(heard("stop"), "stop", ahead, writer)
    assert (tmp_path / SPEECH).read_text() == "stop moving\n"
    assert not (tmp_path / SOURCE).exists()
    assert "Say it again" in not_written(heard("turn left", "confirm"))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--text-files", "nowhere"], "--text-files nowhere: there is no such folder"),
        (["--text-files", ".", "--from", "nothing.wav"], "There is no file nothing.wav"),
        (["--text-files", ".", "--from", "a.wav", "--say", "stop"], "--say speaks in a simulated room"),
        (["--text-files", ".", "--array", "bat:cave"], "There is no robot of the kind"),
    ],
)
def test_what_cannot_be_listened_to_is_said(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["listen", *arguments]) == 1
    assert sentence in capsys.readouterr().err
