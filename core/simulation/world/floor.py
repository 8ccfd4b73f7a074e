"""A storey of 25 x 18 m: a hall, corridors around a block (a loop), rooms behind door openings."""

from core.simulation.world.objects import Thing, What, furniture
from core.simulation.world.plan import Dressing, Rect, World, Zone, outline

START_X, START_Y = 7.6, 5.3  # [m] where the robot wakes, seen from the building's south-west corner


def _at(x0: float, y0: float, x1: float, y1: float) -> Rect:
    (x0, x1), (y0, y1) = sorted((x0, x1)), sorted((y0, y1))
    return Rect(round(x0 - START_X, 3), round(y0 - START_Y, 3), round(x1 - START_X, 3), round(y1 - START_Y, 3))


def _on_wall(what: str, x: float, y: float, width: float, bottom: float, top: float) -> Dressing:
    return Dressing(what, x - START_X, y - START_Y, width, bottom, top)


def _stands(
    name: str, what: What, x: float, y: float, size: tuple[float, float, float], degrees: float = 0.0
) -> Thing:
    return furniture(name, what, x - START_X, y - START_Y, size, degrees)


FREE = tuple(
    _at(*corners)
    for corners in (
        # the ring of corridors, 1.8 m wide, and the hall that opens into its south-west
        (4.65, 4.3, 20.35, 6.1),
        (4.65, 12.0, 20.35, 13.8),
        (4.65, 4.3, 6.45, 13.8),
        (18.55, 4.3, 20.35, 13.8),
        (6.45, 4.3, 11.6, 8.9),
        # rooms, counter-clockwise from the south-west, each with its opening to the corridor
        (0.0, 0.0, 5.4, 4.15),
        (5.55, 0.0, 12.4, 4.15),
        (12.55, 0.0, 18.4, 4.15),
        (18.55, 0.0, 25.0, 4.15),
        (20.5, 4.3, 25.0, 9.2),
        (20.5, 9.35, 25.0, 13.8),
        (16.6, 13.95, 25.0, 18.0),
        (8.9, 13.95, 16.45, 18.0),
        (0.0, 13.95, 8.75, 18.0),
        (0.0, 9.2, 4.5, 13.8),
        (0.0, 4.3, 4.5, 9.05),
        (13.0, 7.1, 17.6, 11.0),
        # openings
        (4.65, 4.15, 5.35, 4.3),
        (9.6, 4.15, 10.6, 4.3),
        (14.2, 4.15, 15.2, 4.3),
        (19.0, 4.15, 20.0, 4.3),
        (20.35, 7.2, 20.5, 8.2),
        (20.35, 11.0, 20.5, 12.0),
        (17.3, 13.8, 18.3, 13.95),
        (12.1, 13.8, 13.1, 13.95),
        (6.6, 13.8, 7.6, 13.95),
        (4.5, 10.9, 4.65, 11.9),
        (4.5, 6.9, 4.65, 7.9),
        (14.9, 6.1, 15.9, 7.1),
        # closed doors, set back
        (8.2, 12.0, 9.1, 11.88),
        (18.55, 9.0, 18.43, 9.9),
        (6.45, 10.2, 6.57, 11.1),
        (17.0, 4.3, 17.8, 4.2),
        # niches
        (12.6, 6.1, 13.6, 6.6),
        (11.0, 11.5, 12.4, 12.0),
        (15.4, 11.6, 16.4, 12.0),
        (18.1, 7.3, 18.55, 8.3),
    )
)
SOLID = tuple(
    _at(*corners)
    for corners in (
        (6.45, 8.5, 6.85, 8.9),  # pillars of the hall
        (11.2, 8.5, 11.6, 8.9),
        (9.0, 8.6, 9.4, 8.9),
        (11.3, 6.9, 11.6, 7.3),
        (16.2, 4.3, 16.5, 4.55),  # pilasters of the corridors
        (12.9, 4.3, 13.2, 4.55),
        (20.1, 5.6, 20.35, 5.9),
        (20.1, 10.0, 20.35, 10.3),
        (16.0, 13.55, 16.3, 13.8),
        (10.4, 13.55, 10.7, 13.8),
        (4.65, 12.4, 4.9, 12.7),
        (4.65, 9.2, 4.9, 9.5),
        (24.6, 6.4, 25.0, 6.8),  # pillars of the rooms
        (2.4, 17.6, 2.8, 18.0),
        (12.4, 17.6, 12.8, 18.0),
        (20.8, 17.6, 21.2, 18.0),
        (0.0, 11.2, 0.4, 11.6),
        (8.6, 0.0, 9.0, 0.4),
        (15.3, 0.0, 15.7, 0.4),
        (21.6, 0.0, 22.0, 0.4),
    )
)
ZONES = (
    Zone(_at(-0.2, -0.2, 25.2, 18.2), "sand"),
    Zone(_at(4.6, 4.25, 20.4, 13.85), "mint"),
    Zone(_at(6.4, 6.0, 18.6, 12.05), "brick"),
    Zone(_at(6.5, 6.2, 11.65, 8.95), "mint"),
    Zone(_at(12.9, 7.05, 17.7, 11.1), "slate"),
    Zone(_at(20.45, 4.25, 25.1, 9.25), "mint"),
    Zone(_at(8.85, 13.9, 16.5, 18.1), "slate"),
    Zone(_at(-0.1, 4.25, 4.55, 9.1), "brick"),
)
DRESSINGS = (
    _on_wall("door", 8.65, 11.88, 0.9, 0.0, 2.05),
    _on_wall("door", 18.43, 9.45, 0.9, 0.0, 2.05),
    _on_wall("door", 6.57, 10.65, 0.9, 0.0, 2.05),
    _on_wall("door", 17.4, 4.2, 0.8, 0.0, 2.05),
    _on_wall("poster", 7.6, 8.9, 0.7, 0.7, 1.6),
    _on_wall("board", 10.3, 8.9, 1.2, 0.75, 1.7),
    _on_wall("poster", 11.6, 8.0, 0.6, 0.7, 1.5),
    _on_wall("poster", 7.4, 4.3, 0.6, 0.7, 1.5),
    _on_wall("sign", 9.45, 4.3, 0.12, 1.2, 1.38),
    _on_wall("sign", 14.05, 4.3, 0.12, 1.2, 1.38),
    _on_wall("poster", 18.9, 4.3, 0.5, 0.7, 1.4),
    _on_wall("poster", 14.3, 6.1, 0.6, 0.7, 1.5),
    _on_wall("poster", 20.35, 6.5, 0.6, 0.7, 1.5),
    _on_wall("board", 20.35, 13.0, 1.0, 0.75, 1.7),
    _on_wall("poster", 14.5, 13.8, 0.6, 0.7, 1.5),
    _on_wall("poster", 9.5, 13.8, 0.6, 0.7, 1.5),
    _on_wall("poster", 4.65, 10.2, 0.6, 0.7, 1.5),
    _on_wall("poster", 4.65, 5.6, 0.6, 0.7, 1.5),
    _on_wall("window", 0.0, 6.6, 1.4, 0.9, 2.1),
    _on_wall("window", 0.0, 12.6, 1.2, 0.9, 2.1),
    _on_wall("window", 3.0, 0.0, 1.6, 0.9, 2.1),
    _on_wall("window", 10.6, 0.0, 1.6, 0.9, 2.1),
    _on_wall("window", 17.0, 0.0, 1.4, 0.9, 2.1),
    _on_wall("window", 25.0, 3.0, 1.4, 0.9, 2.1),
    _on_wall("window", 25.0, 8.0, 1.4, 0.9, 2.1),
    _on_wall("window", 25.0, 11.6, 1.4, 0.9, 2.1),
    _on_wall("window", 22.5, 18.0, 1.6, 0.9, 2.1),
    _on_wall("window", 14.5, 18.0, 1.6, 0.9, 2.1),
    _on_wall("window", 5.0, 18.0, 1.6, 0.9, 2.1),
    _on_wall("board", 15.3, 11.0, 1.6, 0.75, 1.8),
)
THINGS = (
    _stands("bench hall", "shelf", 11.38, 7.8, (0.4, 0.7, 1.1)),
    _stands("bin hall", "bin", 6.75, 8.15, (0.28, 0.28, 0.42)),
    _stands("cabinet north corridor", "cabinet", 14.0, 13.6, (0.9, 0.38, 1.2)),
    _stands("cabinet east corridor", "cabinet", 18.74, 6.3, (0.36, 0.9, 1.2)),
    _stands("table south-west", "table", 2.0, 2.0, (1.6, 0.8, 0.74), 8.0),
    _stands("shelf south-west", "shelf", 0.24, 3.2, (0.45, 1.2, 1.9)),
    _stands("table south", "table", 7.6, 1.6, (1.6, 0.8, 0.74)),
    _stands("table south two", "table", 11.0, 1.6, (1.6, 0.8, 0.74), 90.0),
    _stands("cabinet south", "cabinet", 12.15, 3.2, (0.46, 1.0, 1.3)),
    _stands("table lecture", "table", 16.9, 2.2, (1.8, 0.8, 0.74), 90.0),
    _stands("shelf lecture", "shelf", 12.8, 1.4, (0.46, 1.4, 1.9)),
    _stands("crate south-east", "box", 23.2, 1.3, (0.6, 0.5, 0.5), 25.0),
    _stands("table east", "table", 23.0, 7.7, (1.6, 0.8, 0.74), 90.0),
    _stands("cabinet east", "cabinet", 24.76, 5.2, (0.46, 1.0, 1.9)),
    _stands("table north-east", "table", 22.8, 11.4, (1.4, 0.8, 0.74)),
    _stands("round pillar north-east", "pillar", 20.3, 16.0, (0.36, 0.36, 2.7)),
    _stands("table workshop", "table", 23.4, 16.4, (1.8, 0.9, 0.74), 12.0),
    _stands("shelf north", "shelf", 9.14, 16.2, (0.46, 1.6, 1.9)),
    _stands("table north", "table", 13.8, 16.2, (2.0, 0.9, 0.74)),
    _stands("round pillar north-west", "pillar", 4.4, 15.9, (0.36, 0.36, 2.7)),
    _stands("crate north-west", "box", 1.2, 15.0, (0.6, 0.5, 0.5), -20.0),
    _stands("table west", "table", 1.6, 10.4, (1.4, 0.8, 0.74)),
    _stands("cabinet west", "cabinet", 2.2, 8.8, (1.2, 0.46, 1.3)),
    _stands("table block", "table", 15.3, 9.3, (2.2, 1.0, 0.74)),
    _stands("cabinet block", "cabinet", 13.24, 8.6, (0.46, 1.2, 1.9)),
)
FLOOR = World(name="floor", walls=outline(FREE, SOLID), zones=ZONES, dressings=DRESSINGS, things=THINGS)
