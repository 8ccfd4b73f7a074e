"""The speech quality report as one page that needs nothing else: to be read, printed and kept."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape

from core.speech.alignment import Pair
from core.speech.likeness import Likeness
from core.speech.matching import RATE
from core.speech.quality import Path, Quality
from core.speech.quality_style import STYLE
from core.speech.spectrogram import loudest_db, spectrogram_png

SHOWN = 12.0  # [s] of the recordings that are drawn
SIGN = "Below zero, or a ratio below one: the robot hears worse than the person's own path."


def page(
    quality: Quality | None, likeness: Likeness | None = None, surroundings: Mapping[str, str] | None = None
) -> str:
    """What was measured → HTML. `surroundings`: what else is worth keeping, name and value ("distance": "2 m")."""
    parts = [
        *([] if quality is None else [_figures(quality), _paths(quality), _texts(quality)]),
        *([] if likeness is None else [_sound(likeness)]),
        _surroundings(surroundings or {}),
    ]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Speech quality</title><style>{STYLE}</style></head><body><main>"
        "<header><h1>Speech quality</h1>"
        "<p>What was said, what the person's path wrote down, and what the robot heard.</p>"
        f"</header>{''.join(parts)}</main></body></html>\n"
    )


def _figures(quality: Quality) -> str:
    one = quality.score
    ratio = "–" if one.ratio is None else f"{one.ratio:.3g}"
    low, high = quality.difference_interval
    least, most = quality.bounded_interval
    tiles = [
        _tile("OSQE<sub>D</sub>", f"{one.difference:+d}".replace("-", "−"), f"95 %: {_span(low, high)}"),
        _tile("OSQE<sub>R</sub>", ratio, escape(one.reason) or f"{one.person} / {one.robot}"),
        _tile("bounded ratio", f"{one.bounded:.2f}", f"95 %: {_span(least, most)}"),
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


def _paths(quality: Quality) -> str:
    rows = "".join(
        f"<tr><th>{name}</th><td><b>{path.errors}</b></td><td>{path.count('substituted')}</td>"
        f"<td>{path.count('deleted')}</td><td>{path.count('inserted')}</td>"
        f"<td>{100 * path.errors / path.words:.1f} %</td><td>{sum(path.exact)} of {path.phrases}</td></tr>"
        for name, path in (("person", quality.person), ("robot", quality.robot))
    )
    return (
        "<section><h2>Erroneous words</h2><table class='numbers'><thead><tr><th></th><th>erroneous</th>"
        "<th>substituted</th><th>deleted</th><th>inserted</th><th>word error rate</th><th>commands whole</th></tr>"
        f"</thead><tbody>{rows}</tbody></table><p class='note'>{quality.person.words} words in "
        f"{len(quality.phrases)} phrases; letters, punctuation and the way numbers are written do not count.</p>"
        "</section>"
    )


def _texts(quality: Quality) -> str:
    person, robot = _by_phrase(quality.person), _by_phrase(quality.robot)
    rows = "".join(
        f"<tr><td>{escape(text)}</td><td>{_marked(person[number])}</td><td>{_marked(robot[number])}</td></tr>"
        for number, text in enumerate(quality.phrases)
    )
    return (
        "<section><h2>Word by word</h2><table class='texts'><thead><tr><th>original</th><th>person</th><th>robot</th>"
        f"</tr></thead><tbody>{rows}</tbody></table><p class='note'><mark>another word</mark> "
        "<del>word lost</del> <ins>word too many</ins></p></section>"
    )


def _by_phrase(path: Path) -> list[list[Pair]]:
    rows: list[list[Pair]] = [[] for _ in range(path.phrases)]
    for pair in path.pairs:
        rows[pair.phrase].append(pair)
    return rows


def _marked(pairs: Sequence[Pair]) -> str:
    shown = {
        "same": "{heard}",
        "substituted": '<mark title="instead of {original}">{heard}</mark>',
        "deleted": "<del>{original}</del>",
        "inserted": "<ins>{heard}</ins>",
    }
    return " ".join(
        shown[pair.kind].format(original=escape(pair.original), heard=escape(pair.heard)) for pair in pairs
    )


def _sound(one: Likeness) -> str:
    shown = [samples[: round(SHOWN * RATE)] for samples in (one.matched.original, one.matched.received)]
    top = max(loudest_db(samples, RATE) for samples in shown)
    pictures = "".join(
        f"<figure><figcaption>{name}</figcaption><img alt='Spectrogram of the {name} sound' "
        f"src='data:image/png;base64,{base64.b64encode(spectrogram_png(samples, RATE, top)).decode()}'></figure>"
        for name, samples in zip(("original", "received"), shown, strict=True)
    )
    seconds = len(shown[0]) / RATE
    rows = [
        ("STOI", _number(one.stoi, ".3f"), "understood, 0 to 1"),
        ("ESTOI", _number(one.estoi, ".3f"), "the same where noise comes and goes"),
        ("SI-SDR", _number(one.si_sdr_db, ".1f", " dB"), "reverberation counts as distortion here"),
        ("PESQ, wide band", _number(one.pesq, ".2f"), one.pesq_reason or "1 to 4.6"),
        ("delay", f"{1000 * one.matched.delay:.1f} ms", "found and taken out before comparing"),
        ("level", f"{one.received.level_db - one.original.level_db:+.1f} dB", "received against original"),
        (
            "noise floor",
            f"{one.received.noise_floor_db:.0f} dBFS",
            f"original {one.original.noise_floor_db:.0f} dBFS",
        ),
        ("clipped", f"{100 * one.received.clipped:.2f} %", f"original {100 * one.original.clipped:.2f} %"),
    ]
    if one.matched.inverted:
        rows.append(("polarity", "inverted", "the received sound is upside down; it was turned"))
    body = "".join(
        f"<tr><th>{name}</th><td>{value}</td><td>{escape(remark)}</td></tr>" for name, value, remark in rows
    )
    return (
        f"<section><h2>The two recordings</h2><table class='measures'><tbody>{body}</tbody></table>{pictures}"
        f"<p class='note'>The first {seconds:.1f} s to the right, 0 to 8 kHz upwards, the same colours in both.</p>"
        "</section>"
    )


def _number(value: float | None, form: str, unit: str = "") -> str:
    return "–" if value is None else f"{value:{form}}{unit}".replace("-", "−")


def _surroundings(told: Mapping[str, str]) -> str:
    if not told:
        return ""
    rows = "".join(f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>" for name, value in told.items())
    return f"<section><h2>Surroundings</h2><table class='measures'><tbody>{rows}</tbody></table></section>"
