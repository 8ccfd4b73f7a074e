"""The paper's structured telecommunication laboratory (section 6.2): one room with niches, pillars and furniture."""

from core.simulation.world.objects import furniture
from core.simulation.world.plan import Dressing, Rect, World, Zone, outline

FREE = (
    Rect(-2.5, -2.5, 5.5, 3.5),
    Rect(-1.0, -2.62, -0.1, -2.5),  # door to the south
    Rect(1.2, -3.0, 2.4, -2.5),  # niche in the south
    Rect(5.5, 0.9, 5.62, 1.8),  # door to the east
    Rect(1.7, 3.5, 3.2, 3.95),  # niche in the north, with the board
    Rect(-2.95, 1.0, -2.5, 2.2),  # niche in the west
)
SOLID = (
    Rect(3.7, -2.5, 4.1, -2.05),  # pillars of the south, east, north and west wall
    Rect(5.05, -0.6, 5.5, -0.2),
    Rect(0.0, 3.1, 0.4, 3.5),
    Rect(-2.5, -1.3, -2.1, -0.9),
    Rect(4.7, 2.6, 5.5, 3.5),  # shaft in the north-east corner
)
ZONES = (
    Zone(Rect(-3.0, -3.1, 5.7, 4.0), "mint"),
    Zone(Rect(5.4, -3.1, 5.7, 4.0), "brick"),
    Zone(Rect(-3.0, 3.45, 5.7, 3.55), "sand"),
    Zone(Rect(1.6, 3.5, 3.3, 4.0), "slate"),
    Zone(Rect(-2.6, -3.1, 5.7, -2.4), "sand"),
    Zone(Rect(1.1, -3.1, 2.5, -2.55), "brick"),
    Zone(Rect(3.6, -2.6, 4.2, -2.0), "slate"),
    Zone(Rect(5.0, -0.7, 5.45, -0.1), "slate"),
    Zone(Rect(-0.1, 3.0, 0.5, 3.45), "slate"),
    Zone(Rect(-2.45, -1.4, -2.0, -0.8), "slate"),
    Zone(Rect(4.6, 2.5, 5.45, 3.45), "slate"),
    Zone(Rect(-3.0, 0.9, -2.55, 2.3), "brick"),
)
DRESSINGS = (
    Dressing("door", -0.55, -2.62, 0.9, 0.0, 2.05),
    Dressing("door", 5.62, 1.35, 0.9, 0.0, 2.05),
    Dressing("board", 2.45, 3.95, 1.2, 0.75, 1.75),
    Dressing("poster", 1.05, 3.5, 0.55, 0.75, 1.55),
    Dressing("poster", 4.0, 3.5, 0.6, 0.7, 1.5),
    Dressing("poster", 5.5, 2.28, 0.42, 0.75, 1.4),
    Dressing("window", 5.5, 0.35, 0.8, 0.95, 2.0),
    Dressing("poster", 0.55, -2.5, 0.6, 0.7, 1.5),
    Dressing("board", 3.05, -2.5, 1.0, 0.8, 1.7),
    Dressing("window", -2.5, 0.2, 1.1, 0.9, 2.0),
    Dressing("poster", -2.5, 2.8, 0.6, 0.75, 1.55),
    Dressing("sign", 0.0, -2.5, 0.12, 1.2, 1.38),
    Dressing("sign", 5.5, 1.88, 0.12, 1.2, 1.38),
)
THINGS = (
    furniture("cabinet north", "cabinet", -1.4, 3.27, (1.0, 0.46, 1.25)),
    furniture("cabinet east", "cabinet", 5.26, -1.5, (0.48, 0.8, 1.9)),
    furniture("shelf south-west", "shelf", -2.28, -2.05, (0.44, 0.9, 1.8)),
    furniture("crate", "box", 3.75, 2.45, (0.5, 0.4, 0.45), degrees=35.0),
    furniture("round pillar", "pillar", -1.5, 1.75, (0.3, 0.3, 2.7)),
    furniture("square pillar", "cabinet", 4.2, 0.65, (0.4, 0.4, 2.7), degrees=20.0, look="column"),
    furniture("bench", "table", 3.1, -1.35, (1.3, 0.65, 0.74), degrees=-4.0),
    furniture("stool", "stool", 2.15, -1.55, (0.34, 0.34, 0.48)),
    furniture("bin", "bin", 4.5, -2.25, (0.28, 0.28, 0.42)),
)
LAB = World(name="lab", walls=outline(FREE, SOLID), zones=ZONES, dressings=DRESSINGS, things=THINGS)
