"""Messages between the rooms: frozen values that own read-only copies of their arrays."""

import dataclasses
from typing import Any, TypeVar, dataclass_transform

import numpy as np
from numpy.typing import NDArray

from core.sentences import plain

Array = NDArray[Any]

T = TypeVar("T")


def listed(value: Any) -> Any:
    """Numbers and arrays of numpy, and sentences → what `msgspec` can write. Raises NotImplementedError."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else plain(value)


@dataclass_transform(frozen_default=True, kw_only_default=True, eq_default=False)
def message(cls: type[T]) -> type[T]:
    """Make a class a message: frozen, keyword-only, owner of read-only copies of its arrays.

    Messages compare by identity: arrays have no single truth value.
    """
    check = getattr(cls, "__post_init__", None)

    def own_arrays(self: Any) -> None:
        values = vars(self)  # at this moment its fields and nothing else
        for name, value in values.items():
            if isinstance(value, np.ndarray) and (value.flags.writeable or value.base is not None):
                values[name] = owned = value.copy()
                owned.setflags(write=False)
        if check is not None:
            check(self)

    cls.__post_init__ = own_arrays  # type: ignore[attr-defined]
    return dataclasses.dataclass(frozen=True, kw_only=True, eq=False)(cls)
