"""Every setting at both of its bounds: `python -m tests.benchmarks.settings_bounds [SECTION…]`.

No setting may stop Beckon: the part that a section belongs to runs for a few seconds with one setting at a bound and
the others at their defaults. It must end without a traceback, and not much slower than with the defaults.
"""

import dataclasses
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import cache

import numpy as np

from core.errors import BadInput
from core.experiments.rehearsal import Rehearsal
from core.perception.sound.multi_source import talkers
from core.pilot import Pilot
from core.pilot.sound_perception import SoundPerception
from core.robots import Profile
from core.sensors import SensorFrame
from core.sensors.microphones import RESPEAKER_ODAS
from core.setting import declared_settings
from core.settings import Settings
from core.slam.scan_matching.scan_odometry import ScanOdometry
from core.speech.recognition.recognizer import for_words
from core.speech.settings import RATE_HZ
from core.speech.sphinx.keyword_spotting import BeamformedStop, SphinxKeywordSpotter
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from core.speech.transcription.transcriber import Transcriber
from tests.benchmarks.command import print_row, run_command
from tests.core.perception.voices import far_voice
from tests.core.pilot.test_pilot_hears import standing
from tests.core.speech.ears import mono, padded, pieces

SLOW = 5.0  # times as long as with the defaults, beyond which a setting is reported


def extremes(names: Sequence[str]) -> Iterator[tuple[str, str, float, Settings]]:
    """Section, setting, bound and the settings with it; bounds that need another setting beside them are left out."""
    for section in names:
        default = getattr(Settings(), section)
        for setting in declared_settings(type(default)):
            for bound in (setting.meta.low, setting.meta.high) if setting.kind in (int, float) else ():
                value = setting.fit(int(bound) if setting.kind is int else float(bound))
                try:
                    part = dataclasses.replace(default, **{setting.name: value})
                except BadInput:
                    continue
                yield section, setting.name, bound, dataclasses.replace(Settings(), **{section: part})


@cache
def driven(camera: bool) -> tuple[Profile, list[SensorFrame]]:
    """A robot and its frames on a drive through the lab."""
    simulation = dataclasses.replace(Settings().simulation, camera=camera, camera_rate=2.5, microphones="none")
    rehearsal = Rehearsal(seed=3, settings=dataclasses.replace(Settings(), simulation=simulation))
    frames: list[SensorFrame] = []
    rehearsal.when_stepped.append(frames.append)
    for words in ("continue 0.1 meters", "turn left"):
        number = rehearsal.tell(words)
        while rehearsal.ended(number) is None:
            rehearsal.step()
    return rehearsal.robot.profile, frames


def drive(settings: Settings, camera: bool = False) -> None:
    """The recorded frames through the pilot."""
    profile, frames = driven(camera)
    pilot = Pilot(profile, settings)
    for frame in frames:
        pilot.step(frame)


def look(settings: Settings) -> None:
    """The same with pictures."""
    drive(settings, camera=True)


def rehearse(settings: Settings) -> None:
    """A short drive to a goal and along a wall."""
    rehearsal = Rehearsal(seed=3, settings=settings)
    rehearsal.run(0.5)
    rehearsal.tell("stop at 0.6 and 0.3")
    rehearsal.run(2.0)
    rehearsal.tell("follow the wall")
    rehearsal.run(1.0)


def odometry(settings: Settings) -> None:
    """The recorded scans, laid on each other."""
    profile, frames = driven(False)
    assert profile.laser is not None
    laid = ScanOdometry(profile.laser, settings.scan_odometry)
    for frame in frames:
        if frame.scan is not None:
            laid.update(frame.scan)


def hear(settings: Settings) -> None:
    """A voice through the stream of directions, and as one of two."""
    found = settings.direction_finding
    ears = SoundPerception(Profile(name="ears", url="sim:ears", arrays=(RESPEAKER_ODAS,)), found)
    voice = far_voice(RESPEAKER_ODAS, 0.7, 0.1, duration=1.5)
    for piece in voice.pieces(0.05):
        ears.listen(piece, piece.stamp + piece.duration)
        ears.hear(piece.stamp + piece.duration, standing(0.0))
    talkers(voice, RESPEAKER_ODAS, settings=found)


@cache
def spoken() -> np.ndarray:
    """A command as it is spoken, (N,)."""
    return padded(0.3 * for_words(speak("stop at two and one", VoiceSettings(voice=PERSONS_VOICE))).samples[:, 0])


def words(settings: Settings) -> None:
    """A spoken command through the engine, and STOP spotted in it."""
    chosen = settings.speech
    transcriber = Transcriber(chosen)
    spotter = SphinxKeywordSpotter(chosen)
    for piece in pieces(spoken()):
        transcriber.feed(piece)
        spotter.feed(piece)
    transcriber.finish()
    BeamformedStop(chosen).find(mono(spoken()), len(spoken()) / RATE_HZ - 1.0)


def voice(settings: Settings) -> None:
    """A sentence of the robot."""
    speak("I am there.", settings.voice)


EXERCISES: dict[str, Callable[[Settings], None]] = {
    "edges": look,
    "image_quality": look,
    "drift": look,
    "scan_odometry": odometry,
    "direction_finding": hear,
    "speech": words,
    "voice": voice,
    "planner": rehearse,
    "steering": rehearse,
    "wall": rehearse,
    "simulation": rehearse,
    "limits": rehearse,
}


NOT_EXERCISED = ("person_following", "people", "tracking", "log")
"""Their tests need a person in the room, or a file."""


SECTIONS = tuple(one.name for one in dataclasses.fields(Settings) if one.name not in NOT_EXERCISED)


def main(sections: Sequence[str] = SECTIONS) -> int:
    usual: dict[Callable[[Settings], None], float] = {}
    failed, tried = 0, 0
    for section, name, bound, settings in extremes(sections):
        exercise = EXERCISES.get(section, drive)
        if exercise not in usual:
            exercise(Settings())
            usual[exercise] = _timed(exercise, Settings())
            print_row(f"{exercise.__name__}: {usual[exercise]:.2f} s")
        tried += 1
        try:
            took = _timed(exercise, settings)
        except Exception:
            failed += 1
            print_row(f"FAILED {section}.{name} = {bound:g}: {traceback.format_exc(limit=-3)}")
            continue
        if took > SLOW * max(usual[exercise], 0.1):
            print_row(f"slow {section}.{name} = {bound:g}: {took:.2f} s")
    print_row(f"{tried} tried, {failed} failed")
    return int(failed > 0)


def _timed(exercise: Callable[[Settings], None], settings: Settings) -> float:
    begun = time.process_time()
    exercise(settings)
    return time.process_time() - begun  # others may keep the machine busy


if __name__ == "__main__":
    run_command(main)
