"""A chart in SVG: a frame with two scales, and lines, ellipses and words in its units."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from core.message import Array

FONT = "-apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'Liberation Sans', Arial, sans-serif"
TEXT, SOFT, LINE = "#13202c", "#435567", "#d8e0e7"
ROUND = 36  # corners of an ellipse's outline
WASH = 0.12  # opacity of what is filled


@dataclass(frozen=True)
class Area:
    """A rectangle of the picture [px]."""

    left: float
    top: float
    width: float
    height: float


class SvgChart:
    """Gathers what stands in one frame; `svg` is all of it."""

    def __init__(self, area: Area, x: tuple[float, float], y: tuple[float, float]) -> None:
        """`x`, `y`: the units at the rims."""
        self.area, self._x, self._y = area, x, y
        self._inside: list[str] = []
        self._around: list[str] = []

    def place(self, points: Array) -> Array:
        """Points (N, 2) in units → (N, 2) [px]."""
        points = np.asarray(points, float).reshape(-1, 2)
        area, (x0, x1), (y0, y1) = self.area, self._x, self._y
        right = area.left + (points[:, 0] - x0) / (x1 - x0) * area.width
        down = area.top + (y1 - points[:, 1]) / (y1 - y0) * area.height
        return np.column_stack((right, down))

    def line(
        self,
        points: Array,
        colour: str,
        width: float = 1.5,
        *,
        opacity: float = 1.0,
        dash: str = "",
        fill: str = "none",
    ) -> None:
        """Draw through points (N, 2)."""
        way = "L".join(f"{u:.1f} {v:.1f}" for u, v in self.place(points).tolist())
        look = f'stroke-width="{width:g}"' + (f' stroke-opacity="{opacity:g}"' if opacity < 1 else "")
        look += f' stroke-dasharray="{dash}"' if dash else ""
        self._inside.append(f'<path d="M{way}" stroke="{colour}" {look} fill="{fill}" fill-opacity="{WASH}"/>')

    def ellipse(self, middle: Array, covariance: Array, colour: str, size: float) -> None:
        """Around a point (2,): `size` standard deviations of a covariance (2, 2)."""
        values, vectors = np.linalg.eigh(covariance)
        turns = np.linspace(0, 2 * math.pi, ROUND + 1)
        rim = np.column_stack((np.cos(turns), np.sin(turns))) * size * np.sqrt(np.maximum(values, 0.0))
        self.line(middle + rim @ vectors.T, colour, 1.2, fill=colour)

    def dot(self, point: Sequence[float], colour: str, radius: float = 3.5, *, hollow: bool = False) -> None:
        """A round mark."""
        (u, v) = self.place(np.array(point))[0].tolist()
        fill = "#ffffff" if hollow else colour
        self._inside.append(
            f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius:g}" fill="{fill}" stroke="{colour}" stroke-width="1.5"/>'
        )

    def cross(self, point: Sequence[float], colour: str, reach: float = 4.0) -> None:
        """A lying cross."""
        (u, v) = self.place(np.array(point))[0].tolist()
        across = f"{2 * reach:g}"
        arms = f"M{u - reach:.1f} {v - reach:.1f}l{across} {across}m0 -{across}l-{across} {across}"
        self._inside.append(f'<path d="{arms}" stroke="{colour}" stroke-width="1.4" fill="none"/>')

    def word(
        self,
        text: str,
        point: Sequence[float],
        colour: str,
        *,
        shift: tuple[float, float] = (6, -6),
        anchor: str = "start",
    ) -> None:
        """Words next to a point; `shift` in [px]."""
        (u, v) = (self.place(np.array(point))[0] + shift).tolist()
        self._around.append(
            f'<text x="{u:.1f}" y="{v:.1f}" text-anchor="{anchor}" fill="{colour}" stroke="#ffffff" '
            f'stroke-width="3" paint-order="stroke" font-size="12.5" font-weight="600">{text}</text>'
        )

    def scales(self, x_name: str, y_name: str) -> None:
        """Numbers and thin lines at round values, and what they count."""
        area = self.area
        for value, label in ticks(*self._x):
            (u, _) = self.place(np.array([value, self._y[0]]))[0].tolist()
            self._inside.insert(0, f'<path d="M{u:.1f} {area.top:g}v{area.height:g}" stroke="{LINE}"/>')
            self._around.append(_small(label, u, area.top + area.height + 18, "middle"))
        for value, label in ticks(*self._y):
            (_, v) = self.place(np.array([self._x[0], value]))[0].tolist()
            self._inside.insert(0, f'<path d="M{area.left:g} {v:.1f}h{area.width:g}" stroke="{LINE}"/>')
            self._around.append(_small(label, area.left - 8, v + 4, "end"))
        self._around.append(_small(x_name, area.left + area.width / 2, area.top + area.height + 38, "middle"))
        u, v = area.left - 44, area.top + area.height / 2
        self._around.append(
            f'<text x="{u:.1f}" y="{v:.1f}" transform="rotate(-90 {u:.1f} {v:.1f})" text-anchor="middle" '
            f'fill="{SOFT}" font-size="12.5">{y_name}</text>'
        )

    def title(self, letter: str, text: str, note: str) -> None:
        """Above the frame: the panel's letter, its name, and on the right what it comes to."""
        area = self.area
        self._around.append(
            f'<text x="{area.left:g}" y="{area.top - 14:g}" fill="{TEXT}" font-size="15" font-weight="600">'
            f'<tspan fill="{SOFT}">{letter}</tspan>  {text}</text>'
        )
        self._around.append(
            f'<text x="{area.left + area.width:g}" y="{area.top - 14:g}" text-anchor="end" fill="{SOFT}" '
            f'font-size="12.5">{note}</text>'
        )

    def svg(self, name: str) -> str:
        """Everything; what leaves the frame is cut. `name` is for the cutting alone."""
        a = self.area
        box = f'x="{a.left:g}" y="{a.top:g}" width="{a.width:g}" height="{a.height:g}"'
        return "\n".join(
            (
                f'<clipPath id="{name}"><rect {box}/></clipPath>',
                f'<g clip-path="url(#{name})" stroke-linejoin="round" stroke-linecap="round">',
                *self._inside,
                f'</g><rect {box} fill="none" stroke="#7d8fa0" stroke-width="1"/>',
                *self._around,
            )
        )


def sheet(width: int, height: int, title: str, subtitle: str, parts: Sequence[str]) -> str:
    """Charts on white paper with a title → an SVG file."""
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" font-family="{FONT}" role="img" aria-label="{title}">',
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
            f'<text x="36" y="44" fill="{TEXT}" font-size="22" font-weight="650">{title}</text>',
            f'<text x="36" y="68" fill="{SOFT}" font-size="13.5" xml:space="preserve">{subtitle}</text>',
            *parts,
            "</svg>\n",
        )
    )


def ticks(low: float, high: float, most: int = 8) -> list[tuple[float, str]]:
    """Round values from `low` to `high`, at most so many, and how they are written."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * each for each in (1, 2, 5, 10) if power * each >= rough * (1 - 1e-9))
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    first = math.ceil(low / step - 1e-9)
    numbers = [number * step for number in range(first, math.floor(high / step + 1e-9) + 1)]
    return [(value, f"{value:.{decimals}f}".replace("-", "−")) for value in numbers]


def rounded_up(value: float) -> float:
    """The end of a scale on which a value has room above it."""
    power = 10.0 ** math.floor(math.log10(max(value, 1e-9)))
    return next(power * each for each in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if power * each >= 1.04 * value)


def _small(text: str, u: float, v: float, anchor: str) -> str:
    return f'<text x="{u:.1f}" y="{v:.1f}" text-anchor="{anchor}" fill="{SOFT}" font-size="12.5">{text}</text>'


LONG, GAP, LETTER = 22, 20, 6.3  # [px] of a mark, after a name, and of one letter of it


@dataclass(frozen=True)
class LegendEntry:
    """A line style and its label."""

    name: str
    colours: str | Sequence[str]  # of one panel, or of each
    width: float  # [px]
    dash: str = ""
    opacity: float = 1.0
    form: Literal["line", "cross", "ellipse"] = "line"


def legend(at: tuple[float, float], marks: Sequence[LegendEntry]) -> str:
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
