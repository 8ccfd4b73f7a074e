"""`beckon hear`: directions and words in recordings."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import GrowingJson, add_command, progress, tell, write, write_json

if TYPE_CHECKING:
    from core.pipelines.hear import HeardRecording, HeardUtterance, UnreadRecording


def add(subcommands: Any) -> None:
    parser = add_command(
        subcommands,
        "hear",
        run,
        "where voices are in sound files and recordings (WAV, FLAC, Ogg, MCAP, bags), and what they say",
    )
    parser.add_argument("sounds", nargs="+", type=Path, metavar="SOUND")
    parser.add_argument(
        "--array", metavar="ARRAY.toml", help="the microphones: a profile or the name of a known board"
    )
    parser.add_argument(
        "--channel",
        type=int,
        metavar="N",
        help="the channel in which words are read, from 0 (else: the array's beam, or the first that is used)",
    )
    parser.add_argument("--settings", type=Path, metavar="FILE.toml")


def run(chosen: argparse.Namespace) -> int:
    """Listen, and tell of each file when it was heard. Those that cannot be read are named; exit code 1 when none
    could be.
    """
    from core.pipelines.hear import hear_each  # scipy and the recognizer take a moment: only where they are needed
    from core.sensors.microphones import load_array
    from core.settings import load

    settings = load(chosen.settings)
    array = None if chosen.array is None else load_array(chosen.array)
    with progress() as shown:
        return _answer(chosen, hear_each(chosen.sounds, settings, array, chosen.channel, shown))


def _answer(chosen: argparse.Namespace, heard: Iterator[tuple[str, HeardRecording | UnreadRecording]]) -> int:
    if not chosen.json:
        read = [_written(name, one) for name, one in heard]
        return 0 if any(read) else 1
    if len(chosen.sounds) == 1:
        ((name, one),) = heard
        _warn(name, one)
        write_json(one)
        return 0
    read = False
    with GrowingJson("files") as answer:
        for name, one in heard:
            _warn(name, one)
            answer.add(one, name)
            read |= "error" not in one
    return 0 if read else 1


def _written(name: str, report: HeardRecording | UnreadRecording) -> bool:
    """Print one file's answer for people; return whether it could be read."""
    for line in sentences(name, report):
        write(line)
    return "error" not in report


def _warn(name: str, report: HeardRecording | UnreadRecording) -> None:
    for warning in [report["error"]] if "error" in report else report["warnings"]:
        tell(f"{name}: {warning}")


def sentences(name: str, report: HeardRecording | UnreadRecording) -> list[str]:
    if "error" in report:
        return [f"{name}: {report['error']}"]
    from core.perception.sound.direction import side

    lines = [
        f"{name}: {report['audio_s']:.1f} s in {report['processing_s']:.2f} s, words from the {report['words_from']}"
    ]
    for one in report["directions"]:
        azimuth, sd = math.degrees(one["azimuth_rad"]), math.degrees(one["sd_rad"])
        weak = "" if one["sure"] else " (unsure)"
        where = f"{abs(azimuth):5.1f}° to the {side(one['azimuth_rad'])}, ± {sd:.1f}°{weak}."
        lines.append(f"  {one['t_s']:7.2f} s  {where} {one['ambiguity']}".rstrip())
    for one in report["utterances"]:
        words = f"“{one['words']}”" if one["words"] else "no words"
        lines.append(f"  {one['t0_s']:7.2f} s  {words}: {in_words(one)}")
    return lines + [f"  note: {warning}" for warning in report["warnings"]]


def in_words(utterance: HeardUtterance) -> str:
    """The decision about an utterance, and what else may have been said."""
    meant = utterance["suggestions"] if utterance["verdict"] == "reject" else utterance["alternatives"]
    asked = f" Did you mean {' or '.join(f'“{words}”' for words in meant)}?" if meant else ""
    if utterance["command"] is None:
        return f"{utterance['reason']}{asked}"
    name = str(utterance["command"]["name"])
    return f"{name}, to be confirmed.{asked}" if utterance["verdict"] == "confirm" else name
