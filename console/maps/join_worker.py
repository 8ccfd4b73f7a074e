"""The worker that finds one saved map in another and joins both: minutes of searching, killed when given up."""

from pathlib import Path

import msgspec

from console.maps.export import overlay
from console.workers.job import job
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map_join import MapMatch, grid_of, join_maps, match_maps
from core.slam.submap_manager import MapperSettings


class DrawnMatch(msgspec.Struct, frozen=True):
    """The place of the newer map in the older one, and both over each other."""

    found: MapMatch
    picture: bytes  # PNG


class JoinedMap(msgspec.Struct, frozen=True):
    saved: SavedMap
    grid: OccupancyGrid
    older_submaps: int  # those of the newer map stand behind them


class TwoMaps(msgspec.Struct, frozen=True):
    older: str  # folder of a SavedMap
    newer: str
    parts: MapperSettings

    def read(self) -> tuple[SavedMap, SavedMap]:
        """The older and the newer map. Raises BadInput."""
        return SavedMap.from_files(Path(self.older)), SavedMap.from_files(Path(self.newer))


class JoinWorker:
    """Remembers nothing from one job to the next."""

    @job
    def match(self, maps: TwoMaps) -> DrawnMatch:
        """Find where the newer map lies in the older one. Raises BadInput."""
        older, newer = maps.read()
        found = match_maps(older, newer, maps.parts)
        return DrawnMatch(found, overlay(grid_of(older, maps.parts), grid_of(newer, maps.parts), found.pose))

    @job
    def join(self, maps: TwoMaps, found: MapMatch) -> JoinedMap:
        """Join two maps where they were found to lie. Raises BadInput."""
        older, newer = maps.read()
        saved = join_maps(older, newer, found, maps.parts)
        return JoinedMap(saved, grid_of(saved, maps.parts), older.submaps)
