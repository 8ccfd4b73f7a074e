"""The speech quality report as one page that needs nothing else: to be read, printed and kept."""

import base64
import re
from collections.abc import Mapping, Sequence
from html import escape, unescape

import cv2
import msgspec
import numpy as np

from core.message import Array
from core.sentences import PageTexts
from core.speech.quality.audio_similarity import AudioSimilarity
from core.speech.quality.osqe import SpeechPath, SpeechQuality
from core.speech.quality.time_alignment import RATE_HZ
from core.speech.quality.word_alignment import Pair

STYLE = """
:root{--ink:#1d2329;--soft:#5c6873;--line:#d9dfe4;--paper:#fff;--ground:#f3f5f7;--accent:#0b6bcb;
--wrong:#ffe066;--lost:#c92a2a;--more:#2b8a3e}
@media(prefers-color-scheme:dark){:root{--ink:#e6eaee;--soft:#9aa7b2;--line:#343d46;--paper:#1b2127;--ground:#12161a;
--accent:#6cb2f7;--wrong:#8a6d00;--lost:#ff8787;--more:#69db7c}}
*{box-sizing:border-box}
body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:60rem;margin:2rem auto;padding:2rem 2.5rem;background:var(--paper);border-radius:12px}
h1{margin:0;font-size:1.9rem;letter-spacing:-.01em}
header p,.note{color:var(--soft);margin:.3rem 0 0}
.note{font-size:.875rem}
section{margin-top:2rem}
section>h2{font-size:1.1rem;margin:0 0 .6rem}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(11rem,1fr));gap:1rem}
.tiles div{border:1px solid var(--line);border-radius:10px;padding:1rem}
.tiles h2{font-size:.875rem;font-weight:500;color:var(--soft);margin:0}
.tiles b{display:block;font-size:2.2rem;line-height:1.2;font-variant-numeric:tabular-nums}
.tiles sub{line-height:0}
.tiles small{color:var(--soft)}
.verdict{margin:1.2rem 0 0;font-size:1.1rem;font-weight:600;color:var(--accent)}
table{width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{text-align:left;padding:.4rem .6rem;border-bottom:1px solid var(--line);vertical-align:top;font-weight:400}
thead th{color:var(--soft);font-size:.875rem}
.numbers td,.numbers thead th{text-align:right}
.numbers th:first-child{text-align:left}
.texts td{width:33.3%}
.measures th{width:10rem;color:var(--soft)}
.measures td:nth-child(2){white-space:nowrap;font-weight:600}
mark{background:var(--wrong);color:inherit;border-radius:3px;padding:0 .2em}
del{color:var(--lost)}
ins{color:var(--more);text-decoration:none;border-bottom:2px solid}
figure{margin:1rem 0 0}
figcaption{color:var(--soft);font-size:.875rem}
img{display:block;width:100%;border-radius:6px}
@media(max-width:40rem){main{margin:0;padding:1.2rem;border-radius:0}.texts td{width:auto}}
@media print{body{background:#fff;color:#000}main{margin:0;padding:0;max-width:none}
section{break-inside:avoid}.texts tr{break-inside:avoid}mark,img{print-color-adjust:exact}}
"""


MAX_SHOWN_S = 12.0  # of the recordings that are drawn
REPORT = "report: "  # begins its rows among the page's texts
LANGUAGE = '<html lang="en">'
WORDS = re.compile(r"<style>.*?</style>|<tbody class='said'>.*?</tbody>|(?<=>)[^<>]+(?=<)", re.DOTALL)
SIGN = "Below zero, or a ratio below one: the robot hears worse than the person's own path."


class QualityRow(msgspec.Struct, frozen=True, kw_only=True):
    """The figures of one place; those that are unset were not measured."""

    distance_m: float
    snr_db: float
    refused: str  # why nobody can speak from there
    stoi: float | msgspec.UnsetType | None = msgspec.UNSET
    estoi: float | msgspec.UnsetType | None = msgspec.UNSET
    si_sdr_db: float | msgspec.UnsetType | None = msgspec.UNSET
    words: int | msgspec.UnsetType = msgspec.UNSET
    erroneous_words_person: int | msgspec.UnsetType = msgspec.UNSET
    erroneous_words_robot: int | msgspec.UnsetType = msgspec.UNSET
    osqe_d: float | msgspec.UnsetType | None = msgspec.UNSET
    osqe_r: float | msgspec.UnsetType | None = msgspec.UNSET
    reason: str | msgspec.UnsetType | None = msgspec.UNSET  # why a figure is undefined
    verdict: str | msgspec.UnsetType | None = msgspec.UNSET
    commands: int | msgspec.UnsetType = msgspec.UNSET
    commands_exact: int | msgspec.UnsetType = msgspec.UNSET


def page(
    quality: SpeechQuality | None,
    similarity: AudioSimilarity | None = None,
    surroundings: Mapping[str, str] | None = None,
) -> str:
    """Write the measurements as HTML. `surroundings`: further facts to keep, name and value ("distance": "2 m")."""
    parts = [
        *([] if quality is None else [_figures(quality), _paths(quality), _texts(quality)]),
        *([] if similarity is None else [_sound(similarity)]),
        _surroundings(surroundings or {}),
    ]
    return (
        f'<!doctype html>\n{LANGUAGE}<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Speech quality</title><style>{STYLE}</style></head><body><main>"
        "<header><h1>Speech quality</h1>"
        "<p>What was said, what the person's path wrote down, and what the robot heard.</p>"
        f"</header>{''.join(parts)}</main></body></html>\n"
    )


def in_language(document: str, texts: PageTexts) -> str:
    """Translate what `page` wrote; what was said and heard stays as it is."""

    def said(found: re.Match[str]) -> str:
        words = unescape(found[0])
        if found[0].startswith("<"):
            return found[0]
        if (known := texts.said(words)) != words:
            return escape(known)
        row = REPORT + words  # a word of these tables is no word of the whole page's
        return escape(words if (known := texts.said(row)) == row else known)

    return WORDS.sub(said, document.replace(LANGUAGE, LANGUAGE.replace("en", texts.language), 1))


def _figures(quality: SpeechQuality) -> str:
    one = quality.score
    wrong = f"{one['erroneous_words_person']} / {one['erroneous_words_robot']}"
    ratio = "–" if one["osqe_r"] is None else f"{one['osqe_r']:.3g}"
    low, high = quality.difference_interval
    least, most = quality.bounded_interval
    tiles = [
        _tile("OSQE<sub>D</sub>", f"{one['osqe_d']:+d}".replace("-", "−"), f"95 %: {_span(low, high)}"),
        _tile("OSQE<sub>R</sub>", ratio, escape(one["reason"]) or wrong),
        _tile("bounded ratio", f"{one['osqe_r_bounded']:.2f}", f"95 %: {_span(least, most)}"),
        _tile("commands whole", f"{sum(quality.robot.exact)}", f"of {len(quality.phrases)} by the robot"),
    ]
    return (
        f'<section class="tiles">{"".join(tiles)}</section>'
        f'<p class="verdict">{escape(quality.verdict)}</p><p class="note">{SIGN}</p>'
    )


def _span(low: float, high: float) -> str:
    return f"{low:.3g} … {high:.3g}".replace("-", "−")


def _tile(name: str, value: str, remark: str) -> str:
    return f"<div><h2>{name}</h2><b>{value}</b><small>{remark}</small></div>"


def _paths(quality: SpeechQuality) -> str:
    rows = "".join(
        f"<tr><th>{name}</th><td><b>{path.errors}</b></td><td>{path.count('substituted')}</td>"
        f"<td>{path.count('deleted')}</td><td>{path.count('inserted')}</td>"
        f"<td>{100 * path.errors / path.words:.1f} %</td><td>{sum(path.exact)} / {path.phrases}</td></tr>"
        for name, path in (("person", quality.person), ("robot", quality.robot))
    )
    return (
        "<section><h2>Erroneous words</h2><table class='numbers'><thead><tr><th></th><th>erroneous</th>"
        "<th>substituted</th><th>deleted</th><th>inserted</th><th>word error rate</th><th>commands whole</th></tr>"
        f"</thead><tbody>{rows}</tbody></table><p class='note'>{quality.person.words} words in "
        f"{len(quality.phrases)} phrases; letters, punctuation and the way numbers are written do not count.</p>"
        "</section>"
    )


def _texts(quality: SpeechQuality) -> str:
    person, robot = _by_phrase(quality.person), _by_phrase(quality.robot)
    rows = "".join(
        f"<tr><td>{escape(text)}</td><td>{_marked(person[number])}</td><td>{_marked(robot[number])}</td></tr>"
        for number, text in enumerate(quality.phrases)
    )
    return (
        "<section><h2>Word by word</h2><table class='texts'><thead><tr><th>original</th><th>person</th><th>robot</th>"
        f"</tr></thead><tbody class='said'>{rows}</tbody></table><p class='note'><mark>another word</mark> "
        "<del>word lost</del> <ins>word too many</ins></p></section>"
    )


def _by_phrase(path: SpeechPath) -> list[list[Pair]]:
    rows: list[list[Pair]] = [[] for _ in range(path.phrases)]
    for pair in path.pairs:
        rows[pair.phrase].append(pair)
    return rows


def _marked(pairs: Sequence[Pair]) -> str:
    shown = {
        "same": "{heard}",
        "substituted": '<mark title="{original}">{heard}</mark>',
        "deleted": "<del>{original}</del>",
        "inserted": "<ins>{heard}</ins>",
    }
    return " ".join(
        shown[pair.kind].format(original=escape(pair.original), heard=escape(pair.heard)) for pair in pairs
    )


def _sound(similarity: AudioSimilarity) -> str:
    one, matched = similarity.figures, similarity.matched
    original, received = one["original"], one["received"]
    shown = [samples[: round(MAX_SHOWN_S * RATE_HZ)] for samples in (matched.original, matched.received)]
    top = max(float(_levels(samples, RATE_HZ).max()) for samples in shown)
    pictures = "".join(
        f"<figure><figcaption>{name}</figcaption><img alt='' "
        f"src='data:image/png;base64,{base64.b64encode(spectrogram_png(samples, RATE_HZ, top)).decode()}'></figure>"
        for name, samples in zip(("original", "received"), shown, strict=True)
    )
    seconds = len(shown[0]) / RATE_HZ
    rows = [
        ("STOI", _number(one["stoi"], ".3f"), "understood, 0 to 1"),
        ("ESTOI", _number(one["estoi"], ".3f"), "the same where noise comes and goes"),
        ("SI-SDR", _number(one["si_sdr_db"], ".1f", " dB"), "reverberation counts as distortion here"),
        ("PESQ, wide band", _number(one["pesq_wb"], ".2f"), one["pesq_reason"] or "1 to 4.6"),
        ("delay", f"{1000 * matched.delay:.1f} ms", "found and taken out before comparing"),
        ("level", f"{one['level_change_db']:+.1f} dB", "received against original"),
        (
            "noise floor",
            f"{received['noise_floor_dbfs']:.0f} dBFS",
            f"original {original['noise_floor_dbfs']:.0f} dBFS",
        ),
        ("clipped", _percent(received["clipped_share"]), f"original {_percent(original['clipped_share'])}"),
    ]
    if one["compared_note"]:
        rows.append(("compared", _percent(one["compared_share"]), one["compared_note"]))
    if matched.inverted:
        rows.append(("polarity", "inverted", "the received sound is upside down; it was turned"))
    body = "".join(
        f"<tr><th>{name}</th><td>{value}</td><td>{escape(remark)}</td></tr>" for name, value, remark in rows
    )
    return (
        f"<section><h2>The two recordings</h2><table class='measures'><tbody>{body}</tbody></table>{pictures}"
        f"<p class='note'>The first {seconds:.1f} s to the right, 0 to 8 kHz upwards, the same colours in both.</p>"
        "</section>"
    )


def _percent(share: float) -> str:
    return f"{100 * share:.2f} %"


def _number(value: float | None, form: str, unit: str = "") -> str:
    return "–" if value is None else f"{value:{form}}{unit}".replace("-", "−")


def _surroundings(facts: Mapping[str, str]) -> str:
    if not facts:
        return ""
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in facts.items())
    return f"<section><h2>Surroundings</h2><table class='measures'><tbody>{rows}</tbody></table></section>"


FRAME_S, STEP_S = 0.032, 0.008
MAX_FREQUENCY_HZ = 8_000.0
RANGE_DB = 70.0  # below the loudest is black
SIZE_PX = (900, 260)  # [pixels] of the picture


def spectrogram_png(samples: Array, rate: int, loudest: float | None = None) -> bytes:
    """Samples (N,) at `rate` [Hz] → a PNG of 900 x 260 pixels.

    `loudest` [dB], as of `loudest_db`, gives two pictures the same colours.
    """
    levels = _levels(samples, rate)
    top = float(levels.max()) if loudest is None else loudest
    grey = np.clip(255 * (1 + (levels - top) / RANGE_DB), 0, 255).astype(np.uint8)
    wide = cv2.resize(grey[::-1], SIZE_PX, interpolation=cv2.INTER_AREA)
    _, png = cv2.imencode(".png", cv2.applyColorMap(wide, cv2.COLORMAP_MAGMA))
    return png.tobytes()


def _levels(samples: Array, rate: int) -> Array:
    """(bins, frames) [dB], lowest pitch first."""
    from scipy.signal import ShortTimeFFT  # takes half a second, and few processes write a report

    window = np.hanning(max(16, round(FRAME_S * rate)))
    padded = np.pad(np.asarray(samples, float), (0, max(0, len(window) - len(samples))))
    transform = ShortTimeFFT(window, max(1, round(STEP_S * rate)), rate, fft_mode="onesided")
    power = np.abs(transform.stft(padded)) ** 2
    return 10 * np.log10(power[transform.f <= MAX_FREQUENCY_HZ] + 1e-12)
