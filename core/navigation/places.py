"""Places that people have named on a map."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class NamedPlace:
    """A place of the map that can be driven to by its name."""

    name: str  # as people write it: "the Kitchen"
    x_m: float  # world
    y_m: float
    heading_rad: float | None = None  # to look in the end; None: as it comes
    route: bool = False  # it is no place, but the name of a route that words start
    outline_m: tuple[tuple[float, float], ...] = ()  # corners of a room, world; its place is where one stands in it
