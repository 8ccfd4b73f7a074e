"""From a URL to a robot. Each kind is imported only when it is asked for."""

from __future__ import annotations

from importlib import import_module
from types import SimpleNamespace
from typing import NamedTuple

from core.errors import BadInput, Unavailable
from core.robots import Robot


class Scheme(NamedTuple):
    """The function that opens a kind of robot, and the section of the settings that it is given."""

    opened_by: str  # module:function(rest, *, seed, settings)
    section: str


SCHEMES = {
    "sim": Scheme("core.simulation.robot:open_robot", "simulation"),
    "log": Scheme("core.robots.replayed:open_robot", "log"),
}


def connect(url: str, *, seed: int = 0, settings: object | None = None) -> Robot:
    """`sim:lab`, `log:FILE` → the robot. `settings` has sections as attributes; a missing one means the defaults.

    Raises BadInput or Unavailable with a sentence.
    """
    name, rest = split(url)
    module, _, function = SCHEMES[name].opened_by.partition(":")
    try:
        open_robot = getattr(import_module(module), function)
    except ModuleNotFoundError as missing:
        raise Unavailable(f"{name}: robots need the package {missing.name}, which is not installed.") from None
    return open_robot(rest, seed=seed, settings=getattr(settings, SCHEMES[name].section, None))


def excerpt(url: str, settings: object | None) -> SimpleNamespace:
    """Of all settings, the section that `connect` looks at for this URL. Raises BadInput."""
    section = SCHEMES[split(url)[0]].section
    return SimpleNamespace(**{section: getattr(settings, section, None)})


def split(url: str) -> tuple[str, str]:
    """A robot's URL → its scheme, which is one of SCHEMES, and the rest. Raises BadInput."""
    name, colon, rest = url.partition(":")
    if not colon or name not in SCHEMES:
        known = ", ".join(f"{scheme}:…" for scheme in SCHEMES)
        raise BadInput(f"There is no robot of this kind; known are {known} (for example sim:lab).")
    return name, rest
