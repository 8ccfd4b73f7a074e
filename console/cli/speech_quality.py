"""`beckon speech-quality`: how well speech survives the robot's hearing (eq. 41-42), as figures and as a page."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, add_out, answer, plain, tell
from console.cli.experiment import seed
from core.errors import BadInput, BeckonError
from core.files import text_of

if TYPE_CHECKING:
    from core.experiments.speech_loop import LoopResult
    from core.speech.quality.audio_similarity import AudioSimilarity, SimilarityFigures
    from core.speech.quality.marked_text import MarkedFigures
    from core.speech.quality.osqe import QualityFigures, SpeechQuality

MAX_TEXT_BYTES = 4_000_000  # of a text


@dataclass(frozen=True)
class SpeechReport:
    texts: MarkedFigures | QualityFigures | None
    audio: SimilarityFigures | None = None
    files: Mapping[str, str] = field(default_factory=dict[str, str])

    def to_dict(self) -> dict[str, object]:
        return {**(self.texts or {}), **({} if self.audio is None else {"audio": self.audio})}


def add(subcommands: Any) -> None:
    parser = add_command(
        subcommands,
        "speech-quality",
        run,
        "how well speech survives the robot's hearing: OSQE and measures of the sound",
    )
    parser.add_argument("--original", type=Path, metavar="A.txt", help="the text that was spoken")
    parser.add_argument("--person", type=Path, metavar="STT.txt", help="what the person's path wrote down")
    parser.add_argument("--robot", type=Path, metavar="REV_STT.txt", help="what the robot heard")
    parser.add_argument("--marked", action="store_true", help="count the words between =equal signs= instead")
    parser.add_argument("--orig-wav", type=Path, metavar="ORIG.wav", help="the sound that was spoken")
    parser.add_argument("--rev-wav", type=Path, metavar="REV.wav", help="the sound that was received")
    live = parser.add_argument_group("live", "play sentences and record them, in the room as it is")
    live.add_argument("--live", action="store_true", help="play at a loudspeaker, record with a microphone, compare")
    live.add_argument("--text", type=Path, metavar="TEXT.txt", help="what is said, a phrase a line; else commands")
    live.add_argument("--seed", type=seed, default=0, help="draws the voices (default 0)")
    live.add_argument("--microphone", default="", metavar="NAME", help="part of a sound card's name, or its number")
    live.add_argument("--loudspeaker", default="", metavar="NAME", help="the same")
    live.add_argument("--browser", action="store_true", help="a browser on this computer plays and records instead")
    add_out(parser, "where report page, figures, recordings and texts go")


def run(chosen: argparse.Namespace) -> int:
    way = lived if chosen.live else marked if chosen.marked else compared
    report = way(chosen)
    return answer(chosen, {**report.to_dict(), "files": report.files}, *sentences(report))


def marked(chosen: argparse.Namespace) -> SpeechReport:
    """Texts in which a person has marked the erroneous words."""
    from core.speech.quality.marked_text import as_json

    if chosen.person is None or chosen.robot is None:
        raise BadInput("Give both marked texts: --person and --robot.")
    report = SpeechReport(as_json(read_text(chosen.person), read_text(chosen.robot)))
    return replace(report, files=save(chosen.out, report, None))


def compared(chosen: argparse.Namespace) -> SpeechReport:
    """The texts word by word, the recordings by their measures, or both."""
    from core.speech.quality import osqe as texts
    from core.speech.quality.report import page

    quality, similarity = of_texts(chosen), of_sounds(chosen)
    if quality is None and similarity is None:
        raise BadInput(
            "Give the three texts (--original, --person, --robot), two recordings (--orig-wav, --rev-wav)."
        )
    report = SpeechReport(
        None if quality is None else texts.as_json(quality), None if similarity is None else similarity.figures
    )
    return replace(report, files=save(chosen.out, report, page(quality, similarity)))


def lived(chosen: argparse.Namespace) -> SpeechReport:
    """Sentences that are played and recorded now. Raises Unavailable with what is missing."""
    from core.experiments.live_speech_loop import LiveSpeechLoop
    from core.experiments.speech_loop import RATE_HZ
    from core.robots.usb_audio import play_and_record

    loop = LiveSpeechLoop("" if chosen.text is None else read_text(chosen.text), seed=chosen.seed)
    if not chosen.browser:
        tell(f"Playing {len(loop.played) / RATE_HZ:.0f} s of sentences and recording them…")
        result = loop.through(lambda played: play_and_record(played, RATE_HZ, chosen.microphone, chosen.loudspeaker))
        return _of_loop(chosen.out, result)
    from console.cli.browser_loop import BrowserLoop

    with BrowserLoop(loop.played, RATE_HZ) as page:
        tell(f"Open this page in a browser on this computer and press its button: {page.address}")
        try:
            report = _of_loop(chosen.out, loop.compared(page.recorded()))
        except BeckonError as trouble:
            page.tell([str(trouble)])
            raise
        page.tell(sentences(report))
    return report


def _of_loop(out: Path | None, result: LoopResult) -> SpeechReport:
    from core.experiments.speech_loop import save_loop
    from core.speech.quality import osqe as texts
    from core.speech.quality.report import page

    report = SpeechReport(texts.as_json(result.quality), result.similarity.figures)
    files = {} if out is None else save_loop(out, result)
    return replace(report, files={**files, **save(out, report, page(result.quality, result.similarity))})


def of_texts(chosen: argparse.Namespace) -> SpeechQuality | None:
    from core.speech.quality.osqe import compare

    given = (chosen.original, chosen.person, chosen.robot)
    if all(one is None for one in given):
        return None
    if any(one is None for one in given):
        raise BadInput("Three texts belong together: --original, --person and --robot.")
    original, person, robot = map(read_text, given)
    return compare(original, person, robot)


def of_sounds(chosen: argparse.Namespace) -> AudioSimilarity | None:
    if chosen.orig_wav is None and chosen.rev_wav is None:
        return None
    if chosen.orig_wav is None or chosen.rev_wav is None:
        raise BadInput("Two recordings belong together: --orig-wav and --rev-wav.")
    from core.recording.sound_file import read_sound
    from core.speech.quality.audio_similarity import liken

    return liken(read_sound(chosen.orig_wav), read_sound(chosen.rev_wav))


def read_text(path: Path) -> str:
    """A text file. Raises BadInput with a sentence."""
    try:
        if path.stat().st_size > MAX_TEXT_BYTES:
            raise BadInput(f"{path.name} is too large for a text that was spoken.")
        return text_of(path.read_bytes(), path.name)
    except OSError as trouble:
        raise BadInput(f"The text {path.name} cannot be read: {trouble.strerror or trouble}.") from None


def save(out: Path | None, report: SpeechReport, html: str | None) -> dict[str, str]:
    """Figures and page into a folder → what lies where."""
    if out is None:
        return {}
    from core.files import save_all

    texts = {"json": ("speech_quality.json", json.dumps(plain(report.to_dict()), indent=1, ensure_ascii=False))}
    return save_all(out, texts if html is None else texts | {"page": ("speech_quality.html", html)})


def sentences(report: SpeechReport) -> list[str]:
    lines: list[str] = []
    if (texts := report.texts) is not None:
        ratio = "undefined" if texts["osqe_r"] is None else f"{texts['osqe_r']:.3g}"
        lines += [
            f"Erroneous words: person {texts['erroneous_words_person']}, robot {texts['erroneous_words_robot']}",
            f"OSQE_D {texts['osqe_d']:+d}, OSQE_R {ratio}" + (f" ({texts['reason']})" if texts["reason"] else ""),
        ]
        if "verdict" in texts:
            low, high = texts["osqe_d_interval_95"]
            lines += [f"95 % of OSQE_D: {low:g} to {high:g} ({texts['words']} words)", texts["verdict"]]
    if (audio := report.audio) is not None:
        shown = {
            "STOI": audio["stoi"],
            "ESTOI": audio["estoi"],
            "SI-SDR [dB]": audio["si_sdr_db"],
            "PESQ": audio["pesq_wb"],
        }
        lines += [
            ", ".join(f"{name} {figure:.3g}" for name, figure in shown.items() if figure is not None),
            f"delay {1000 * audio['delay_s']:.1f} ms, level {audio['level_change_db']:+.1f} dB",
        ]
        lines += filter(None, (audio["compared_note"], audio["pesq_reason"]))
    return lines + [f"{name}: {path}" for name, path in report.files.items()]
