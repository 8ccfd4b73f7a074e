"""People who stand in the simulated room from the first second: someone to come to, and someone who is not meant.

They stand free, a metre and a half from the robot's ways from the start, and hide no corner of the start's map.
"""

import asyncio
import logging
import math
from collections.abc import Awaitable, Callable, Mapping

from core.errors import BadInput, Refused, Unavailable
from core.robots.requests import PlacedThing, PlaceThing

log = logging.getLogger(__name__)

ANN = PlaceThing("person", 2.0, 1.2, math.pi, id="Ann", clothes="red/blue")
INHABITANTS: Mapping[str, tuple[PlaceThing, ...]] = {
    "sim:lab": (ANN, PlaceThing("person", 2.0, -1.0, math.pi, id="Bob", clothes="green/black")),
    "sim:floor": (
        ANN,
        PlaceThing(
            "person",
            -1.5,
            1.5,
            id="Bob",
            clothes="green/black",
            path_m=((2.5, 2.0), (2.5, 2.5), (-1.0, 2.5), (-1.5, 1.5)),
            speed_m_s=0.5,
            again=True,
        ),
    ),
}
MAX_TRIES, RETRY_PAUSE_S = 60, 1.0  # the robot may come later than the console; [s]


async def move_in(place: Callable[[PlaceThing], Awaitable[PlacedThing]], url: str) -> None:
    """Put the inhabitants of a simulated world into it, each once; who does not fit there stays out."""
    for person in INHABITANTS.get(url, ()):
        for _ in range(MAX_TRIES):
            try:
                await place(person)
                break
            except Unavailable:  # the driver has not begun yet
                await asyncio.sleep(RETRY_PAUSE_S)
            except (BadInput, Refused) as misfit:
                log.info("%s stays out of %s: %s", person.id, url, misfit)
                break
