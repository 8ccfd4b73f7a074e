"""The worker that finds one saved map in another and joins both: minutes of searching, killed when given up."""

from pathlib import Path

import msgspec

from console.maps.export import overlay
from console.workers.job import Job
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


class MatchMaps(Job[DrawnMatch], frozen=True):
    """Find where the newer map lies in the older one. Raises BadInput."""

    older: str  # folder of a SavedMap
    newer: str
    parts: MapperSettings


class JoinMaps(Job[JoinedMap], frozen=True):
    """Join two maps where they were found to lie. Raises BadInput."""

    maps: MatchMaps
    found: MapMatch


class JoinWorker:
    """Remembers nothing from one job to the next."""

    def match(self, job: MatchMaps) -> DrawnMatch:
        older, newer = read(job)
        found = match_maps(older, newer, job.parts)
        return DrawnMatch(found, overlay(grid_of(older, job.parts), grid_of(newer, job.parts), found.pose))

    def join(self, job: JoinMaps) -> JoinedMap:
        older, newer = read(job.maps)
        saved = join_maps(older, newer, job.found, job.maps.parts)
        return JoinedMap(saved, grid_of(saved, job.maps.parts), older.submaps)


def read(maps: MatchMaps) -> tuple[SavedMap, SavedMap]:
    """The older and the newer map. Raises BadInput."""
    return SavedMap.from_files(Path(maps.older)), SavedMap.from_files(Path(maps.newer))
