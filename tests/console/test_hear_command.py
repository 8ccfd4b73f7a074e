"""`beckon hear`: directions and words of files, and a sentence for whatever is missing or wrong."""

import importlib.util
import json
import math
import re
import signal
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from console.__main__ import main
from console.cli.hear import in_words
from core.pipelines.hear import HeardRecording, RecordingTranscriber, first_heard, unbroken
from core.progress import UNSEEN, WorkProgress
from core.recording.mcap_writing import McapRecording
from core.recording.ros_writing import RosEncoder
from core.recording.sound_file import read_sound, write_wav
from core.sensors import SensorFrame
from core.sensors.microphones import RESPEAKER_ODAS, Sound
from core.simulation.acoustics.shoebox import plane_waves
from core.speech.practice_voice import practice_voice
from tests.core.recording.log_writers import robot_messages, two
from tests.core.recording.log_writers import write_mcap as write_plain_mcap

RATE = 16_000
AZIMUTH = math.radians(40)
words = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None, reason="words need pocketsphinx: pip install pocketsphinx"
)


def recorded(path: Path, rate: int = RATE, channels: int = 4) -> str:
    """A made-up voice from 40° after half a second of faint noise."""
    rng = np.random.default_rng(7)
    dry = np.concatenate((np.zeros(rate // 2), 0.05 * practice_voice(rng, 1.2, rate), np.zeros(rate // 2)))
    towards = np.array([[math.cos(AZIMUTH), math.sin(AZIMUTH), 0.0]])
    heard = plane_waves(dry[None], towards, RESPEAKER_ODAS.positions, rate)
    heard = heard + 5e-4 * rng.normal(size=heard.shape)
    write_wav(path, Sound(stamp=0.0, rate=rate, samples=heard[:, :channels]))
    return str(path)


def hear(*arguments: str) -> int:
    return main(["hear", *arguments])


def locate(file: str, *arguments: str, array: str = "respeaker-odas") -> int:
    """Directions alone: an engine without its model is no trouble there, and quicker than words."""
    settings = Path(file).with_name("wordless.toml")
    settings.write_text('[speech]\nmodel = "/nowhere/absent"\n')
    return hear(file, *arguments, "--settings", str(settings), "--array", array)


def answer(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    out = capsys.readouterr().out
    assert out.count("\n") == 1
    return json.loads(out)


def test_the_direction_of_a_voice_is_told_with_its_doubt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert locate(recorded(tmp_path / "a.wav"), "--json") == 0
    told = answer(capsys)
    (one,) = told["directions"]
    assert one["azimuth_rad"] == pytest.approx(AZIMUTH, abs=0.02)
    assert 0 < one["sd_rad"] < 0.1
    assert 0.5 < one["t_s"] < 1.8
    assert told["audio_s"] == pytest.approx(2.2)
    assert told["processing_s"] > 0
    assert one["elevation_ambiguous"] and one["ambiguity"] == ""  # above or below the array's level by less than 1 sd
    assert told["words_from"] == "beam"
    assert locate(str(tmp_path / "a.wav"), "--json", "--channel", "2") == 0
    assert answer(capsys)["words_from"] == "channel 2"


def test_several_files_are_one_object_and_a_bad_one_does_not_spoil_the_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "b.wav").write_bytes(b"RIFF\0\0\0\0WAVE")
    files = [recorded(tmp_path / "a.wav"), str(tmp_path / "b.wav")]
    assert locate(*files, "--json") == 0
    told = answer(capsys)["files"]
    assert list(told) == ["a.wav", "b.wav"]
    assert told["a.wav"]["directions"]
    assert "no samples" in told["b.wav"]["error"]


@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, lambda: signal.raise_signal(signal.SIGTERM)])
def test_each_file_is_told_when_it_was_heard_and_an_interrupted_batch_keeps_what_was_done(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    interrupt: Callable[[], object],
) -> None:
    printed: list[str] = []
    files = [recorded(tmp_path / f"{name}.wav") for name in "ab"]

    def hear_one(
        self: RecordingTranscriber, path: Path, channel: int | None = None, progress: WorkProgress = UNSEEN
    ) -> HeardRecording:
        printed.append(capsys.readouterr().out)
        if len(printed) == 2:
            error = interrupt()
            if isinstance(error, BaseException):
                raise error
        return heard(self, path, channel, progress)

    heard = RecordingTranscriber.hear
    monkeypatch.setattr(RecordingTranscriber, "hear", hear_one)
    assert locate(*files, "--json") == 130
    assert '"a.wav": {"directions"' in printed[1]
    told = json.loads("".join((*printed, capsys.readouterr().out)))["files"]
    assert list(told) == ["a.wav"] and told["a.wav"]["audio_s"] == pytest.approx(2.2)
    printed.clear()
    if interrupt is KeyboardInterrupt:
        assert locate(*files) == 130 and printed[1].startswith("a.wav: 2.2 s")


def test_an_array_profile_from_a_file_is_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "array.toml"
    turned = [[y, -x, z] for x, y, z in RESPEAKER_ODAS.positions.tolist()]
    profile.write_text(f"positions_m = {turned}\n")
    assert locate(recorded(tmp_path / "a.wav"), "--json", array=str(profile)) == 0
    assert answer(capsys)["directions"][0]["azimuth_rad"] == pytest.approx(AZIMUTH - math.pi / 2, abs=0.02)


def test_identical_channels_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path / "a.wav")
    from core.recording.sound_file import read_sound

    samples = read_sound(tmp_path / "a.wav").samples[:, [0, 1, 1, 3]]
    write_wav(tmp_path / "b.wav", Sound(stamp=0.0, rate=RATE, samples=samples))
    assert locate(str(tmp_path / "b.wav"), "--json") == 0
    told = answer(capsys)
    assert any("2 and 3 are identical" in one for one in told["warnings"])
    assert told["words_from"] == "channel 0"  # a beam of such channels would be none


@pytest.mark.parametrize(
    ("levels", "channel"), [((1, 1), 0), ((0, 1), 1), ((0.01, 0, 1), 2), ((0.5, 1), 0), ((0, 0), 0)]
)
def test_without_an_array_the_first_channel_that_is_used_is_read(levels: tuple[float, ...], channel: int) -> None:
    noise = np.random.default_rng(0).normal(size=(RATE, len(levels)))
    assert first_heard(Sound(stamp=0.0, rate=RATE, samples=noise * levels)) == channel
    assert first_heard(Sound(stamp=0.0, rate=RATE, samples=noise[:0])) == 0


@pytest.mark.campaign
@words
def test_a_mono_file_without_an_array_gives_words_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hear(recorded(tmp_path / "a.wav", channels=1), "--json") == 0
    told = answer(capsys)
    assert told["directions"] == []
    assert told["utterances"]
    assert all(not one["accepted"] and one["reason"] for one in told["utterances"])
    assert {one["verdict"] for one in told["utterances"]} == {"reject"}
    assert all(0 <= one["confidence"] < 0.5 and one["alternatives"] == [] for one in told["utterances"])
    assert told["engine"].startswith(("Whisper reads the words", "pocketsphinx reads the words"))


@pytest.mark.parametrize(
    ("verdict", "meant", "line"),
    [
        ("accept", (), "continue"),
        ("accept", ("continue 3 meters",), "continue"),
        ("confirm", ("continue 3 meters",), "continue, to be confirmed. Did you mean “continue 3 meters”?"),
        ("confirm", (), "continue, to be confirmed."),
        ("reject", ("turn left", "turn right"), "Not sure. Did you mean “turn left” or “turn right”?"),
        ("reject", (), "Not sure."),
    ],
)
def test_a_decision_is_written_as_a_sentence(verdict: str, meant: tuple[str, ...], line: str) -> None:
    rejected = verdict == "reject"
    utterance = {
        "verdict": verdict,
        "command": None if rejected else {"name": "continue", "distance_m": 2.0},
        "reason": "Not sure." if rejected else "",
        "alternatives": list(meant),
        "suggestions": list(meant) if rejected else [],
    }
    assert in_words(utterance) == line


def test_eight_kilohertz_are_enough(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert locate(recorded(tmp_path / "a.wav", rate=8_000), "--json") == 0
    assert answer(capsys)["directions"][0]["azimuth_rad"] == pytest.approx(AZIMUTH, abs=0.05)


def lying(path: Path, at: int, form: str, value: int) -> str:
    """A sound file whose header says something else in one field."""
    raw = bytearray(Path(recorded(path)).read_bytes())
    struct.pack_into(form, raw, at, value)
    path.write_bytes(bytes(raw))
    return str(path)


@pytest.mark.parametrize(
    ("at", "form", "value", "sentence"),
    [
        (22, "<H", 0, "0 channels"),
        (22, "<H", 3, "its header is wrong"),
        (24, "<I", 1, "1 Hz"),
        (24, "<I", 48_000, "its header is wrong"),
        (34, "<H", 13, "13 bits"),
    ],
)
def test_a_lying_header_is_found_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], at: int, form: str, value: int, sentence: str
) -> None:
    assert locate(lying(tmp_path / "a.wav", at, form, value)) == 1
    told = capsys.readouterr()
    assert sentence in told.err
    assert told.out == ""


def test_a_header_that_promises_more_than_there_is_is_not_believed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert locate(lying(tmp_path / "a.wav", 40, "<I", 2**31), "--json") == 0
    assert answer(capsys)["audio_s"] == pytest.approx(2.2)


@pytest.mark.parametrize(
    ("channels", "array", "sentence"),
    [
        (1, "respeaker-odas", "has 1 channel"),
        (4, "ring-6", "wants channel 5"),
        (4, "nowhere.toml", "nowhere.toml cannot be read"),
    ],
)
def test_an_array_that_does_not_fit_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], channels: int, array: str, sentence: str
) -> None:
    assert locate(recorded(tmp_path / "a.wav", channels=channels), array=array) == 1
    assert sentence in capsys.readouterr().err


def test_a_recognizer_that_is_absent_is_told_and_directions_come_all_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = tmp_path / "own.toml"
    settings.write_text('[speech]\nmodel = "/nowhere/absent"\n')
    file = recorded(tmp_path / "a.wav")
    assert hear(file, "--settings", str(settings)) == 1
    assert "absent" in capsys.readouterr().err
    assert hear(file, "--settings", str(settings), "--array", "respeaker-odas", "--json") == 0
    told = answer(capsys)
    assert told["directions"]
    assert any("'absent' of [speech] model is not there" in one for one in told["warnings"])


def test_a_file_that_is_no_sound_or_not_there_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.wav").write_text("turn left")
    assert locate(str(tmp_path / "a.wav")) == 1
    assert "neither WAV, FLAC nor Ogg" in capsys.readouterr().err
    assert locate(str(tmp_path / "b.wav")) == 1
    assert "b.wav" in capsys.readouterr().err


def test_for_people_it_speaks_in_degrees(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert locate(recorded(tmp_path / "a.wav")) == 0
    assert re.search(r" 40\.\d° to the left, ± \d\.\d°\.", capsys.readouterr().out)


def test_a_recording_is_heard_as_the_same_sound_in_a_file_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = recorded(tmp_path / "sound.wav")
    assert locate(file, "--json") == 0
    alone = answer(capsys)
    sound = read_sound(file)
    recording, encoder = McapRecording(tmp_path / "drive.mcap"), RosEncoder()
    for piece in sound.pieces(0.05):
        block = replace(piece, stamp=1000.0 + piece.stamp)
        recording.add(encoder.readings(SensorFrame(stamp=block.newest, sound=block)), block.newest)
    recording.finish()
    assert locate(str(tmp_path / "drive.mcap"), "--json") == 0
    told = answer(capsys)
    assert told["channels"] == 4 and told["sample_rate_hz"] == RATE and told["directions"]
    assert told["audio_s"] == pytest.approx(alone["audio_s"])
    for one, same in zip(told["directions"], alone["directions"], strict=True):
        assert one["t_s"] == pytest.approx(same["t_s"]) and one["azimuth_rad"] == pytest.approx(same["azimuth_rad"])
    write_plain_mcap(tmp_path / "mute.mcap", robot_messages(two, scans=2))
    assert locate(str(tmp_path / "mute.mcap")) == 1
    assert "mute.mcap holds no sound that can be read." in capsys.readouterr().err


@pytest.mark.parametrize("channel", [-1, 4, 99])
@pytest.mark.parametrize("with_array", [False, True])
def test_a_channel_that_the_sound_has_not_is_told(
    channel: int, with_array: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = recorded(tmp_path / "voice.wav")
    told = hear(file, "--channel", str(channel), *(("--array", "respeaker-odas") if with_array else ()))
    assert told == 1
    assert (
        f"The sound has 4 channel(s); channel {channel}, counted from 0, is none of them." in capsys.readouterr().err
    )


def test_a_file_that_was_cut_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(recorded(tmp_path / "voice.wav"))
    for kept, codes in ((1.0, []), (0.7, ["sound.cut"])):
        file.write_bytes(file.read_bytes()[: round(kept * file.stat().st_size)])
        assert hear("--json", str(file)) == 0
        told = json.loads(capsys.readouterr().out)
        assert [one["code"] for one in told["faults"]] == codes


def told_as(samples: np.ndarray, held: str, told: str) -> np.ndarray:
    """Samples in full scale that were written as one kind of number and are read as another."""
    full = {"<i2": 2**15, "<i4": 2**31, "i1": 2**7, "u1": 2**7}
    numbers = samples if held == "<f4" else samples * (full[held] - 1) + (128 if held == "u1" else 0)
    read = np.frombuffer(numbers.astype(held).tobytes(), told).astype(float)
    return (read - (128 if told == "u1" else 0)) / full[told]


@pytest.mark.parametrize(
    ("held", "told", "wrong"),
    [
        ("<i2", "<i2", False),
        ("u1", "u1", False),
        ("u1", "<i2", True),
        ("i1", "u1", True),
        ("u1", "i1", True),
        ("<f4", "<i4", True),
    ],
)
def test_samples_of_another_kind_than_the_header_says_are_told(
    held: str, told: str, wrong: bool, tmp_path: Path
) -> None:
    voice = read_sound(recorded(tmp_path / "voice.wav", channels=1))
    samples = told_as(voice.samples[:, 0], held, told)
    found = unbroken(replace(voice, samples=samples.reshape(-1, 1)))
    assert [one.code for one in found] == ["sound.unbroken"] * wrong


def test_speech_that_is_clipped_is_not_loud_all_the_time(tmp_path: Path) -> None:
    voice = read_sound(recorded(tmp_path / "voice.wav", channels=1))
    assert not unbroken(replace(voice, samples=np.clip(50 * voice.samples, -1, 1)))
