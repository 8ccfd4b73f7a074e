"""`robot.toml`: what a robot is, where its sensors sit, and how its drivers are reached.

url = "serial:///dev/ttyUSB0+lds:///dev/ttyUSB1?model=LD06"
name = "Marvin"
wheelbase = 0.23

[lasers.laser]
x = 0.08
height = 0.17

[robot]          # the driver's own table: see `beckon robots`
"""

import datetime
import difflib
import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, cast, get_type_hints

import msgspec
import numpy as np

from core.errors import BadInput
from core.files import text_of
from core.geometry import OPTICAL, Pose, Transform, rotation_of_rpy
from core.robots import Capability, Profile
from core.robots.device import Base, Equipment
from core.robots.doubts import MAX_WHEELS_WIDTH, doubts
from core.robots.urdf import Body, load_body
from core.sensors import Camera, Laser
from core.sensors.camera import FLAT_TILT_COSINE, camera_mounting
from core.sensors.laser import flat
from core.sensors.microphones import MicrophoneArray, load_array
from core.sentences import Statement, plain

MAX_ROBOT_FILE_BYTES = 200_000  # bytes of a robot file
FILES_OF_DRIVERS = ("array", "ca", "cert", "key")  # entries of [robot] that may name a file beside the robot file
ChosenRole = Literal[
    "odometry",
    "scan",
    "image",
    "camera_info",
    "sound",
    "cmd_vel",
    "cmd_vel_type",
    "battery",
    "map",
    "pose",
    "description",
]
NOTHING = "none"  # a driver's word for "do not use any"
BARE = re.compile(r"[A-Za-z0-9_-]+")
MAX_TABLE_DEPTH = 8  # tables in tables
MAX_NAME_LETTERS = 100
MAX_BEYOND_M = 1.5  # of a sensor from the rim of the robot
ONLY_WITH_X = ("y", "z", "heading_deg", "yaw_deg", "pitch_deg", "roll_deg")  # entries of a place


def about(meaning: str) -> msgspec.Meta:
    """Meaning of an entry, for the reference page."""
    return msgspec.Meta(description=meaning)


Length = Annotated[float, msgspec.Meta(gt=0.0, le=10.0, extra={"unit": "m"})]
Width = Annotated[float, msgspec.Meta(ge=0.01, le=10.0, extra={"unit": "m"})]
Height = Annotated[float, msgspec.Meta(ge=0.0, le=10.0, extra={"unit": "m"})]
Place = Annotated[float, msgspec.Meta(ge=-10.0, le=10.0, extra={"unit": "m"})]
Angle = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0, extra={"unit": "deg"})]
Speed = Annotated[float, msgspec.Meta(ge=0.01, le=5.0, extra={"unit": "m/s"})]
TurnRate = Annotated[float, msgspec.Meta(ge=0.01, le=20.0, extra={"unit": "rad/s"})]
Rate = Annotated[float, msgspec.Meta(ge=0.05, le=200.0, extra={"unit": "Hz"})]
FrameRate = Annotated[float, msgspec.Meta(ge=5.0, le=100.0, extra={"unit": "Hz"})]
Range = Annotated[float, msgspec.Meta(gt=0.0, le=200.0, extra={"unit": "m"})]
Silence = Annotated[float, msgspec.Meta(ge=0.0, le=60.0, extra={"unit": "s"})]
TimeOffset = Annotated[float, msgspec.Meta(ge=-1.0, le=1.0, extra={"unit": "s"})]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all tables of a robot file: nothing in them is passed over."""


class LaserTable(Table, frozen=True):
    """A laser and its place on the robot. Without x, the driver's own place holds."""

    x: Annotated[Place | None, about("forward; y and heading_deg count only with it")] = None
    y: Annotated[Place, about("to the left")] = 0.0
    heading_deg: Annotated[Angle, about("where its middle looks, counter-clockwise from straight ahead")] = 0.0
    height: Annotated[Length | None, about("of the scanning plane above the floor")] = None
    range_min: Annotated[Length | None, about("nearest range that is a measurement")] = None
    range_max: Annotated[Range | None, about("farthest range that is a measurement")] = None
    rate: Annotated[Rate | None, about("turns of the mirror")] = None
    link: Annotated[str, about("link of the URDF where it sits, instead of x, y, heading_deg and height")] = ""
    time_offset: Annotated[TimeOffset, about("to add to its stamps")] = 0.0


class CameraTable(Table, frozen=True):
    """A camera, its place and its calibration. Without x, the driver's own place and angles hold."""

    x: Annotated[Place | None, about("forward; the other places and the angles count only with it")] = None
    y: Annotated[Place, about("to the left")] = 0.0
    z: Annotated[Height, about("above the floor")] = 0.16
    yaw_deg: Annotated[Angle, about("turned to the left")] = 0.0
    pitch_deg: Annotated[Angle, about("turned downwards")] = 0.0
    roll_deg: Annotated[Angle, about("turned about its own axis, clockwise seen from behind")] = 0.0
    rate: Annotated[Rate | None, about("pictures")] = None
    link: Annotated[str, about("link of the URDF where it sits, instead of the place and the angles")] = ""
    calibration: Annotated[str, about("file of the camera model (JSON or YAML), beside the robot file")] = ""


class MicrophonesTable(Table, frozen=True):
    """A microphone array: its geometry and its place."""

    profile: Annotated[str, about("name of a known array, or a TOML file beside the robot file")] = ""
    x: Annotated[Place, about("forward")] = 0.0
    y: Annotated[Place, about("to the left")] = 0.0
    heading_deg: Annotated[Angle, about("where its +x looks, counter-clockwise from straight ahead")] = 0.0
    height: Annotated[Length, about("above the floor")] = 0.25
    link: Annotated[str, about("link of the URDF where it sits, instead of the place")] = ""


class RobotFile(Table, frozen=True):
    """The robot itself. What is left out is as the driver says it."""

    url: Annotated[str, about("how the robot is reached, see `beckon robots`")] = ""
    name: Annotated[str, about("shown to the operator")] = ""
    radius: Annotated[Width | None, about("of the round footprint")] = None
    wheelbase: Annotated[Width | None, about("between the wheels")] = None
    cruise: Annotated[Speed | None, about("speed of commands")] = None
    max_speed: Annotated[Speed | None, about("the highest speed that is ever asked for")] = None
    max_turn_rate: Annotated[TurnRate | None, about("the highest turn rate that is ever asked for")] = None
    rate: Annotated[FrameRate, about("frames, that is control updates")] = 40.0
    failsafe: Annotated[
        Silence | None,
        about("of the link after which the base stops by itself, 0: never; for robots that do not say it"),
    ] = None
    urdf: Annotated[str, about("file of the robot's URDF, beside the robot file: mountings, looks")] = ""
    lasers: dict[str, LaserTable] = {}
    cameras: dict[str, CameraTable] = {}
    microphones: dict[str, MicrophonesTable] = {}
    robot: dict[str, Any] = {}  # the driver's own


def load_robot_file(path: Path) -> RobotFile:
    """Read a robot file. Raises BadInput with a sentence that names the entry."""
    try:
        if path.stat().st_size > MAX_ROBOT_FILE_BYTES:
            raise BadInput(f"{path.name} is too large for a robot file; some ten lines are expected.")
        text = text_of(path.read_bytes(), path.name)
    except OSError as trouble:
        raise BadInput(f"The robot file {path.name} cannot be read: {trouble.strerror or trouble}.") from None
    return parse_robot_file(text, path.name)


def parse_robot_file(text: str, name: str) -> RobotFile:
    """Read a robot file's text. Raises BadInput with a sentence that begins with `name`."""
    try:
        entries = tomllib.loads(text)
    except (ValueError, RecursionError) as trouble:  # also for numbers of 5,000 digits
        raise BadInput(f"{name} is not valid TOML: {trouble}.") from None
    for kind, table in SENSOR_TABLES.items():  # one by one, so that a sentence says of which sensor it speaks
        sensors = entries.get(kind)
        for sensor, own in sensors.items() if isinstance(sensors, dict) else ():
            converted(own, table, f"{name}, {kind}.{sensor}")
    file = converted(entries, RobotFile, name)
    if not file.name.isprintable() or len(file.name) > MAX_NAME_LETTERS:
        raise BadInput(f"{name}, name: at most {MAX_NAME_LETTERS} letters on one line are expected.")
    if file.radius and file.wheelbase and file.wheelbase > 2 * MAX_WHEELS_WIDTH * file.radius:
        raise BadInput(
            f"{name}: the wheels stand {file.wheelbase:g} m apart (wheelbase) on a robot of {2 * file.radius:g} m "
            "(twice its radius); write both in metres."
        )
    for kind, tables in (("lasers", file.lasers), ("cameras", file.cameras), ("microphones", file.microphones)):
        for sensor, table in tables.items():
            _check_place(f"{name}, {kind}.{sensor}", table)
    return file


def _check_place(where: str, table: LaserTable | CameraTable | MicrophonesTable) -> None:
    """Raise BadInput for entries of a place that would not count."""
    given = [each.name for each in msgspec.structs.fields(table) if getattr(table, each.name) != each.default]
    aside = [one for one in given if one in ONLY_WITH_X]
    if table.link and ("x" in given or aside):
        raise BadInput(
            f"{where}: the link says where it sits, so {', '.join(aside or ['x'])} would not count; remove one."
        )
    if table.x is None and aside and not table.link:
        raise BadInput(f"{where}: {', '.join(aside)} would not count without x; write x = 0.0 if it sits there.")


SENSOR_TABLES: dict[str, type[Table]] = {
    "lasers": LaserTable,
    "cameras": CameraTable,
    "microphones": MicrophonesTable,
}
BOUND = re.compile("[<>]=? ")
UNKNOWN_FIELD = re.compile(r"unknown field `(.*)`")
T = TypeVar("T", bound=msgspec.Struct)
FlatSensor = TypeVar("FlatSensor", Laser, MicrophoneArray)


def converted(entries: Any, into: type[T], name: str) -> T:
    """Entries of a file → the struct. Raises BadInput that names the file, the entry and its value."""
    try:
        return msgspec.convert(entries, into, strict=False)
    except msgspec.ValidationError as trouble:
        words, _, place = str(trouble).partition(" - at `$")
        key = place.rstrip("`").lstrip(".")
        top = "" if "," in name else ", the top of the file"
        where, wrong = f", {key}" if key else top, f"{words[0].lower()}{words[1:]}"
        if unknown := UNKNOWN_FIELD.search(words):
            known = [field.name for field in msgspec.structs.fields(into)]
            close = difflib.get_close_matches(unknown[1].lower(), known, 1)
            wrong += f"; did you mean {close[0]}?" if close else f"; known are {', '.join(known)}"
        value = entries.get(key) if isinstance(entries, dict) else None
        if isinstance(value, int | float) and BOUND.search(words):
            wrong += f"{_unit(into, key)}, got {value:g}"
        raise BadInput(f"{name}{where}: {wrong.removesuffix('?')}{'?' if wrong.endswith('?') else '.'}") from None


def _unit(kind: type[msgspec.Struct], key: str) -> str:
    """The unit that an entry is declared in, to stand behind a number; "" for none."""
    found = re.search(r"'unit': '([^']+)'", str(get_type_hints(kind, include_extras=True).get(key)))
    return f" {found[1]}" if found else ""


def profile_of(equipment: tuple[Equipment, ...], file: RobotFile, url: str, folder: Path = Path()) -> Profile:
    """The devices' equipment and the file → the profile; the file wins. Raises BadInput."""
    base = next((one.base for one in equipment if one.base is not None), None) or Base()
    known = Profile(name="", url="")
    lasers = tuple(laser for one in equipment for laser in one.lasers)
    cameras = tuple(camera for one in equipment for camera in one.cameras)
    arrays = tuple(array for one in equipment for array in one.microphones)
    _all_known("laser", file.lasers, [laser.name for laser in lasers])
    _all_known("camera", file.cameras, [camera.name for camera in cameras])
    _all_known("microphone array", file.microphones, [array.name for array in arrays])

    def first(*values: float | None) -> float:
        return next(value for value in values if value is not None)

    own_body = next((one.body for one in equipment if one.body is not None), None)
    body = load_body(folder / file.urdf) if file.urdf else own_body
    if file.failsafe is not None:
        base = replace(base, failsafe=file.failsafe or None, failsafe_words="")  # 0: it never stops by itself
    max_speed = first(file.max_speed, base.max_speed, known.max_speed)
    profile = Profile(
        name=file.name or equipment[0].name,
        url=url,
        radius=first(file.radius, base.radius, known.radius),
        wheelbase=first(file.wheelbase, base.wheelbase, known.wheelbase),
        cruise=min(first(file.cruise, base.cruise, known.cruise), max_speed),
        max_speed=max_speed,
        max_turn_rate=first(file.max_turn_rate, base.max_turn_rate, known.max_turn_rate),
        rate=file.rate,
        lasers=tuple(_laser(laser, file.lasers.get(laser.name), body) for laser in lasers),
        cameras=tuple(_camera(camera, file.cameras.get(camera.name), folder, body) for camera in cameras),
        arrays=tuple(_array(array, file.microphones.get(array.name), folder, body) for array in arrays),
        odometry=base.odometry,
        shapes=body.shapes if body else (),
        notices=body.notices if body else (),
        failsafe=failsafe_of(base),
        lock=base.lock,
        capabilities=capabilities_of(equipment),
    )
    _check_near(profile, {*file.lasers, *file.cameras, *file.microphones})
    return replace(profile, notices=(*profile.notices, *doubts(file, profile)))


def _check_near(profile: Profile, placed: set[str]) -> None:
    """Raise BadInput where the file puts one of the sensors of these names far from the robot."""
    places = {one.name: (one.mounting.x, one.mounting.y) for one in (*profile.lasers, *profile.arrays)}
    places |= {one.name: one.mounting.translation[:2].tolist() for one in profile.cameras}
    for name in sorted(placed & places.keys()):
        away = math.hypot(*places[name])
        if away > profile.radius + MAX_BEYOND_M:
            raise BadInput(
                f"The robot file puts {name} {away:g} m from the middle of a robot of {profile.radius:g} m radius; "
                "write its place (or the URDF) in metres, or the radius."
            )


def absolute(file: RobotFile, folder: Path) -> RobotFile:
    """The same file with absolute paths, so that it may stand in another folder than `folder`."""
    cameras = {
        name: msgspec.structs.replace(table, calibration=str((folder / table.calibration).resolve()))
        if table.calibration
        else table
        for name, table in file.cameras.items()
    }
    microphones = {
        name: msgspec.structs.replace(table, profile=str((folder / table.profile).resolve()))
        if table.profile and (folder / table.profile).exists()
        else table
        for name, table in file.microphones.items()
    }
    urdf = str((folder / file.urdf).resolve()) if file.urdf else ""
    robot = {
        key: str((folder / value).resolve())
        if key in FILES_OF_DRIVERS and value and (folder / value).exists()
        else value
        for key, value in file.robot.items()
    }
    return msgspec.structs.replace(file, cameras=cameras, microphones=microphones, urdf=urdf, robot=robot)


def capabilities_of(equipment: tuple[Equipment, ...]) -> frozenset[Capability]:
    """Return the capabilities of the devices together."""
    drives = any(one.base is not None for one in equipment)
    navigates = any(one.navigates for one in equipment)
    return frozenset({*(("drive",) if drives else ()), *(("navigate",) if navigates else ())})


def failsafe_of(base: Base) -> str:
    """A sentence on what the base does by itself when nobody speaks to it."""
    if base.failsafe_words:
        return base.failsafe_words
    if base.failsafe is None:
        return "It does not stop by itself when the link to it is lost."
    return plain(Statement("robot.stops_by_itself", seconds=f"{base.failsafe:g}"))


def _all_known(kind: str, named: Mapping[str, object], there: list[str]) -> None:
    unknown = next((name for name in named if name not in there), None)
    if unknown is not None:
        found = f"there is {', '.join(there)}" if there else "there is none"
        raise BadInput(f"The robot file describes the {kind} {unknown}, but the robot has no such one; {found}.")


def _laser(laser: Laser, table: LaserTable | None, body: Body | None) -> Laser:
    if table is None:
        return laser
    if table.link:
        at = _link(body, table.link)
        laser, table = _on_link(laser, at), msgspec.structs.replace(table, x=None, height=None)
        if abs(float(at.rotation[2, 2])) < FLAT_TILT_COSINE:
            raise BadInput(f"The link {table.link} stands on edge: no laser can scan the floor plan from there.")
    place = laser.mounting if table.x is None else Pose(table.x, table.y, math.radians(table.heading_deg))
    low, high = table.range_min or laser.range_min, table.range_max or laser.range_max
    if low >= high:
        raise BadInput(
            f"The laser {laser.name} would measure from {low:g} to {high:g} m; check range_min and range_max."
        )
    return replace(
        laser,
        mounting=place,
        height=table.height or laser.height,
        range_min=low,
        range_max=high,
        rate=table.rate or laser.rate,
        time_offset=table.time_offset,
    )


def _link(body: Body | None, link: str) -> Transform:
    """robot_from_link. Raises BadInput."""
    if body is None:
        raise BadInput(f"The robot file names the link {link}, but no urdf.")
    return body.mounting(link)


def _on_link(sensor: FlatSensor, at: Transform) -> FlatSensor:
    """A laser or an array at a link; that it hangs upside down is the driver's to tell."""
    placed = flat(at)
    return replace(sensor, mounting=placed.pose, height=placed.height if placed.height > 0 else sensor.height)


def _camera(camera: Camera, table: CameraTable | None, folder: Path, body: Body | None) -> Camera:
    if table is None:
        return camera
    mounting = camera.mounting if table.x is None else mounting_of(table.x, table)
    if table.link:
        mounting = camera_mounting(_link(body, table.link), table.link)
    model = camera.model
    if table.calibration:
        from core.calibration.files.camera_files import read_camera  # late: few robots name a file of YAML

        model = read_camera(folder / table.calibration)
    return replace(
        camera,
        mounting=mounting,
        model=model,
        rate=table.rate or camera.rate,
        optics_known=camera.optics_known or bool(table.calibration),
        mounting_known=camera.mounting_known or bool(table.link) or table.x is not None,
    )


def mounting_of(x: float, table: CameraTable) -> Transform:
    """A camera's place and angles → robot_from_camera, whose z looks along the camera's axis."""
    turned = rotation_of_rpy(*map(math.radians, (table.roll_deg, table.pitch_deg, table.yaw_deg)))
    return Transform(rotation=turned @ OPTICAL, translation=np.array([x, table.y, table.z]))


def _array(
    array: MicrophoneArray, table: MicrophonesTable | None, folder: Path, body: Body | None
) -> MicrophoneArray:
    if table is None:
        return array
    if table.profile:
        beside = folder / table.profile
        array = replace(load_array(beside if beside.exists() else table.profile), name=array.name)
    if table.link:
        return _on_link(array, _link(body, table.link))
    return replace(array, mounting=Pose(table.x, table.y, math.radians(table.heading_deg)), height=table.height)


class TopicChoice(msgspec.Struct, frozen=True, kw_only=True):
    """The topics that an operator chose for a role; () switches it off."""

    part: int = 0  # of the URL, counted from 0
    role: ChosenRole
    topics: tuple[str, ...]


def with_topics(file: RobotFile, choices: Sequence[TopicChoice], parts: Sequence[str]) -> RobotFile:
    """A robot file whose driver takes the chosen topics; `parts`: of its URL. Raises BadInput.

    What is chosen leaves the URL's query, which would count more than the file. The first part's choices go into
    [robot], which is its alone, those of others into their query.
    """
    joined, own = list(parts), dict(file.robot)
    for choice in choices:
        if not 0 <= choice.part < len(joined):
            raise BadInput("The robot has no such part; look at it again.")
        part = _without(joined[choice.part], choice.role)
        topics = list(choice.topics) or [NOTHING]
        if choice.part == 0:
            own[choice.role] = topics if choice.role == "scan" and len(topics) > 1 else topics[0]
        else:
            part += f"{'&' if '?' in part else '?'}{choice.role}={','.join(topics)}"
        joined[choice.part] = part
    return msgspec.structs.replace(file, url="+".join(joined), robot=own)


def without_lock(file: RobotFile, parts: Sequence[str]) -> RobotFile:
    """The same robot without its lock of twist_mux: who only looks closes nothing. `parts`: of its URL."""
    own = {key: value for key, value in file.robot.items() if key != "lock"}
    return msgspec.structs.replace(file, url="+".join(_without(part, "lock") for part in parts), robot=own)


def _without(part: str, key: str) -> str:
    address, _, query = part.partition("?")
    kept = [pair for pair in query.split("&") if pair and pair.partition("=")[0] != key]
    return "?".join(filter(None, (address, "&".join(kept))))


def toml_text(file: RobotFile, comment: str = "") -> str:
    """The text of a robot file, without what has its default; `comment` is its first lines."""
    lines = [f"# {line}" for line in comment.splitlines()]
    single, tables = _entries(file)
    lines += [f"{key} = {_value(value)}" for key, value in single.items()]
    for name in ("lasers", "cameras", "microphones"):
        for sensor, table in tables.pop(name, {}).items():
            lines += ["", f"[{name}.{_key(sensor)}]"]
            lines += [f"{_key(key)} = {_value(value)}" for key, value in _entries(table)[0].items()]
    own: dict[str, Any] = tables.get("robot", {})
    if own:
        lines += ["", "[robot]", *(f"{_key(key)} = {_value(value)}" for key, value in own.items())]
    return "\n".join(lines) + "\n"


def _entries(table: msgspec.Struct) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    plain: dict[str, Any] = {}
    tables: dict[str, dict[str, Any]] = {}
    for field in msgspec.structs.fields(table):
        value = getattr(table, field.name)
        if isinstance(value, dict):
            tables[field.name] = cast(dict[str, Any], value)
        elif value != field.default:
            plain[field.name] = value
    return plain, tables


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _text(name)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, depth: int = 0) -> str:
    """A value in TOML. Raises BadInput for what has no form there."""
    if depth > MAX_TABLE_DEPTH:
        raise BadInput("The robot file's tables lie too deep in each other.")
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return _text(value)
        case float() if not math.isfinite(value):
            return str(value)
        case int() | float():
            return repr(value)
        case datetime.date() | datetime.time():
            return value.isoformat()
        case list() | tuple():
            return f"[{', '.join(_value(one, depth + 1) for one in cast(Sequence[Any], value))}]"
        case dict():
            pairs = (f"{_key(key)} = {_value(one, depth + 1)}" for key, one in cast(Mapping[str, Any], value).items())
            return f"{{{', '.join(pairs)}}}"
        case _:
            raise BadInput(f"A robot file cannot hold a value of the kind {type(value).__name__}.")
