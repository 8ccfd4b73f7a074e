"""Every way in declares who may use it: an endpoint, a mounted app, a socket. Nothing is open by being forgotten."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from starlette.routing import BaseRoute, Match, Mount

from console.access.records import RANK

T = TypeVar("T", bound=Callable[..., Any])


@dataclass(frozen=True)
class BodyLimit:
    types: tuple[str, ...]
    most: int  # [bytes]
    patience: float = 1.0  # times the ordinary time for a whole body

    @property
    def is_json(self) -> bool:
        return "application/json" in self.types


JSON = BodyLimit(("application/json",), 65_536)
KEY = BodyLimit(("application/json",), 2048)
SOUND = BodyLimit(("application/json",), 1_000_000)
ANY_FILE = "application/octet-stream"  # by which programs send what they read from a disk
TEXT = BodyLimit(("text/plain", ANY_FILE), 1_000_000)
ZIP_LIMIT = BodyLimit(("application/zip", "application/x-zip-compressed", ANY_FILE), 50_000_000, 6.0)
PICTURE = BodyLimit(("image/jpeg", "image/png", ANY_FILE), 20_000_000, 6.0)


@dataclass(frozen=True)
class Requirement:
    role: str  # public | viewer | operator | admin
    reads_body: bool = True  # False: acts on the headers alone, so that nothing in the body can delay or break it
    body: BodyLimit = JSON


FORGOTTEN = Requirement("viewer")
"""Asked of paths that lead nowhere: a stranger does not learn what exists."""


def needs(role: str, *, reads_body: bool = True, body: BodyLimit = JSON) -> Callable[[T], T]:
    """Declare the role of an endpoint or of an app to mount."""
    if role not in RANK:
        raise ValueError(f"There is no role {role!r}.")

    def declare(way_in: T) -> T:
        way_in.beckon_need = Requirement(role, reads_body, body)  # type: ignore[attr-defined]
        return way_in

    return declare


def declared(route: BaseRoute) -> Requirement | None:
    """Return what this route asks for, or None when it does not say."""
    way_in = route.app if isinstance(route, Mount) else getattr(route, "endpoint", None)
    return getattr(way_in, "beckon_need", None)


def check_roles(routes: Iterable[BaseRoute]) -> None:
    """Raises RuntimeError naming every route without a role: then the console does not start."""
    silent = [str(getattr(route, "path", route)) for route in routes if declared(route) is None]
    if silent:
        raise RuntimeError(f"These routes declare no role: {', '.join(silent)}.")


def need_for(routes: Iterable[BaseRoute], scope: Any) -> Requirement:
    nearest = FORGOTTEN
    for route in routes:
        match, _ = route.matches(scope)
        if match is Match.FULL:
            return declared(route) or FORGOTTEN
        if match is Match.PARTIAL:
            nearest = declared(route) or FORGOTTEN
    return nearest
