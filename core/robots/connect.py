"""From a URL to a robot. Each kind is imported only when it is asked for.

`sim:lab` and `log:FILE` are whole robots. Real ones are made of devices: `foxglove://robot:8765`, or several joined
by a plus, `serial:///dev/ttyUSB0+lds:///dev/ttyUSB1?model=LD06`, of which the first with a base drives. A path that
ends in .toml is a robot's file, which names the URL and describes the robot; `py:FILE.py:ARGUMENTS` is a driver of
one's own.
"""

import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple
from urllib.parse import urlencode

from msgspec import structs

from core.errors import BadInput, Unavailable
from core.robots import Robot
from core.robots.device import Device
from core.robots.live import LiveRobot
from core.robots.robot_file import RobotFile, absolute, load_robot_file, profile_of

GROUP = "beckon.robots"  # of the entry points by which packages bring robots
OWN = "py"  # scheme of a driver in a file


class Scheme(NamedTuple):
    """A kind of robot or device."""

    module: str  # with `open_robot(rest, *, seed, settings)` or `open_device(rest)`
    example: str
    what: str  # a few words for the operator
    has: str  # what it drives and senses
    section: str = ""  # of the settings, for a whole robot
    extra: str = ""  # that must be installed


ALL = "*"  # sections of the settings

SCHEMES = {
    "sim": Scheme(
        "core.simulation.faulty_robot",
        "sim:lab",
        "simulated robot",
        "drives, odometry, laser, camera, microphones",
        section="simulation",
    ),
    "log": Scheme("core.pilot.replayed_drive", "log:run.mcap", "recording", "what was recorded", section=ALL),
    "foxglove": Scheme(
        "core.robots.foxglove",
        "foxglove://robot:8765",
        "ROS 2 or ROS 1 robot behind foxglove_bridge",
        "drives; odometry, lasers, cameras, microphones as its topics have them",
    ),
    "zenoh": Scheme(
        "core.robots.zenoh_link",
        "zenoh://robot:7447/namespace?domain=0",
        "ROS 2 robot on rmw_zenoh, or behind zenoh-bridge-ros2dds",
        "drives; odometry, lasers, cameras as its topics have them",
        extra="fleet",
    ),
    "rosbridge": Scheme(
        "core.robots.rosbridge",
        "rosbridge://robot:9090",
        "ROS 1 or ROS 2 robot behind rosbridge_server",
        "drives; odometry, lasers, cameras as its topics have them",
        extra="rosbridge",
    ),
    "serial": Scheme(
        "core.robots.serial_base",
        "serial:///dev/ttyUSB0",
        "differential drive on a serial port, Beckon's line protocol",
        "drives, odometry, bumper, battery",
        extra="hardware",
    ),
    "srv1": Scheme("core.robots.srv1", "srv1://192.168.0.15:10001", "SRV-1 Blackfin", "drives, camera"),
    "scip": Scheme(
        "core.robots.scip",
        "scip:///dev/ttyACM0",
        "Hokuyo URG-04LX and other SCIP 2.0 lasers",
        "laser",
        extra="hardware",
    ),
    "camera": Scheme("core.robots.usb_camera", "camera://0", "camera, network stream or film, by OpenCV", "camera"),
    "audio": Scheme(
        "core.robots.usb_audio",
        "audio://ReSpeaker",
        "microphones of this computer, or a recording",
        "microphones",
        extra="hardware",
    ),
    "lds": Scheme(
        "core.robots.lds",
        "lds:///dev/ttyUSB1?model=ld19",
        "turning lidars: RPLIDAR, YDLIDAR, LDROBOT and others",
        "laser",
        extra="hardware",
    ),
}

Opener = Callable[[str], Device]


def connect(url: str, *, seed: int = 0, settings: object | None = None) -> Robot:
    """Open the robot. `settings` has sections as attributes; a missing one means the defaults.

    Raises BadInput or Unavailable with a sentence.
    """
    if url.endswith(".toml"):
        file = load_robot_file(Path(url))
        if not file.url:
            raise BadInput(f'{Path(url).name} needs a line url = "…": how the robot is reached (see beckon robots).')
        folder = Path(url).parent
        return live("+".join(beside(part, folder) for part in parts_of(file.url)), file, folder)
    name, rest = split(url)
    scheme = SCHEMES.get(name)
    if scheme is not None and scheme.section and len(parts_of(url)) == 1:
        open_robot = imported(scheme.module, name).open_robot
        chosen = settings if scheme.section == ALL else getattr(settings, scheme.section, None)
        return open_robot(rest, seed=seed, settings=chosen)
    return live(url, RobotFile())


def live(url: str, file: RobotFile, folder: Path = Path()) -> LiveRobot:
    """Open the devices that a URL joins, as one robot. Raises BadInput or Unavailable."""
    whole = absolute(structs.replace(file, url=url), folder)
    return LiveRobot(devices_of(url, whole), lambda equipment: profile_of(equipment, file, url, folder), file=whole)


def devices_of(url: str, file: RobotFile) -> list[tuple[str, Device]]:
    """The devices that a URL joins, with their names, not opened yet. Raises BadInput or Unavailable."""
    devices: list[tuple[str, Device]] = []
    for number, part in enumerate(parts_of(url)):
        name, rest = split(part)
        if name in SCHEMES and SCHEMES[name].section:
            raise BadInput(
                f"{name}: is a whole robot: it is opened by its address alone (--robot {part}), "
                "not joined with devices and not by a robot file."
            )
        options = file.robot if number == 0 else {}
        opened = opener(name)(with_options(rest, options))
        devices.append((f"{name}:{rest.partition('?')[0]}", opened))
    return devices


def parts_of(url: str) -> list[str]:
    """`a:…+b:…` → its parts. A plus that no scheme follows belongs to a part."""
    return re.split(r"\+(?=[a-z][a-z0-9_]*:)", url)


def beside(part: str, folder: Path) -> str:
    """A part of a robot file's URL; a driver that lies beside the file with its whole path."""
    name, rest = split(part)
    driver = folder.resolve() / f"{rest.partition('.py')[0]}.py"
    return (
        f"{name}:{folder.resolve()}/{rest}" if name == OWN and not rest.startswith("/") and driver.is_file() else part
    )


def with_options(rest: str, options: Mapping[str, Any]) -> str:
    """A part of a URL with the entries of [robot] as its query; what the URL says itself counts more."""
    address, _, query = rest.partition("?")
    given = {pair.partition("=")[0] for pair in query.split("&")}
    more = {key: _plain(value) for key, value in options.items() if key not in given}
    return "?".join(filter(None, (address, "&".join(filter(None, (query, urlencode(more)))))))


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)


def opener(name: str) -> Opener:
    """The function that opens a device of this scheme. Raises BadInput, Unavailable."""
    if name == OWN:
        return open_own
    if name in SCHEMES:
        return imported(SCHEMES[name].module, name).open_device
    point = brought().get(name)
    if point is None:
        raise unknown(name)
    try:
        return point.load()
    except ImportError as trouble:
        raise Unavailable(f"{name}: cannot be loaded from the package that brings it ({trouble}).") from None


def imported(module: str, name: str) -> ModuleType:
    """A driver's module. Raises Unavailable where a package is missing."""
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        raise Unavailable(f"{name}: robots need the package {missing.name}, which is not installed.") from None


def open_own(rest: str) -> Device:
    """`FILE.py:ARGUMENTS` → the Device that the file declares, made with the arguments. Raises BadInput."""
    path, _, arguments = rest.partition(".py:") if ".py:" in rest else (rest.removesuffix(".py"), "", "")
    file = Path(f"{path}.py")
    spec = importlib.util.spec_from_file_location(file.stem, file)
    if not file.is_file() or spec is None or spec.loader is None:
        raise BadInput(f"There is no driver {file}; `beckon robot new NAME` writes one to begin with.")
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    try:
        spec.loader.exec_module(module)
        if hasattr(module, "open_device"):
            return module.open_device(arguments)
        kinds = [
            one
            for one in vars(module).values()
            if inspect.isclass(one) and issubclass(one, Device) and one.__module__ == module.__name__
        ]
        if len(kinds) == 1:
            return kinds[0](arguments)
    except (SyntaxError, ImportError, TypeError, AttributeError, NameError, ValueError) as fault:
        raise BadInput(f"{file.name} cannot be used: {type(fault).__name__}: {fault}.") from None
    raise BadInput(
        f"{file.name} declares {len(kinds)} kinds of Device; one is expected, or a function open_device(arguments)."
    )


def brought() -> dict[str, EntryPoint]:
    """Schemes that installed packages bring."""
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in {*SCHEMES, OWN}}


def excerpt(url: str, settings: object | None) -> object:
    """Of all settings, the section that `connect` looks at for this URL. Raises BadInput for an unknown kind."""
    if url.endswith(".toml"):
        return SimpleNamespace()
    sections = [SCHEMES[name].section for name, _ in map(split, parts_of(url)) if name in SCHEMES]
    if ALL in sections:
        return settings
    return SimpleNamespace(**{section: getattr(settings, section, None) for section in sections if section})


def split(url: str) -> tuple[str, str]:
    """A robot's URL → its scheme and the rest. Raises BadInput for a scheme that nobody brings."""
    name, colon, rest = url.partition(":")
    if not colon or (name not in SCHEMES and name != OWN and name not in brought()):
        raise unknown(name)
    return name, rest


def unknown(name: str) -> BadInput:
    """Return the error for a scheme that there is not."""
    known = ", ".join(f"{scheme}:…" for scheme in [*SCHEMES, OWN, *brought()])
    return BadInput(
        f"There is no robot of the kind {name[:30]!r}; known are {known} and files robot.toml (for example sim:lab)."
    )
