"""The plan of a map to print: true to scale, inside its sheet, and readable by other programs."""

import re
import zlib
from xml.etree import ElementTree

import numpy as np
import pytest

from console.maps.plan import LETTER_MM, MARGIN_MM, PAGE_MM, PlanLayout, PrintedPlan, plan_pdf, plan_svg
from core.errors import BadInput
from core.navigation.places import NamedPlace
from core.navigation.zones import MapZone
from core.slam.map.outline import MapOutline

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


@pytest.mark.parametrize("size_m", [0.4, 5.0, 60.0])
@pytest.mark.parametrize("shape", [(1.0, 1.0), (1.0, 0.1), (0.1, 1.0)])
def test_a_plan_is_true_to_scale_and_stays_on_its_sheet(size_m: float, shape: tuple[float, float]) -> None:
    ring = SQUARE * size_m * np.array(shape) + (-3.0, 7.0)
    layout = PlanLayout.of(MapOutline((ring,), (10 * ring,)))
    drawn, around = np.array(layout.ring(ring)), np.array(layout.ring(10 * ring))
    assert np.ptp(drawn, axis=0) == pytest.approx(layout.mm_per_m * size_m * np.array(shape))
    assert (around >= MARGIN_MM - 1e-9).all() and (around <= np.array(PAGE_MM) - MARGIN_MM + 1e-9).all()
    bar = layout.strokes[0]
    assert bar[2][0] - bar[1][0] == pytest.approx(layout.bar_m * layout.mm_per_m)


def test_svg_and_pdf_hold_the_same_walls_places_and_zones() -> None:
    place = NamedPlace(name="desk (2)", x_m=0.5, y_m=0.5, outline_m=((0.2, 0.2), (1.8, 0.2), (1.8, 1.0)))
    zone = MapZone(name="stairs", kind="keep_out", points=SQUARE)
    slow = MapZone(name="calm", kind="slow", points=SQUARE + 1, max_speed=0.05)
    plan = PrintedPlan(MapOutline((2 * SQUARE,), (3 * SQUARE,)), "lab <1> & (2)", (place,), (zone, slow))
    drawing = ElementTree.fromstring(plan_svg(plan))
    assert drawing.attrib["viewBox"] == "0 0 297 210"
    texts = {element.text: element for element in drawing.iter("{http://www.w3.org/2000/svg}text")}
    assert {"lab <1> & (2)", "desk (2)", "stairs", "calm, 0.05 m/s"} <= set(texts)
    layout = PlanLayout.of(plan.outline)
    ((x, y),) = layout.ring(np.array([[0.5, 0.5]]))
    at = np.array([float(texts["desk (2)"].attrib[axis]) for axis in "xy"])
    assert np.abs(at - (x, PAGE_MM[1] - y)).max() < 3  # beside its spot
    dashed = [one.attrib["d"] for one in drawing.iter() if "stroke-dasharray" in one.attrib]
    assert len(dashed) == 1 and dashed[0].count("M") == 2 and dashed[0].count("L") == 2 + 3  # a room and a slow zone
    corners = "L".join(f"{x:.2f} {PAGE_MM[1] - y:.2f}" for x, y in layout.ring(SQUARE))
    assert [one.attrib["d"] for one in drawing.iter() if one.attrib.get("fill") == "#bfbfbf"] == [f"M{corners}Z"]
    packed = plan_pdf(plan)
    places = [int(place) for place in re.findall(rb"(\d{10}) 00000 n", packed)]
    assert [packed[place:].split(b" ", 1)[0] for place in places] == [b"1", b"2", b"3", b"4", b"5"]
    length = int(re.search(rb"/Length (\d+)", packed).group(1))  # type: ignore[union-attr]
    content = packed.split(b"stream\n", 1)[1]
    assert content[length:].startswith(b"\nendstream")
    assert all(words in content for words in (rb"lab <1> & \(2\)", rb"(desk \(2\))", b"(stairs)", b"0.75 g"))
    assert zlib.crc32(packed) == zlib.crc32(plan_pdf(plan))


@pytest.mark.parametrize("letter_mm", [LETTER_MM, 12.0])
@pytest.mark.parametrize("apart_m", [0.0, 0.1, 0.4])
def test_names_of_near_places_and_zones_do_not_lie_on_each_other(apart_m: float, letter_mm: float) -> None:
    """Each beside what it names, or with a line to it."""
    ring = 8 * SQUARE
    places = tuple(
        NamedPlace(name=f"coffee machine {n}", x_m=4 + apart_m * n, y_m=4.0)
        for n in range(8 if letter_mm == LETTER_MM else 4)
    )
    zones = tuple(MapZone(name=f"glass table {n}", kind="keep_out", points=SQUARE + 3.6) for n in range(4))
    layout = PlanLayout.of(MapOutline((ring,), (ring,)), letter_mm)
    names, lines = layout.names(PrintedPlan(MapOutline((ring,), (ring,)), "lab", places, zones))
    boxes = [(x, y, x + layout.width_mm(name), y + letter_mm) for x, y, name in names]
    spots = [spot for place in places for spot in layout.ring(np.array([[place.x_m, place.y_m]]))]
    assert len(names) == len(places) + 4
    for n, (left, low, right, high) in enumerate(boxes):
        assert left >= MARGIN_MM and right <= PAGE_MM[0] - MARGIN_MM
        assert not any(x < right and left < far and y < high and low < top for x, y, far, top in boxes[:n])
        assert not any(left < x < right and low < y < high for x, y in spots)
    for (x, y), (end_x, end_y) in lines:
        assert any(left <= end_x <= right and low <= end_y <= high for left, low, right, high in boxes)
        assert (x, y) in spots or (x, y) == layout.ring(np.array([[4.1, 4.1]]))[0]
    assert lines


def test_a_map_without_walls_is_refused_with_what_to_do() -> None:
    with pytest.raises(BadInput, match="drive the robot around"):
        plan_svg(PrintedPlan(MapOutline((), ()), "map"))
