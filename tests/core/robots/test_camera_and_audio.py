"""Cameras and microphones of this computer, by films, recordings and a sound card that a test plays."""

import sys
import threading
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.recording.sound_file import write_wav
from core.robots.live import LiveRobot
from core.robots.readings import Readings
from core.robots.usb_audio import MAX_CLOCK_ERROR_S, SampleClock, SoundDevice, open_device, play_and_record
from core.robots.usb_camera import VideoCamera, parse_address
from core.sensors import SensorFrame
from core.sensors.microphones import Sound
from tests.core.robots.links import no_leak, shape


@pytest.fixture
def film(tmp_path: Path) -> Path:
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (160, 120))
    for number in range(20):
        writer.write(np.full((120, 160, 3), 10 * number, np.uint8))
    writer.release()
    return path


def frames(robot: LiveRobot, seconds: float) -> list[SensorFrame]:
    end, read = time.monotonic() + seconds, list[SensorFrame]()
    while time.monotonic() < end:
        read.append(robot.read())
        time.sleep(0.01)
    return read


def test_a_film_is_a_camera_that_goes_on_for_ever(film: Path) -> None:
    with no_leak():
        robot = LiveRobot([("the camera", VideoCamera(f"//{film}?rate=20"))], shape)
        images = [frame.image for frame in frames(robot, 1.6) if frame.image is not None]
        camera = robot.profile.camera
        robot.close()
        time.sleep(0.2)
    assert camera is not None and (camera.model.width, camera.model.height, camera.rate) == (160, 120, 20.0)
    assert 15 < len(images) < 40
    assert min(after.stamp - before.stamp for before, after in pairwise(images)) > 0


@pytest.mark.parametrize(
    ("address", "source"),
    [
        ("//0", 0),
        ("//rtsp/robot:554/live?x=1&rate=5", "rtsp://robot:554/live?x=1"),
        ("//http/r/a.mjpg", "http://r/a.mjpg"),
    ],
)
def test_what_opencv_opens(address: str, source: int | str) -> None:
    assert parse_address(address)[0] == source


@pytest.mark.parametrize("address", ["", "//", "///no/film.mp4", "//0?rate=0", "//0?rate=x", "//0?speed=1"])
def test_a_camera_that_cannot_be_is_a_sentence(address: str) -> None:
    with pytest.raises(BadInput) as told:
        VideoCamera(address)
    assert str(told.value).endswith(".")


def test_a_recording_stands_in_for_the_microphones(tmp_path: Path) -> None:
    path = tmp_path / "talk.wav"
    samples = np.linspace(-0.5, 0.5, 8000)[:, None] * np.ones(4)
    write_wav(path, Sound(stamp=0.0, rate=16_000, samples=samples))
    with no_leak():
        robot = LiveRobot([("the microphones", open_device(f"//{path}?array=respeaker-odas"))], shape)
        sounds = [frame.sound for frame in frames(robot, 0.8) if frame.sound is not None]
        robot.close()
    assert sum(sound.duration for sound in sounds) == pytest.approx(0.8, abs=0.15)
    ends = [sound.stamp + sound.duration for sound in sounds]
    assert np.allclose(ends[:-1], [sound.stamp for sound in sounds[1:]], atol=1e-6)


class Card:
    """A sound card that counts."""

    PortAudioError = RuntimeError

    def __init__(self, given: dict[str, Any]) -> None:
        self.given, self.closed = given, threading.Event()

    def start(self) -> None:
        def play() -> None:
            block = np.full((self.given["blocksize"], self.given["channels"]), 1000, np.int16)
            while not self.closed.wait(0.02):
                self.given["callback"](block, len(block), None, None)

        threading.Thread(target=play, daemon=True).start()

    def abort(self) -> None:
        self.closed.set()

    def close(self) -> None:
        self.closed.set()


def test_a_respeaker_has_its_raw_channels_and_its_geometry(monkeypatch: pytest.MonkeyPatch) -> None:
    cards: list[Card] = []

    def stream(**given: Any) -> Card:
        cards.append(Card(given))
        return cards[-1]

    monkeypatch.setitem(sys.modules, "sounddevice", SimpleNamespace(InputStream=stream, PortAudioError=RuntimeError))
    device, readings = SoundDevice("//ReSpeaker 4 Mic Array"), Readings()
    (array,) = device.open().microphones
    assert array.channels == (1, 2, 3, 4) and (cards[0].given["channels"], cards[0].given["samplerate"]) == (
        6,
        16_000,
    )
    running = threading.Thread(target=device.run, args=(readings,))
    running.start()
    time.sleep(0.3)
    device.close()
    running.join(3)
    sound = readings.frame().sound
    assert not running.is_alive() and sound is not None and sound.channels == 6
    assert array.heard(sound).shape[1] == 4 and 0.1 < sound.duration < 0.5


@pytest.mark.parametrize("drift", [-1e-3, 0.0, 5e-5, 1e-3])
def test_stamps_follow_each_other_and_never_leave_the_clock(drift: float) -> None:
    """A card that runs fast or slow, blocks that come up to 0.1 s late, a second that is lost."""
    rng, clock, length, stamps, errors = np.random.default_rng(3), SampleClock(), 0.1, list[float](), list[float]()
    for number in range(3000):
        lost = 1.0 if number > 1500 else 0.0
        begin = 5.0 + number * length * (1 + drift) + lost
        delay = 0.01 if number % 20 == 0 else float(rng.uniform(0.01, 0.1))
        stamps.append(clock.stamp(length, begin + length + delay))
        errors.append(abs(stamps[-1] - begin))
    steps = [number for number, (one, other) in enumerate(pairwise(stamps)) if abs(other - one - length) > 1e-9]
    assert max(errors[:1500] + errors[1700:]) < MAX_CLOCK_ERROR_S + 0.12
    assert np.median(errors) < MAX_CLOCK_ERROR_S + 0.01
    assert len(steps) == (1 if abs(drift) < 1e-4 else pytest.approx(1 + 300 * abs(drift) / MAX_CLOCK_ERROR_S, abs=2))


def test_a_missing_package_and_a_missing_library_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(Unavailable, match=r"extra hardware"):
        SoundDevice("//default").open()

    def no_library(_: str) -> Any:
        raise OSError("PortAudio library not found")

    monkeypatch.setattr("core.robots.usb_audio.importlib", SimpleNamespace(import_module=no_library))
    with pytest.raises(Unavailable, match="libportaudio2"):
        SoundDevice("//default").open()


@pytest.mark.parametrize(
    "address", ["//", "//card?loud=1", "//card?channels=many", "///no/talk.wav", "//card?array=x"]
)
def test_microphones_that_cannot_be_are_a_sentence(address: str) -> None:
    with pytest.raises(BadInput) as told:
        open_device(address)
    assert str(told.value).endswith(".")


def test_a_sound_is_played_and_recorded_at_the_named_cards(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[object] = []

    def playrec(samples: np.ndarray, rate: int, **how: object) -> np.ndarray:
        asked.append((samples.shape, rate, how["device"]))
        if how["device"] == ("absent", None):
            raise ValueError("No input device matching 'absent'")
        return 0.5 * samples

    card = SimpleNamespace(playrec=playrec, PortAudioError=RuntimeError)
    monkeypatch.setitem(sys.modules, "sounddevice", card)
    heard = play_and_record(np.ones(800), 16_000, "7", "Speaker")
    assert asked == [((800, 1), 16_000, (7, "Speaker"))]
    assert heard.shape == (800,) and np.all(heard == 0.5)
    with pytest.raises(Unavailable, match="cannot be used: No input device"):
        play_and_record(np.ones(800), 16_000, "absent")
