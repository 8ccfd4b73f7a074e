"""Places in which a laser finds little to hold on to: a corridor without corners, the same bare, a glazed hall."""

from core.simulation.world.objects import furniture
from core.simulation.world.plan import Dressing, Rect, World, Zone, outline

HALF_WIDTH_M = 1.0  # from the middle of the corridor to either wall
# its ends are out of the laser's sight from where the robot drives
ALONG = Rect(-8.0, -HALF_WIDTH_M, 18.0, HALF_WIDTH_M)
ON_WALLS = (
    Dressing("door", -1.6, HALF_WIDTH_M, 0.9, 0.0, 2.05),
    Dressing("poster", 0.4, HALF_WIDTH_M, 0.6, 0.4, 1.4),
    Dressing("sign", 1.5, HALF_WIDTH_M, 0.12, 0.2, 0.9),
    Dressing("board", 3.1, HALF_WIDTH_M, 1.2, 0.3, 1.6),
    Dressing("door", 5.2, HALF_WIDTH_M, 0.9, 0.0, 2.05),
    Dressing("poster", 6.9, HALF_WIDTH_M, 0.5, 0.4, 1.4),
    Dressing("poster", 8.6, HALF_WIDTH_M, 0.7, 0.4, 1.4),
    Dressing("door", 10.4, HALF_WIDTH_M, 0.9, 0.0, 2.05),
    Dressing("poster", 12.3, HALF_WIDTH_M, 0.6, 0.4, 1.4),
    Dressing("poster", -0.7, -HALF_WIDTH_M, 0.7, 0.4, 1.4),
    Dressing("door", 1.2, -HALF_WIDTH_M, 0.9, 0.0, 2.05),
    Dressing("poster", 2.9, -HALF_WIDTH_M, 0.5, 0.4, 1.4),
    Dressing("sign", 4.1, -HALF_WIDTH_M, 0.12, 0.2, 0.9),
    Dressing("board", 5.8, -HALF_WIDTH_M, 1.0, 0.3, 1.6),
    Dressing("door", 8.0, -HALF_WIDTH_M, 0.9, 0.0, 2.05),
    Dressing("poster", 9.7, -HALF_WIDTH_M, 0.6, 0.4, 1.4),
    Dressing("door", 11.6, -HALF_WIDTH_M, 0.9, 0.0, 2.05),
)
CORRIDOR = World(
    name="corridor", walls=outline((ALONG,)), zones=(Zone(Rect(-9.0, -2.0, 19.0, 2.0), "mint"),), dressings=ON_WALLS
)
BARE = World(name="bare", walls=outline((ALONG,)), zones=(Zone(Rect(-9.0, -2.0, 19.0, 2.0), "mint"),))
HALL = Rect(-2.0, -3.0, 6.0, 3.0)
GLAZED = tuple(Dressing("window", x, y, 1.5, 0.1, 2.4) for y in (-3.0, 3.0) for x in (-1.0, 0.9, 2.8, 4.9)) + tuple(
    Dressing("window", x, y, 1.5, 0.1, 2.4) for x in (-2.0, 6.0) for y in (-2.0, 0.2, 2.0)
)
GLASS = World(
    name="glass",
    walls=outline((HALL,)),
    zones=(Zone(Rect(-3.0, -4.0, 7.0, 4.0), "slate"),),
    dressings=GLAZED,
    things=(furniture("bin", "bin", 4.6, 2.4, (0.28, 0.28, 0.42)),),
    glass=(Rect(-2.1, -3.1, 6.1, 3.1),),
)
