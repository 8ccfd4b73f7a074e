"""Hours of real speech that is no command: `python -m tests.benchmarks.talk FOLDER [--workers 2]`.

FOLDER holds sound files of people who talk, of any form and in any sub-folders: for instance the 619 orders to a
coffee machine of Picovoice's speech-to-intent-benchmark (Apache-2.0, 50 speakers). They pass one after the other
through the whole chain (spotter, endpointer, recognizer) as sound of a room does. Told: hours, pieces, every motion
that would have been obeyed, and every STOP.
"""

import json
import sys
from functools import cache, partial
from pathlib import Path
from typing import Annotated, Any

from core.errors import BadInput
from core.recording.sound_file import read_sound
from core.sensors.microphones import Sound
from core.speech.recognition.engines import ActiveEngine, open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import PIECE_S, RATE_HZ, SpeechSettings
from core.speech.transcription.transcriber import Transcriber
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import run_command
from tests.benchmarks.word_hearing import padded

KINDS = {".wav", ".flac", ".ogg"}
TOGETHER = 10  # files that are read one after the other


@cache
def engine(name: str) -> ActiveEngine:
    """One for all files of a process."""
    return open_engine(SpeechSettings(engine=name))


def listened(files: list[Path], name: str, part: int) -> dict[str, Any]:
    ears = Transcriber(SpeechSettings(engine=name), recognizer=engine(name).recognizer)
    told: dict[str, Any] = {"seconds": 0.0, "pieces": 0, "motions": [], "stops": [], "files": 0}
    for n, path in enumerate(files[part * TOGETHER : (part + 1) * TOGETHER]):
        try:
            samples = padded(for_words(read_sound(path)).samples[:, 0], n)
        except BadInput:
            continue
        told["files"] += 1
        told["seconds"] += len(samples) / RATE_HZ
        sound = Sound(stamp=1000.0 * n, rate=RATE_HZ, samples=samples[:, None])
        heard = [one for piece in sound.pieces(PIECE_S) for one in ears.feed(piece)] + list(ears.finish())
        told["pieces"] += sum(one.final for one in heard)
        for one in heard:
            command = one.decision.command
            if command is not None:
                words = f"{path.name}: {one.decision.words or one.decision.echo} ({one.decision.verdict})"
                told["stops" if one.decision.stops else "motions"].append(words)
    return told


def main(folder: Path, *, engine: Annotated[str, ("whisper", "sphinx")] = "whisper", workers: int = 2) -> object:
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in KINDS)
    parts = -(-len(files) // TOGETHER)

    rows = carried_out(partial(listened, files, engine), parts, workers)
    sys.stderr.writelines(json.dumps(row) + "\n" for row in rows)
    return {
        "engine": engine,
        "files": sum(row["files"] for row in rows),
        "hours": round(sum(row["seconds"] for row in rows) / 3600, 2),
        "pieces": sum(row["pieces"] for row in rows),
        "motions": [one for row in rows for one in row["motions"]],
        "stops": [one for row in rows for one in row["stops"]],
    }


if __name__ == "__main__":
    run_command(main)
