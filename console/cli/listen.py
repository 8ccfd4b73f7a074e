"""`beckon listen`: what microphones hear, written into text files for another program (paper 4.2)."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, tell, write
from core.errors import BadInput

if TYPE_CHECKING:
    from console.control.text_files import TextFileWriter
    from core.pipelines.listen import HeardSpeech, SpeechListener
    from core.robots import Robot
    from core.sensors.microphones import MicrophoneArray, Sound
    from core.settings import Settings

DEFAULT = "audio://default"
LEAD_SILENCE_S = 2.0  # of silence in a simulated room, in which its noise is learnt
LISTEN_AFTER_S = 4.0  # of listening after someone spoke there
SPEAKER_PLACE_M = (1.5, 0.5)  # of who speaks there, in front of the robot and to its left


def add(subcommands: Any) -> None:
    parser = add_command(
        subcommands,
        "listen",
        run,
        "write commands that microphones hear into speech.txt and source.txt, for another program",
        json=False,
    )
    parser.add_argument("--text-files", type=Path, required=True, metavar="DIR", help="the folder to write into")
    parser.add_argument(
        "--array",
        metavar="ARRAY",
        help="the microphones: a robot's URL (audio://ReSpeaker, sim:lab …; default audio://default); "
        "with --from a profile ARRAY.toml or the name of a known board",
    )
    parser.add_argument(
        "--from", dest="recording", type=Path, metavar="SOUND", help="a WAV, FLAC or Ogg file, at its own pace"
    )
    parser.add_argument("--say", metavar="WORDS", help="in a simulated room: someone says this, then listening ends")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml")


def run(chosen: argparse.Namespace) -> int:
    from console.control.text_files import TextFileWriter  # scipy and the recognizer take a moment: only here
    from core.sensors.microphones import load_array
    from core.settings import load

    settings = load(chosen.settings)
    writer = TextFileWriter(chosen.text_files, "--text-files")
    if chosen.recording is not None:
        if chosen.say is not None:
            raise BadInput("--say speaks in a simulated room; leave --from away, or --say.")
        array = None if chosen.array is None else load_array(chosen.array)
        listen(recorded(chosen.recording), settings, array, writer)
        return 0
    from core.robots.connect import connect

    with closing(connect(chosen.array or DEFAULT, settings=settings)) as robot:
        listen(heard_by(robot, chosen.say), settings, robot.profile.microphones, writer)
    return 0


def listen(
    sounds: Iterator[Sound], settings: Settings, array: MicrophoneArray | None, writer: TextFileWriter
) -> None:
    """Read the words of sounds as they come, and write what is understood. Raises BadInput, Unavailable."""
    from console.control.text_files import RENEWAL_S
    from console.speech.listener import SpokenStops
    from core.pipelines.listen import SpeechListener

    listener = SpeechListener(settings, array)
    introduce(listener)
    stops, ahead = SpokenStops(), math.inf  # [s] of the steady clock over the sound's, as the promptest piece came
    renewed = time.monotonic()
    for sound in sounds:
        if time.monotonic() - renewed > RENEWAL_S:
            writer.renew()
            renewed = time.monotonic()
        ahead = min(ahead, time.monotonic() - sound.stamp - sound.duration)
        for speech in listener.feed(sound):
            take(speech, stops.hear(speech.utterance), ahead, writer)
    for speech in listener.finish():
        take(speech, stops.hear(speech.utterance), ahead, writer)


def introduce(listener: SpeechListener) -> None:
    tell(listener.engine.why)
    if not listener.locates:
        tell("Without an array of microphones there are no directions: no source.txt is written.")


def take(speech: HeardSpeech, heard: str, ahead: float, writer: TextFileWriter) -> None:
    """Write one utterance, or say why not; `heard`: what `SpokenStops` makes of it."""
    from console.control.text_files import TextFileCommand, TextFileSource

    decision, voice = speech.utterance.decision, speech.voice
    if heard == "stopped" or (heard == "words" and not speech.utterance.final):
        return
    if decision.command is None or decision.verdict != "accept":
        write(not_written(speech))
        return
    age = max(time.monotonic() - ahead - speech.utterance.end, 0.0)
    source = None if voice is None else TextFileSource(voice.azimuth, voice.sd_heard, age)
    writer.write(TextFileCommand(decision.command.heard_as, age=age), source)
    write(f"{decision.command.heard_as}{from_where(source)}")


def not_written(speech: HeardSpeech) -> str:
    decision = speech.utterance.decision
    if decision.command is None:
        return f"Not written: {decision.reason}"
    return f"Not written: “{decision.echo}” was not heard surely enough. Say it again."


def from_where(source: Any) -> str:
    """A direction in words, to follow the command; "" without one."""
    from core.perception.sound.direction import side

    if source is None:
        return ""
    azimuth, sd = math.degrees(source.azimuth), math.degrees(source.sd)
    return f", {abs(azimuth):.0f}° to the {side(source.azimuth)}, ± {sd:.1f}°"


def recorded(path: Path) -> Iterator[Sound]:
    """A recording in pieces, each when it is due. Raises BadInput."""
    from core.recording.sound_file import read_sound
    from core.speech.settings import PIECE_S

    whole, began = read_sound(path), time.monotonic()
    for piece in whole.pieces(PIECE_S):
        time.sleep(max(began + piece.stamp + piece.duration - time.monotonic(), 0.0))
        yield piece


def heard_by(robot: Robot, say: str | None) -> Iterator[Sound]:
    """Yield the sound of a robot's microphones, in pieces, as time goes on; in a simulated room `say` is said."""
    from core.robots.requests import SetListening, Speak
    from core.sensors.microphones import joined
    from core.speech.settings import MAX_WAITING_S, PIECE_S

    if say is not None and Speak not in robot.requests:
        raise BadInput("Only in a simulated room someone says what --say gives: try --array sim:lab.")
    if SetListening in robot.requests:
        robot.ask(SetListening(on=True))
    due = time.monotonic()
    speaks_at, end = due + LEAD_SILENCE_S, math.inf
    waiting: Sound | None = None
    while due < end:
        if say is not None and due >= speaks_at:
            spoken = robot.ask(Speak(text=say, x_m=SPEAKER_PLACE_M[0], y_m=SPEAKER_PLACE_M[1]))
            speaks_at, end = math.inf, due + spoken.seconds + LISTEN_AFTER_S
        due += 1 / robot.profile.rate
        time.sleep(max(due - time.monotonic(), 0.0))
        waiting = joined(waiting, robot.read().sound, MAX_WAITING_S)
        if waiting is not None and waiting.duration >= PIECE_S:
            yield waiting
            waiting = None
