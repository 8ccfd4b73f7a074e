"""Declaration of a setting, once, where it stands: type, unit, bounds and meaning.

    class SteeringSettings(Section):
        '''Gains and tolerances.

        Watch:
            lookahead: swinging about the path wants more, cut corners less
        '''

        turn_floor: float = 0.04  # [rad/s] least turn rate that is asked for
        lookahead: Annotated[float, Meta("m", 0.05, 1.0, "distance ahead on the path at which the robot aims")] = 0.22

From the declaration come the check of every value, `beckon settings`, the reference page and the schema for editors.
A field without Meta is a threshold, the equation's own number: a file that names it gets a sentence.
"""

import dataclasses
import inspect
import math
import re
import types
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from core.errors import BadInput

HUGE = 10**15  # larger whole numbers are not spelled out
WATCH_LINE = re.compile(r"^    (\w+): (.+)$", re.MULTILINE)  # a line under "Watch:" of a docstring


@dataclass(frozen=True, slots=True)
class Meta:
    """Declaration of a setting besides its type and default."""

    unit: str = ""  # as the field writes it, "rad/s"; "" of a plain number
    low: float = -math.inf  # the least value that is accepted
    high: float = math.inf  # the largest value that is accepted
    meaning: str = ""
    choices: tuple[str, ...] = ()  # of a text that is one of few; a Literal says them itself
    common: bool = False  # one of those that the page offers
    live: bool = False  # holds as soon as it is changed; others hold from the next start


@dataclass(frozen=True, slots=True)
class DeclaredSetting:
    """One setting of a section, as it is declared."""

    name: str
    kind: type[bool] | type[int] | type[float] | type[str]
    optional: bool  # None is accepted in code; a file leaves the setting out
    choices: tuple[str, ...]  # () where any value within the bounds is accepted
    meta: Meta
    default: Any
    watch: str  # what to look at when it is changed, from the section's docstring; "" where none is named

    def fit(self, value: Any) -> Any:
        """Return a value as the setting's type. Raises BadInput with a sentence that names setting and bounds."""
        if value is None and self.optional:
            return value
        if self.choices:
            if type(value) is not str or value not in self.choices:
                raise BadInput(f"{self.name} must be one of {', '.join(self.choices)}, not {_shown(value)}.")
            return value
        if self.kind is bool or self.kind is str:
            if type(value) is not self.kind:
                wanted = "true or false" if self.kind is bool else "a text in quotes"
                raise BadInput(f"{self.name} must be {wanted}, not {_shown(value)}.")
            return value
        return self._number(value)

    def _number(self, value: Any) -> int | float:
        if self.kind is int and type(value) is not int:
            raise BadInput(f"{self.name} must be a whole number, not {_shown(value)}.")
        if type(value) not in (int, float):
            raise BadInput(f"{self.name} must be a number, not {_shown(value)}.")
        meta = self.meta
        if not meta.low <= value <= meta.high:
            unit = f" {meta.unit}" if meta.unit else ""
            bounds = f"between {meta.low:g} and {meta.high:g}{unit}"
            raise BadInput(f"{self.name} must lie {bounds}, not {_shown(value)}.")
        return int(value) if self.kind is int else float(value)


@dataclass(frozen=True)
class Section:
    """Base of a dataclass of settings: constructing one checks every value. Raises BadInput with a sentence.

    Defaults are taken as they are declared. A subclass that relates settings to each other does so in its own
    `__post_init__`, after this one.
    """

    def __post_init__(self) -> None:
        changed = {one.name for one in dataclasses.fields(self) if getattr(self, one.name) is not one.default}
        if changed:
            for setting in declared_settings(type(self)):
                if setting.name in changed:
                    setting.fit(getattr(self, setting.name))


@cache
def thresholds_of(section: type[Section]) -> frozenset[str]:
    """Names of the fields of a section that no file sets."""
    settings = {one.name for one in declared_settings(section)}
    return frozenset(one.name for one in dataclasses.fields(section) if one.name not in settings)


@cache
def declared_settings(section: type[Section]) -> tuple[DeclaredSetting, ...]:
    """The settings of a section, in the order of its fields."""
    hints = get_type_hints(section, include_extras=True)
    watched = {
        name: text for base in section.__mro__ for name, text in WATCH_LINE.findall(inspect.getdoc(base) or "")
    }
    return tuple(
        _declared(one, hints[one.name], watched.get(one.name, ""))
        for one in dataclasses.fields(section)
        if get_origin(hints[one.name]) is Annotated
    )


def _declared(field: dataclasses.Field[Any], hint: Any, watch: str) -> DeclaredSetting:
    kind, meta = get_args(hint)[:2]
    optional = get_origin(kind) in (Union, types.UnionType)
    if optional:
        (kind,) = (one for one in get_args(kind) if one is not types.NoneType)
    choices = meta.choices
    if get_origin(kind) is Literal:
        kind, choices = str, get_args(kind)
    return DeclaredSetting(field.name, kind, optional, choices, meta, field.default, watch)


def _shown(value: object) -> str:
    """A value that was given, harmless and short."""
    if isinstance(value, bool):
        return "true" if value else "false"
    text = "a huge number" if isinstance(value, int) and abs(value) > HUGE else str(value)
    return "".join(letter if letter.isprintable() else "?" for letter in text[:40]) or "empty"
