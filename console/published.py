"""Results as the documentation stores them: their figures to five digits, with the commit that made them."""

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from core.experiments.workers import versions

SIGNIFICANT_DIGITS = 5  # of a stored figure
LAID_OUT = ("text", "boards", "said", "points", "files")  # what a stored result leaves out


def origin() -> dict[str, str]:
    """Commit and versions on which a result depends; without git the checksum of the code alone names it."""
    asked = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        commit = subprocess.run(asked, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        commit = ""
    return {"commit": commit, **versions()}


def compact(result: Mapping[str, Any], made_by: Mapping[str, str]) -> str:
    """A result as it is stored: JSON of its figures to five digits, and of what made it."""
    kept = {name: rounded(one) for name, one in result.items() if name not in LAID_OUT}
    return json.dumps({"made_by": made_by, **kept}, indent=1, ensure_ascii=False) + "\n"


def rounded(value: Any) -> Any:
    """The same figures to five significant digits."""
    if isinstance(value, Mapping):
        return {str(name): rounded(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(one) for one in value]
    return float(f"{value:.{SIGNIFICANT_DIGITS}g}") if isinstance(value, float) else value
