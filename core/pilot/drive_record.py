"""Between the pilot's values and their record in a recording: what it took with a frame, and what it made of it."""

import hashlib
from collections.abc import Iterable

import msgspec
import numpy as np

from core.message import Array, listed
from core.perception.landmarks.edges import ImageEdge
from core.pilot.trail import NO_POINTS
from core.recording import frame_record
from core.robots import Profile
from core.robots.profile_json import profile_from_json, profile_to_json
from core.sensors import SensorFrame
from core.slam.estimate import Landmark
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import ActiveCommandStatus, PilotAct, PilotInputs, Snapshot, VoiceDirection

DIGEST_LETTERS = 16
MAP_NAME = "of the recording"


def record_of(
    snapshot: Snapshot, gate: str, operator: str, *, map_is_new: bool, view_is_new: bool
) -> frame_record.FrameRecord:
    """A frame and what was made of it. Landmarks and map are written where the map has changed."""
    inputs = snapshot.inputs or PilotInputs(frame=SensorFrame(stamp=snapshot.stamp))
    view, hearing, command, lost = snapshot.view, snapshot.hearing, snapshot.active_command, snapshot.floor.lost
    results = frame_record.ResultRecord(
        pose=frame_record.row_of(snapshot.estimate.pose),
        covariance=_numbers(snapshot.estimate.covariance),
        dead_reckoning=frame_record.row_of(snapshot.dead_reckoning.pose),
        velocity=(snapshot.velocity.v, snapshot.velocity.w),
        gate=gate,
        operator=operator,
        command=None if command is None else _built(command),
        endings=tuple(map(_built, snapshot.endings)),
        voices=() if hearing is None else tuple(map(_built, hearing.voices)),
        edges=tuple(map(_edge, view.edges)) if view is not None and view_is_new else None,
        landmarks=tuple(map(_landmark, snapshot.landmarks)) if map_is_new else None,
        map_digest=digest_of(snapshot.grid) if map_is_new else "",
        goal=None if snapshot.goal is None else _numbers(snapshot.goal),
        path=tuple(map(_numbers, snapshot.path)),
        lost="" if lost is None else lost.words,
    )
    taken = frame_record.TakenRecord(inputs.first, inputs.deaf, inputs.doing, tuple(map(_act, inputs.acts)))
    return frame_record.FrameRecord.of(inputs.frame, taken, results)


def digest_of(grid: OccupancyGrid) -> str:
    """The grid's fingerprint, to the last bit."""
    hashed = hashlib.sha256(np.ascontiguousarray(grid.log_odds).tobytes())
    hashed.update(np.array([*grid.origin, grid.resolution], float).tobytes())
    return hashed.hexdigest()[:DIGEST_LETTERS]


def inputs_of(frame: SensorFrame, taken: frame_record.TakenRecord) -> PilotInputs:
    """A recorded frame with what the pilot took beside it. Raises BadInput."""
    acts = tuple(_act_again(act) for act in taken.acts)
    return PilotInputs(frame=frame, deaf=taken.deaf, doing=taken.doing, acts=acts, first=taken.first)


def _act(act: PilotAct) -> frame_record.TakenAct:
    match act:
        case SavedMap():
            return frame_record.MapAct(act.to_bytes())
        case Profile():
            return frame_record.UsedAct(profile_to_json(act))
        case _:
            return act


def _act_again(act: frame_record.TakenAct) -> PilotAct:
    match act:
        case frame_record.MapAct(content):
            return SavedMap.from_bytes(content, MAP_NAME)
        case frame_record.UsedAct(profile):
            return profile_from_json(profile)
        case frame_record.PlaceAct() | frame_record.ClosureAct() | frame_record.EditAct() | frame_record.TurnAct():
            return act


def _built(value: object) -> dict[str, object]:
    return msgspec.to_builtins(value, enc_hook=listed)


def _numbers(values: Array) -> tuple[float, ...]:
    return tuple(values.ravel().tolist())


def _edge(edge: ImageEdge) -> tuple[float, ...]:
    return (*_numbers(edge.top), *_numbers(edge.bottom), float(edge.bearing), float(edge.matched), float(edge.step))


def _landmark(row: Landmark) -> tuple[float | str, ...]:
    return (row.id, *_numbers(row.position), *_numbers(row.covariance), row.hits, row.misses, row.kind)


# back


def edges_of(rows: Iterable[tuple[float, ...]]) -> tuple[ImageEdge, ...]:
    """The edges of a picture, as they were drawn that day."""
    return tuple(
        ImageEdge(top=np.array(row[:2]), bottom=np.array(row[2:4]), bearing=row[4], matched=bool(row[5]), step=row[6])
        for row in rows
    )


def landmarks_of(rows: Iterable[tuple[float | str, ...]]) -> tuple[Landmark, ...]:
    """The landmarks, as they were that day."""
    found: list[Landmark] = []
    for row in rows:
        number, x, y, xx, xy, yx, yy, hits, misses, kind = row
        found.append(
            Landmark(
                id=int(number),
                position=np.array([x, y], float),
                covariance=np.array([[xx, xy], [yx, yy]], float),
                hits=int(hits),
                misses=int(misses),
                kind=str(kind),
            )
        )
    return tuple(found)


def command_of(row: dict[str, object] | None) -> ActiveCommandStatus | None:
    """The command that ran."""
    return None if row is None else msgspec.convert(row, ActiveCommandStatus)


def voices_of(rows: Iterable[dict[str, object]]) -> tuple[VoiceDirection, ...]:
    """The directions of voices."""
    return tuple(msgspec.convert(row, VoiceDirection, dec_hook=lambda _, value: np.array(value)) for row in rows)


def path_of(rows: tuple[tuple[float, ...], ...]) -> Array:
    """The planned path (P, 2) [m]."""
    return np.array(rows, float).reshape(-1, 2) if rows else NO_POINTS
