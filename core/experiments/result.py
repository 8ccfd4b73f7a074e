"""The result of an experiment: a JSON object whose keys every experiment extends by its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NotRequired, TypedDict, cast

SET_OUT = ("text", "table", "boards", "said")  # a result's own layout, and what it lays out


class BoardPoseFigures(TypedDict):
    """The pose of a board in the camera's frame, camera_from_board."""

    rotation: list[list[float]]  # 3x3
    translation_m: list[float]  # [3]


class ExperimentResult(TypedDict):
    """Keys that all results have in common."""

    seed: int
    files: dict[str, str]  # paths by what they hold; empty without a folder
    text: NotRequired[str]  # the table as it is printed
    not_drawn: NotRequired[str]  # why there are no figures
    boards: NotRequired[list[BoardPoseFigures]]  # to be drawn as a scene


def as_text(result: Mapping[str, object]) -> str:
    """A result for people: its own table where it has one, then every other figure by name."""
    rest = {name: value for name, value in result.items() if name not in SET_OUT}
    own = [f"{result['text']}\n"] if "text" in result else []
    return "\n".join([*own, *_lines(rest)])


def _lines(result: Mapping[str, object], indent: str = "") -> list[str]:
    """Lines `name  value`, nested ones indented."""
    lines: list[str] = []
    for name, value in result.items():
        if isinstance(value, dict):
            lines += [f"{indent}{name}", *_lines(cast(dict[str, object], value), indent + "  ")]
        elif isinstance(value, float):
            lines.append(f"{indent}{name:34}{value:.4g}")
        else:
            lines.append(f"{indent}{name:34}{value}")
    return lines
