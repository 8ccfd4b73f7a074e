"""Messages of the sockets, typed once; `python -m tests.reference` writes the browser's types."""

import re
from typing import TypeVar

import msgspec

UNIT = re.compile(r"_(m_s|rad_s|m|rad|s)$")  # ends the name of a field, and not that of the core's attribute

MessageT = TypeVar("MessageT", bound=msgspec.Struct)


def filled(kind: type[MessageT], source: object, digits: int | None = None, /, **own: object) -> MessageT:
    """A message with the attributes of `source` that its fields are called by, with their units or without.

    Fractions are rounded to so many digits, if any; `own`: fields that are something else.
    """
    for name in kind.__struct_fields__:
        if name not in own:
            value = getattr(source, name if hasattr(source, name) else UNIT.sub("", name))
            own[name] = value if digits is None or not isinstance(value, float) else round(float(value), digits)
    return kind(**own)
