"""Zones of the map in use: the pilot keeps out of some and is slow in others, and so is the gate.

A hand that drives is warned at a zone to keep out of, and enters it with a second press.
"""

import asyncio
import math
import time
from dataclasses import dataclass

import msgspec
import numpy as np

from console.access.logins import Person
from console.control.dispatcher import CommandDispatcher
from console.control.lease import Lease
from console.http.problems import Problem
from console.maps.marks import MapMarks, ZoneMark, anchor_at
from console.maps.service import MapService
from console.maps.store import checked_name, key_of
from console.messages.inbound import JogMessage
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from core.errors import BadInput
from core.gate import Twist
from core.message import Array
from core.navigation.zones import KeepOuts, MapZone, SlowZones, ZoneKind, crosses_itself, enclosed_area
from core.pilot.pilot import Pilot
from core.pipelines.nav2_map import OCCUPIED_VALUE, UNKNOWN_VALUE, Nav2Cells, read_nav2_zip
from core.pipelines.nav2_masks import SpeedType, beside, keep_out_polygons, mask_files, slow_polygons
from core.sensors import SensorFrame
from core.sentences import Statement
from core.snapshot import Snapshot

MAX_ZONES, MAX_CORNERS = 200, 200
MIN_AREA_M2 = 0.01
MAX_SLOW_SHARE = 0.95  # of the robot's largest speed, above which a slow zone slows nothing
MAX_KEPT_OUT_SHARE = 0.5  # of a mask, from which black and white may be exchanged
MIN_SLOW_SPEED_M_S, MAX_SLOW_SPEED_M_S = 0.02, 1.0
CAP_PERIOD_S = 0.25  # between two caps: a gate that was started again has forgotten the last one
WARNED_S = 15.0  # for which another press may enter the zone that a hand was warned of


@dataclass(frozen=True)
class MaskReading:
    """How to read a mask of Nav2: what it is for, and the fields of its filter info."""

    kind: ZoneKind
    type: SpeedType = 1  # of a slow one: 1 % of the robot's largest speed, 2 m/s
    base: float = 100.0
    multiplier: float = -1.0


class ZoneService(Part):
    """Lives on the event loop."""

    def __init__(self, maps: MapService, robot: RobotSupervisor, dispatcher: CommandDispatcher, lease: Lease) -> None:
        self.zones: tuple[MapZone, ...] = ()  # where they are now
        self._maps, self._robot, self._dispatcher, self._lease = maps, robot, dispatcher, lease
        self._keep_outs, self._slow_zones = KeepOuts(), SlowZones()
        self._cap: float | None = None
        self._capped_at = -math.inf  # [s]
        self._warned: tuple[str, int, float] | None = None  # of which zone, by which press, when [s]
        dispatcher.hand_warning = self._hand_warning
        maps.when_marked.append(self._refresh)

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        cap = self._cap_at(snapshot)
        now = time.monotonic()
        if cap == self._cap and (not self._slow_zones.zones or now - self._capped_at < CAP_PERIOD_S):
            return
        self._cap, self._capped_at = cap, now
        self._robot.cap(cap)

    def equip(self, pilot: Pilot) -> None:
        pilot.heed(self._keep_outs, self._slow_zones)

    async def add(self, mark: ZoneMark, who: Person) -> MapZone:
        """Draw a zone. Raises BadInput, Problem 409, 503, Refused, Unwritable."""
        self._lease.check_not_anothers(who)
        drawn = self._checked(mark, who)
        self._check_drawn(np.array(drawn.points_m))

        await self._maps.mark(lambda marks: _with_zones(marks, [drawn]), f"zone {drawn.name}", who)
        self._stop_inside(drawn.name)
        return next(zone for zone in self.zones if zone.name == drawn.name)

    async def masks(self) -> dict[str, bytes]:
        """All zones as the files of Nav2's filter masks, on the lattice of the map. Raises Problem 503."""
        zones, grid = self.zones, self._maps.grid
        return await asyncio.to_thread(mask_files, zones, grid)

    async def take_in(self, name: str, packed: bytes, reading: MaskReading, who: Person) -> tuple[list[MapZone], str]:
        """Draw the zones of a mask of Nav2, a zip of YAML and picture → they, and what was left out of it.

        They are called by `name`, with a number behind it from the second on. Raises as `add`.
        """
        self._lease.check_not_anothers(who)
        found, left_out = await asyncio.to_thread(self._polygons, packed, reading)
        if not found:
            raise BadInput(Statement("zones.empty_mask"))
        outside = sum(beside(ring, self._maps.grid) for ring, _ in found)
        if outside == len(found):
            raise BadInput(Statement("zones.mask_outside"))
        if outside:
            left_out = _joined(left_out, Statement("zones.mask_partly_outside", some=outside, all=len(found)))
        named = [name if number == 0 else f"{name} {number + 1}" for number in range(len(found))]
        marks = [
            self._checked(ZoneMark(one, reading.kind, tuple(map(tuple, ring.tolist())), speed), who)
            for one, (ring, speed) in zip(named, found, strict=True)
        ]
        before = {zone.name for zone in self.zones}
        await self._maps.mark(lambda kept: _with_zones(kept, marks), f"zones {name}: {len(marks)} of a mask", who)
        drawn = [zone for zone in self.zones if zone.name not in before]
        self._stop_inside(*(zone.name for zone in drawn))
        return drawn, left_out

    def _polygons(self, packed: bytes, reading: MaskReading) -> tuple[list[tuple[Array, float | None]], str]:
        mask = read_nav2_zip(packed)
        if reading.kind == "keep_out":
            rings, between = keep_out_polygons(mask)
            left_out = Statement("zones.mask_between", cells=between) if between else _unknown(mask)
            share = float((mask.values == OCCUPIED_VALUE).mean())
            inverted = (
                Statement("zones.mask_mostly", share=f"{100 * share:.0f}") if share > MAX_KEPT_OUT_SHARE else ""
            )
            return [(ring, None) for ring in rings], _joined(inverted, left_out, mask.remark)
        largest = self._robot.profile.max_speed
        slow, without = slow_polygons(mask, reading.type, reading.base, reading.multiplier, largest)
        limits: list[tuple[Array, float | None]] = [
            (ring, round(min(speed, MAX_SLOW_SPEED_M_S), 4)) for ring, speed in slow
        ]
        left_out = Statement("zones.mask_unlimited", cells=without) if without else _unknown(mask)
        fast = sum(speed > MAX_SLOW_SHARE * largest for _, speed in slow)
        no_slower = Statement("zones.mask_no_slower", some=fast, most=f"{largest:g}") if fast else ""
        return limits, _joined(no_slower, left_out, mask.remark)

    async def remove(self, name: str, who: Person) -> None:
        """Remove a zone. Raises Problem 404, 503, Refused, Unwritable."""
        self._lease.check_not_anothers(who)
        gone = next((one.name for one in self._maps.marks.zones if key_of(one.name) == key_of(name)), None)
        if gone is None:
            raise Problem(404, Statement("zones.gone"))
        await self._maps.mark(lambda marks: marks.without("zones", gone), f"zone {name} removed", who)

    # steps of the above

    def _refresh(self) -> None:
        self.zones = tuple(one.now(self._maps.submaps) for one in self._maps.marks.zones)
        self._keep_outs = KeepOuts(tuple(zone for zone in self.zones if zone.kind == "keep_out"))
        self._slow_zones = SlowZones(tuple(zone for zone in self.zones if zone.kind == "slow"))
        if self._dispatcher.pilot is not None:
            self._dispatcher.pilot.heed(self._keep_outs, self._slow_zones)

    def _cap_at(self, snapshot: Snapshot) -> float | None:
        """The cap [m/s] of the gate where the robot is: commands keep to it by themselves, a hand does not."""
        pose = snapshot.estimate.pose if snapshot.floor.lost is None else None
        profile = self._robot.profile
        return self._slow_zones.cap(pose, profile.radius, profile.max_speed)

    def _stop_inside(self, *names: str) -> None:
        """A command whose way may lead through a new zone ends: it was planned without it."""
        if any(zone.name in names for zone in self._keep_outs.zones):
            self._dispatcher.cancel("cancelled", Statement("zones.drawn"))

    def _hand_warning(self, jog: JogMessage) -> str:
        """Why this press of a hand must not go on; "": it may."""
        if not self._keep_outs.zones:
            return ""
        pose, now = self._maps.snapshot.estimate.pose, time.monotonic()
        zone = self._keep_outs.ahead(pose, Twist(jog.v, jog.w), self._robot.profile.radius)
        if zone is None:
            return ""
        warned = self._warned
        if warned is not None and warned[0] == zone.name and warned[1] != jog.press and now - warned[2] < WARNED_S:
            self._warned = (zone.name, warned[1], now)
            return ""
        if warned is None or warned[:2] != (zone.name, jog.press):
            self._warned = (zone.name, jog.press, now)
        return Statement("zones.press_again", name=zone.name)

    def _check_drawn(self, points: Array) -> None:
        """Raise BadInput, Problem 422 for corners (N, 2) [m], world, of a zone that people cannot have meant."""
        self._maps.check_near(points)
        if crosses_itself(points):
            raise BadInput(Statement("zones.crossed"))
        if enclosed_area(points) < MIN_AREA_M2:
            raise BadInput(Statement("zones.small"))

    def _checked(self, mark: ZoneMark, who: Person) -> ZoneMark:
        """A zone as it is kept. Raises BadInput."""
        points = np.array(mark.points_m, float).reshape(-1, 2)
        if not 3 <= len(points) <= MAX_CORNERS or not np.isfinite(points).all():
            raise BadInput(Statement("zones.corners", most=MAX_CORNERS))
        speed = checked_speed(mark.kind, mark.max_speed_m_s)
        rounded = tuple((round(float(a), 3), round(float(b), 3)) for a, b in points)
        anchor = anchor_at(points, self._maps.snapshot.floor.submaps)
        return ZoneMark(checked_name(mark.name), mark.kind, rounded, speed, anchor, who.name)


def _unknown(mask: Nav2Cells) -> str:
    """A sentence on the cells that have no value, where that is not the ground of the mask; "": there are none."""
    count = int((mask.values == UNKNOWN_VALUE).sum())
    return Statement("zones.mask_unknown", cells=count) if 0 < 2 * count < mask.values.size else ""


def _joined(*sentences: str) -> str:
    """The sentences that are there, one behind the other; a lone one keeps its code."""
    there = [one for one in sentences if one]
    return there[0] if len(there) == 1 else " ".join(there)


def _with_zones(marks: MapMarks, drawn: list[ZoneMark]) -> MapMarks:
    """The marks with more zones. Raises Problem 409."""
    if len(marks.zones) + len(drawn) > MAX_ZONES:
        raise Problem(409, Statement("zones.full", most=MAX_ZONES))
    taken = {key_of(one.name) for one in marks.zones}
    if any(key_of(one.name) in taken for one in drawn):
        raise Problem(409, Statement("zones.taken"))
    return msgspec.structs.replace(marks, zones=(*marks.zones, *drawn))


def checked_speed(kind: ZoneKind, speed: float | None) -> float | None:
    """The speed [m/s] of a zone of that kind. Raises BadInput."""
    if kind == "keep_out":
        return None
    if speed is None or not MIN_SLOW_SPEED_M_S <= speed <= MAX_SLOW_SPEED_M_S:
        raise BadInput(Statement("zones.speed", least=MIN_SLOW_SPEED_M_S, most=MAX_SLOW_SPEED_M_S))
    return speed
