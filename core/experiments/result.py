"""The result of an experiment: a JSON object whose keys every experiment extends by its own."""

from __future__ import annotations

from typing import NotRequired, TypedDict


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
