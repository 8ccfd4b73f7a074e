"""The result of an experiment: a JSON object whose keys every experiment extends by its own."""

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NotRequired, TypedDict, TypeVar, cast

from core.errors import Unavailable
from core.files import save_all


class BoardPoseFigures(TypedDict):
    """The pose of a board in the camera's frame, camera_from_board."""

    rotation: list[list[float]]  # 3x3
    translation_m: list[float]  # [3]


class SpeedUp(TypedDict, total=False):
    """Keys that tell how a campaign went; all other keys of its result are the same on any number of workers."""

    workers: int
    seconds: float  # from the start of the workers to the last run
    resumed_runs: int  # that were not carried out again
    serial_seconds: float  # the sum of the processor times of those that were
    speed_up: float | None  # None: none was carried out


class ExperimentResult(SpeedUp, total=True):
    """Keys that all results have in common; those of SpeedUp are added when a campaign has ended."""

    seed: int
    files: dict[str, str]  # paths by what they hold; empty without a folder
    text: NotRequired[str]  # the table as it is printed
    not_drawn: NotRequired[str]  # why there are no figures
    boards: NotRequired[list[BoardPoseFigures]]  # to be drawn as a scene


T = TypeVar("T")
ResultT = TypeVar("ResultT", bound=ExperimentResult)
FileContents = Mapping[str, tuple[str, str | bytes]]  # name and content of a file, by what it holds
SPEED = tuple(SpeedUp.__annotations__)
# Keys that are not listed by name: the result's own text, what that text or a figure shows, and the speed.
SET_OUT = ("text", "table", "boards", "said", "points", *SPEED)


def stored(
    result: ResultT,
    out: Path | None,
    name: str,
    more: FileContents | None = None,
    figures: Callable[[], FileContents] = dict,
) -> ResultT:
    """The result with its files, if there is a folder: itself as `name`.json, and `more`. Raises Unwritable.

    `figures` draws others; without matplotlib there are none, and the result says so under `not_drawn`.
    """
    if out is None:
        return result
    try:
        drawn = figures()
    except Unavailable as missing:
        drawn, result["not_drawn"] = {}, str(missing)
    whole = json.dumps({key: value for key, value in result.items() if key != "files"}, indent=1)
    result["files"] = save_all(out, {"json": (f"{name}.json", whole), **(more or {}), **drawn})
    return result


def as_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows of one form as CSV under their keys."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def grouped(rows: Iterable[T], key: Callable[[T], str]) -> dict[str, list[T]]:
    """Rows with the same key together, in the order of their first."""
    found: dict[str, list[T]] = {}
    for row in rows:
        found.setdefault(key(row), []).append(row)
    return found


def best_and_worst(rates: Mapping[str, float]) -> tuple[str, str]:
    """The names with the highest and the lowest rate; of equal ones the first."""
    return max(rates, key=rates.__getitem__), min(rates, key=rates.__getitem__)


def as_text(result: Mapping[str, object]) -> str:
    """A result for people: its own table where it has one, then every other figure by name; rows are in the table."""
    rest = {name: value for name, value in result.items() if name not in SET_OUT and not _is_table(value)}
    own = [f"{result['text']}\n"] if "text" in result else []
    return "\n".join([*own, *_lines(rest), *_speed(result)])


def _is_table(value: object) -> bool:
    return isinstance(value, list) and any(isinstance(row, dict) for row in cast(list[object], value))


def _speed(result: Mapping[str, Any]) -> list[str]:
    """The speed-up of a campaign against the serial time of the same runs."""
    if "speed_up" not in result:
        return []
    resumed = f"; {result['resumed_runs']} runs were done before" if result["resumed_runs"] else ""
    if result["speed_up"] is None:
        return ["", f"no run was left to be carried out{resumed}"]
    seconds, serial, gain, workers = (result[key] for key in ("seconds", "serial_seconds", "speed_up", "workers"))
    return [
        "",
        f"{'workers':>7}{'seconds':>11}{'one by one':>13}{'speed-up':>11}{'of ideal':>11}",
        f"{workers:7}{seconds:9.1f} s{serial:11.1f} s{gain:11.2f}{100 * gain / workers:9.0f} %{resumed}",
    ]


def _lines(result: Mapping[str, object], indent: str = "") -> list[str]:
    lines: list[str] = []
    for name, value in result.items():
        if isinstance(value, dict):
            lines += [f"{indent}{name}", *_lines(cast(dict[str, object], value), indent + "  ")]
        elif isinstance(value, float):
            lines.append(f"{indent}{name:34}{value:.4g}")
        else:
            lines.append(f"{indent}{name:34}{value}")
    return lines
