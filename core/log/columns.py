"""Text tables: white-space columns of numbers, `#` comments, plain or gzip'ed."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.log.source import TextLog
from core.log.tally import Tally
from core.message import Array


def read_columns(path: Path, columns: int, largest: int, tally: Tally) -> Array:
    """A table → (N, columns) of finite numbers; other lines are counted as skipped. Raises BadInput.

    Where `path` is absent, the same name with `.gz` is read.
    """
    path = path if path.exists() else path.with_name(path.name + ".gz")
    if not path.exists():
        raise BadInput(f"{path.name.removesuffix('.gz')} is missing in {path.parent.name}.")
    text = TextLog(path, largest)
    numbers = array("d")
    for number, line in text:
        if not line or line.startswith("#"):
            continue
        words = line.split()
        try:
            row = [float(word) for word in words[:columns]]
        except ValueError:
            row = []
        if len(row) < columns or not all(abs(value) < 1e12 for value in row):
            tally.skip("it is cut or no numbers", f"line {number} of {path.name}")
            continue
        numbers.extend(row)
    if text.cut:
        tally.skip("the packed file is cut or damaged here", path.name)
    return np.array(numbers).reshape(-1, columns)
