"""Named places of the map in use: made, renamed and removed by people; words and ears know their names at once."""

import contextlib
import math
from collections.abc import Callable

import msgspec
import numpy as np

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.http.problems import Problem
from console.maps.marks import MapMarks, PlaceMark, anchor_at, renamed
from console.maps.service import MapService
from console.part import Part
from core.errors import BadInput
from core.geometry import wrap
from core.navigation.places import NamedPlace
from core.navigation.planner import PlannerSettings
from core.navigation.zones import roomiest_spot
from core.sentences import Statement
from core.speech.understanding.place_names import MAX_PLACES, check_name_apart, place_phrases, spoken_name, tidy_name

MAX_ROOM_CORNERS = 200
WALL_NEAR_M = 1.0
LOST = Statement("places.lost")

Outline = tuple[tuple[float, float], ...]


class PlaceService(Part):
    """Lives on the event loop."""

    def __init__(self, maps: MapService, dispatcher: CommandDispatcher) -> None:
        self.places: tuple[NamedPlace, ...] = ()  # where they are now
        self.when_changed: list[Callable[[tuple[NamedPlace, ...]], None]] = []
        self.when_renamed: list[Callable[[dict[str, str]], None]] = []  # called with the new name of each
        self._maps, self._dispatcher = maps, dispatcher
        maps.when_marked.append(self._refresh)

    def find(self, name: str) -> NamedPlace:
        """The place of this name, however it is written. Raises Problem 404."""
        found = next((one for one in self.places if _key(one.name) == _key(name)), None)
        if found is None:
            raise Problem(404, Statement("places.gone"))
        return found

    async def add(
        self, name: str, at: tuple[float, float] | None, heading: float | None, who: Person, outline: Outline = ()
    ) -> NamedPlace:
        """Name a place at (x, y) [m], world, or where the robot is; `heading` [rad] to look there, or None.

        A room has an `outline`: corners [m], world; the robot goes where there is most room in it. Raises BadInput
        with the pair where the name sounds like other words; Problem 409, 422, 503; Unwritable.
        """
        x, y = self._spot_in(outline) if outline else at or self._here()
        mark = self._placed(PlaceMark(tidy_name(name), x, y, heading, by=who.name, outline_m=outline))

        def change(marks: MapMarks) -> MapMarks:
            if len(marks.places) >= MAX_PLACES:
                raise Problem(409, Statement("places.full", most=MAX_PLACES))
            self._check_name(mark.name, marks.places)
            return msgspec.structs.replace(marks, places=(*marks.places, mark))

        await self._maps.mark(change, f"place {mark.name}", who)
        return self.find(mark.name)

    async def change(
        self,
        name: str,
        who: Person,
        *,
        to_name: str | None,
        at: tuple[float, float] | None,
        heading: float | None,
        turned: bool,
    ) -> NamedPlace:
        """Rename or move a place; `turned`: `heading` is new, None for no heading any more. Raises as `add`, 404."""
        old = self.find(name)
        wanted = old.name if to_name is None else tidy_name(to_name)
        names = {old.name: wanted}
        back = dict[str, str]()  # the former name, where routes follow the new one

        def change(marks: MapMarks) -> MapMarks:
            now = self.find(old.name)  # others may have changed it since
            x, y = at or (now.x_m, now.y_m)
            looks = heading if turned else now.heading_rad
            mark = self._placed(PlaceMark(wanted, x, y, looks, by=who.name, outline_m=now.outline_m))
            if wanted != old.name:
                self._check_name(wanted, [one for one in marks.places if one.name != old.name])
            places = tuple(mark if one.name == old.name else one for one in marks.places)
            routes = tuple(renamed(one, one.name, names) for one in marks.routes)
            back[wanted] = old.name
            self._announce_renamed(names)  # the place has its new name before that is on the disk
            return msgspec.structs.replace(marks, places=places, routes=routes)

        try:
            await self._maps.mark(change, f"place {old.name}: {wanted}", who)
        except BaseException:
            self._announce_renamed(back)
            raise
        return self.find(wanted)

    async def remove(self, name: str, who: Person) -> None:
        """Forget a place. Raises Problem 404, 503, Unwritable."""
        old = self.find(name)
        await self._maps.mark(lambda marks: marks.without("places", old.name), f"place {old.name} removed", who)

    def wall_near(self, place: NamedPlace) -> float | None:
        """Distance [m] from a place to the nearest wall of the map; None: none within `WALL_NEAR_M`."""
        grid = self._maps.grid
        cells = np.argwhere(grid.log_odds > PlannerSettings.occupied)[:, ::-1]  # (N, 2) column, row
        away = grid.origin + grid.resolution * (cells + 0.5) - (place.x_m, place.y_m)
        nearest = float(np.hypot(*away.T).min(initial=math.inf))
        return round(nearest, 2) if nearest <= WALL_NEAR_M else None

    # steps of the above

    def _announce_renamed(self, names: dict[str, str]) -> None:
        for tell in self.when_renamed:
            tell(names)

    def _refresh(self) -> None:
        self.places = tuple(one.now(self._maps.submaps) for one in self._maps.marks.places)
        known = (*self.places, *_spoken_routes(self._maps.marks))
        self._dispatcher.know_places(place_phrases(known))
        for tell in self.when_changed:
            tell(known)

    def _spot_in(self, outline: Outline) -> tuple[float, float]:
        """Return the spot to which the robot goes in a room. Raises BadInput."""
        points = np.array(outline, float).reshape(-1, 2)
        if not 3 <= len(points) <= MAX_ROOM_CORNERS or not np.isfinite(points).all():
            raise BadInput(Statement("places.corners", most=MAX_ROOM_CORNERS))
        spot = roomiest_spot(points, self._maps.grid)
        if spot is None:
            raise BadInput(Statement("places.no_floor"))
        return spot

    def _here(self) -> tuple[float, float]:
        """Return the robot's place [m], world. Raises Problem 409 where it does not know it."""
        snapshot = self._maps.snapshot
        if snapshot.floor.lost is not None:
            raise Problem(409, LOST)
        return snapshot.estimate.pose.x, snapshot.estimate.pose.y

    def _placed(self, mark: PlaceMark) -> PlaceMark:
        """The place as it is kept: rounded, and anchored to the map. Raises Problem 422."""
        self._maps.check_near(np.array([(mark.x_m, mark.y_m)]))
        return msgspec.structs.replace(
            mark,
            x_m=round(mark.x_m, 3),
            y_m=round(mark.y_m, 3),
            heading_rad=None if mark.heading_rad is None else round(wrap(mark.heading_rad), 4),
            anchor=anchor_at(np.array([(mark.x_m, mark.y_m)]), self._maps.snapshot.floor.submaps),
            outline_m=tuple((round(float(x), 3), round(float(y), 3)) for x, y in mark.outline_m),
        )

    def _check_name(self, name: str, others: list[PlaceMark] | tuple[PlaceMark, ...]) -> None:
        if any(_key(one.name) == _key(name) for one in others):
            raise Problem(409, Statement("places.taken"))
        check_name_apart(name, [one.name for one in others], self._dispatcher.own_phrases)


def _spoken_routes(marks: MapMarks) -> tuple[NamedPlace, ...]:
    found: list[NamedPlace] = []
    for route in marks.routes:
        with contextlib.suppress(BadInput):
            found.append(NamedPlace(name=tidy_name(route.name), x_m=0.0, y_m=0.0, route=True))
    return tuple(found)


def _key(name: str) -> str:
    return spoken_name(" ".join(name.split()))
