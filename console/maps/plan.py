"""The map as a plan to print: walls, floor, rooms, zones, a scale, the world's axes; SVG or PDF, true to scale."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from core.errors import BadInput
from core.message import Array
from core.navigation.places import NamedPlace
from core.navigation.zones import MapZone
from core.slam.map.outline import MapOutline

PAGE_MM = (297.0, 210.0)  # A4, the long side across
MARGIN_MM, FOOT_MM = 12.0, 14.0
MIN_BAR_MM = 30.0  # length of the scale
MAX_MM_PER_M = 100.0  # a small room is drawn 1:10 at most
BAR_LENGTHS_M = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)
AXIS_MM = 8.0
POINTS_PER_MM = 72 / 25.4
WALL_GREY, FLOOR_GREY, TEXT_GREY, AREA_GREY, KEEP_OUT_GREY = 0.2, 0.93, 0.25, 0.5, 0.75
LETTER_MM = 4.5  # of the words of a printed sheet
MAX_TITLE_MM = 6.0  # of letters beside which the title has room
LETTER_WIDTH = 0.53  # of its height, on average, of a sans-serif type
LINE_SPACING = 1.25  # by which lines of words are apart, in letters
MAX_LINES_OFF = 12  # that a name stands from what it names, where others are in its way
PLACE_RADIUS = 0.22  # in letters
DASH_MM = "2 1.2"  # of the outline of a room or of a zone to drive slowly in
MAX_WAY_POINTS = 3000
WAY_COLOUR = "#0b6bcb"
PDF_CHARACTERS = "latin-1"


@dataclass(frozen=True)
class PrintedPlan:
    """All that a sheet shows, in the world as it is now."""

    outline: MapOutline
    title: str
    places: tuple[NamedPlace, ...] = ()  # a room with its outline
    zones: tuple[MapZone, ...] = ()
    way: Array | None = None  # (N, 2) [m], world: where the robot was

    @property
    def areas(self) -> list[Array]:
        """Polygons (N, 2) [m] of the rooms and of the zones to drive slowly in."""
        rooms = [np.array(place.outline_m) for place in self.places if place.outline_m]
        return rooms + [zone.points for zone in self.zones if zone.kind == "slow"]

    @property
    def keep_outs(self) -> list[Array]:
        """Polygons (N, 2) [m] of the zones to keep out of."""
        return [zone.points for zone in self.zones if zone.kind == "keep_out"]


@dataclass(frozen=True)
class PlanLayout:
    """The place of the map on its sheet: millimetres from the lower left corner; its words are `letter_mm` high."""

    mm_per_m: float
    left_m: float
    bottom_m: float
    offset_x_mm: float
    offset_y_mm: float
    bar_m: float
    letter_mm: float = LETTER_MM

    @classmethod
    def of(cls, outline: MapOutline, letter_mm: float = LETTER_MM) -> PlanLayout:
        """As large as the sheet allows. Raises BadInput where nothing is drawn."""
        if (extent := outline.extent) is None:
            raise BadInput("There is no wall in this map yet: drive the robot around the room first.")
        left, bottom, right, top = extent
        wide, high = PAGE_MM[0] - 2 * MARGIN_MM, PAGE_MM[1] - 2 * MARGIN_MM - FOOT_MM
        scale = min(MAX_MM_PER_M, wide / max(right - left, 0.1), high / max(top - bottom, 0.1))
        bar = next((length for length in BAR_LENGTHS_M if length * scale >= MIN_BAR_MM), BAR_LENGTHS_M[-1])
        across, up = ((room - scale * size) / 2 for room, size in ((wide, right - left), (high, top - bottom)))
        return cls(scale, left, bottom, MARGIN_MM + across, MARGIN_MM + FOOT_MM + up, bar, letter_mm)

    @property
    def place_radius_mm(self) -> float:
        return PLACE_RADIUS * self.letter_mm

    def width_mm(self, words: str) -> float:
        """About as long as words are."""
        return LETTER_WIDTH * self.letter_mm * len(words)

    def ring(self, points: Array) -> list[tuple[float, float]]:
        """Points (N, 2) [m], world → on the sheet [mm], cut at its edge."""
        x = self.offset_x_mm + self.mm_per_m * (points[:, 0] - self.left_m)
        y = self.offset_y_mm + self.mm_per_m * (points[:, 1] - self.bottom_m)
        x, y = x.clip(MARGIN_MM, PAGE_MM[0] - MARGIN_MM), y.clip(MARGIN_MM + FOOT_MM, PAGE_MM[1] - MARGIN_MM)
        return list(zip(x.tolist(), y.tolist(), strict=True))

    @property
    def strokes(self) -> list[list[tuple[float, float]]]:
        """Polylines of the scale and of the axes x and y of the world [mm]."""
        low, bar, right = MARGIN_MM, self.bar_m * self.mm_per_m, PAGE_MM[0] - MARGIN_MM - 2 * AXIS_MM
        scale = [(MARGIN_MM, low + 2), (MARGIN_MM, low), (MARGIN_MM + bar, low), (MARGIN_MM + bar, low + 2)]
        tip_x = [(right + AXIS_MM - 2, low + 1), (right + AXIS_MM, low), (right + AXIS_MM - 2, low - 1)]
        tip_y = [(right - 1, low + AXIS_MM - 2), (right, low + AXIS_MM), (right + 1, low + AXIS_MM - 2)]
        return [scale, [(right, low + AXIS_MM), (right, low), (right + AXIS_MM, low)], tip_x, tip_y]

    def spots(self, plan: PrintedPlan) -> list[list[tuple[float, float]]]:
        """Return a small disc for each place [mm]."""
        turns = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        disc = self.place_radius_mm / self.mm_per_m * np.column_stack((np.cos(turns), np.sin(turns)))
        return [self.ring(np.array([place.x_m, place.y_m]) + disc) for place in plan.places]

    def names(self, plan: PrintedPlan) -> tuple[list[tuple[float, float, str]], list[list[tuple[float, float]]]]:
        """Return the names, on no other and on no spot, with their lower left corners; lines to far ones [mm]."""
        beside = self.place_radius_mm + 0.8
        letter = self.letter_mm
        named = [((place.x_m, place.y_m), beside, place.name) for place in plan.places]
        for zone in plan.zones:
            name = zone.name if zone.max_speed is None else f"{zone.name}, {zone.max_speed:g} m/s"
            named.append((zone.points.mean(axis=0), -self.width_mm(name) / 2, name))
        boxes = [(*np.min(spot, axis=0), *np.max(spot, axis=0)) for spot in self.spots(plan)]
        names, lines = list[tuple[float, float, str]](), list[list[tuple[float, float]]]()
        for at, right, name in named:
            ((x, y),), wide = self.ring(np.array([at])), self.width_mm(name)
            tried = [
                (left, y - letter / 3 + off * LINE_SPACING * letter)
                for off in sorted(range(-MAX_LINES_OFF, MAX_LINES_OFF + 1), key=abs)
                for left in (x + right, x - beside - wide)
            ]
            free = (one for one in tried if is_free(*one, wide, letter, boxes))
            left, low = next(free, tried[0])
            names.append((left, low, name))
            boxes.append((left, low, left + wide, low + letter))
            end = min(max(x, left), left + wide), min(max(y, low), low + letter)
            if math.dist((x, y), end) > letter / 2:
                lines.append([(x, y), end])
        return names, lines

    def words(self, plan: PrintedPlan) -> tuple[list[tuple[float, float, str]], list[list[tuple[float, float]]]]:
        """Return every text with its lower left corner, and the lines to far names [mm]."""
        names, lines = self.names(plan)
        right = PAGE_MM[0] - MARGIN_MM - 2 * AXIS_MM
        bar = MARGIN_MM + self.bar_m * self.mm_per_m + 3
        title = [(bar + 20, MARGIN_MM, plan.title)] if self.letter_mm <= MAX_TITLE_MM else []
        return [
            (bar, MARGIN_MM, f"{self.bar_m:g} m"),
            *title,
            (right + AXIS_MM + 1.5, MARGIN_MM - 1, "x"),
            (right - 1, MARGIN_MM + AXIS_MM + 1.5, "y"),
            *names,
        ], lines


def is_free(left: float, low: float, wide: float, letter: float, boxes: list[tuple[float, ...]]) -> bool:
    """Return whether words lie on the sheet and on no box (left, low, right, high) [mm]."""
    far, high, (width, height) = left + wide, low + letter, PAGE_MM
    inside = left >= MARGIN_MM and far <= width - MARGIN_MM and MARGIN_MM + FOOT_MM <= low <= height - MARGIN_MM
    return inside and not any(x < far and left < right and y < high and low < top for x, y, right, top in boxes)


def plan_svg(plan: PrintedPlan, letter_mm: float = LETTER_MM) -> bytes:
    """Plan → SVG of an A4 sheet; user units are millimetres. Raises BadInput where nothing is drawn.

    `letter_mm`: height of its words; a sheet that is shown small needs large ones, and has no room for its title.
    """
    layout = PlanLayout.of(plan.outline, letter_mm)
    wide, high = PAGE_MM

    def path(lines: Iterable[list[tuple[float, float]]], end: str = "") -> str:
        return "".join("M" + "L".join(f"{x:.2f} {high - y:.2f}" for x, y in line) + end for line in lines)

    def grey(level: float) -> str:
        return "#" + f"{round(255 * level):02x}" * 3

    words, lines = layout.words(plan)
    texts = "".join(f'<text x="{x:.2f}" y="{high - y:.2f}">{escaped(word)}</text>' for x, y, word in words)
    strokes = layout.strokes + lines
    walls, floor = (path(map(layout.ring, rings), "Z") for rings in (plan.outline.walls, plan.outline.floor))
    line = np.empty((0, 2)) if plan.way is None else plan.way[:: 1 + len(plan.way) // MAX_WAY_POINTS]
    drawn = (
        f'<path fill="{grey(FLOOR_GREY)}" fill-rule="evenodd" d="{floor}"/>'
        f'<path fill="{grey(KEEP_OUT_GREY)}" d="{path(map(layout.ring, plan.keep_outs), "Z")}"/>'
        f'<path fill="{grey(WALL_GREY)}" stroke="{grey(WALL_GREY)}" stroke-width="0.3" stroke-linejoin="round" '
        f'fill-rule="evenodd" d="{walls}"/>'
        f'<path fill="none" stroke="{grey(AREA_GREY)}" stroke-width="0.4" stroke-dasharray="{DASH_MM}" '
        f'd="{path(map(layout.ring, plan.areas), "Z")}"/>'
        f'<path fill="none" stroke="{WAY_COLOUR}" stroke-width="0.6" d="{path([layout.ring(line)])}"/>'
        f'<path fill="none" stroke="{grey(TEXT_GREY)}" stroke-width="0.4" d="{path(strokes)}"/>'
        f'<path fill="{grey(TEXT_GREY)}" d="{path(layout.spots(plan), "Z")}"/>'
        f'<g fill="{grey(TEXT_GREY)}" font-family="Helvetica, Arial, sans-serif" '
        f'font-size="{letter_mm:g}">{texts}</g>'
    )
    size = f'width="{wide:g}mm" height="{high:g}mm" viewBox="0 0 {wide:g} {high:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>'
    return f"{head}<title>{escaped(plan.title)}</title>{drawn}</svg>\n".encode()


def plan_pdf(plan: PrintedPlan) -> bytes:
    """Plan → PDF 1.4 of one A4 sheet, all of it vectors. Raises BadInput where nothing is drawn."""
    layout = PlanLayout.of(plan.outline)

    def path(lines: Iterable[list[tuple[float, float]]], end: str) -> str:
        return " ".join(
            " ".join(f"{x:.2f} {y:.2f} {'l' if index else 'm'}" for index, (x, y) in enumerate(line)) + end
            for line in lines
        )

    words, lines = layout.words(plan)
    texts = " ".join(f"BT /F {LETTER_MM} Tf {x:.2f} {y:.2f} Td ({quoted(word)}) Tj ET" for x, y, word in words)
    strokes = layout.strokes + lines
    walls, floor = (path(map(layout.ring, rings), " h") for rings in (plan.outline.walls, plan.outline.floor))
    content = (
        f"{POINTS_PER_MM:.6f} 0 0 {POINTS_PER_MM:.6f} 0 0 cm 1 j {FLOOR_GREY} g {floor} f* "
        f"{KEEP_OUT_GREY} g {path(map(layout.ring, plan.keep_outs), ' h f')} "
        f"{WALL_GREY} g {WALL_GREY} G 0.3 w {walls} B* "
        f"{AREA_GREY} G 0.4 w [{DASH_MM}] 0 d {path(map(layout.ring, plan.areas), ' s')} [] 0 d "
        f"{TEXT_GREY} g {TEXT_GREY} G 0.4 w {path(strokes, ' S')} {path(layout.spots(plan), ' f')} {texts}"
    ).encode(PDF_CHARACTERS, "replace")
    box = " ".join(f"{side * POINTS_PER_MM:.2f}" for side in PAGE_MM)
    page = f"/MediaBox [0 0 {box}] /Contents 4 0 R /Resources << /Font << /F 5 0 R >> >>"
    return pdf_file(
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R {page} >>".encode(),
        f"<< /Length {len(content)} >>\nstream\n".encode() + content + b"\nendstream",
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    )


def pdf_file(*objects: bytes) -> bytes:
    """Objects 1, 2, … (the first is the catalogue) → a PDF with its table of places."""
    packed, places = b"%PDF-1.4\n", list[int]()
    for number, body in enumerate(objects, 1):
        places.append(len(packed))
        packed += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    count = len(objects) + 1
    head = b"xref\n0 %d\n0000000000 65535 f \n%s" % (count, table)
    return packed + head + b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (count, len(packed))


def escaped(words: str) -> str:
    """Words as text of an XML element."""
    return words.replace("&", "&amp;").replace("<", "&lt;")


def quoted(words: str) -> str:
    """Words as a PDF string."""
    return words.replace("\\", "\\\\").replace("(", "\\(").replace(")", "\\)")
