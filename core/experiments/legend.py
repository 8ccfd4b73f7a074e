"""The key of a picture in SVG: a mark and its name, one after the other in a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

SOFT = "#435567"
LONG, GAP, LETTER = 22, 20, 6.3  # [px] of a mark, after a name, and of one letter of it


@dataclass(frozen=True)
class Mark:
    """How something is drawn, and what it is."""

    name: str
    colours: str | Sequence[str]  # of one panel, or of each
    width: float  # [px]
    dash: str = ""
    opacity: float = 1.0
    form: Literal["line", "cross", "ellipse"] = "line"


def legend(at: tuple[float, float], marks: Sequence[Mark]) -> str:
    """Marks in a line from `at` [px] → SVG."""
    (left, middle), parts = at, list[str]()
    for mark in marks:
        colours = (mark.colours,) if isinstance(mark.colours, str) else mark.colours
        for colour in colours:
            look = f'stroke="{colour}" stroke-width="{mark.width:g}" stroke-opacity="{mark.opacity:g}"'
            look += f' stroke-dasharray="{mark.dash}"' if mark.dash else ""
            parts.append(_shape(mark.form, left, middle, look, colour))
            left += (LONG if mark.form == "line" else 15) + 4
        parts.append(f'<text x="{left + 2:.1f}" y="{middle + 4:g}" fill="{SOFT}" font-size="12.5">{mark.name}</text>')
        left += 2 + LETTER * len(mark.name) + GAP
    return "\n".join(parts)


def _shape(form: str, left: float, middle: float, look: str, colour: str) -> str:
    if form == "cross":
        return f'<path d="M{left + 3:.1f} {middle - 4:g}l8 8m0 -8l-8 8" {look} fill="none"/>'
    if form == "ellipse":
        return (
            f'<ellipse cx="{left + 7:.1f}" cy="{middle:g}" rx="7" ry="5" {look} fill="{colour}" fill-opacity="0.12"/>'
        )
    return f'<path d="M{left:.1f} {middle:g}h{LONG}" {look} fill="none"/>'
