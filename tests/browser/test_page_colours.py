"""The legend tells the truth: its colours are the scene's."""

import re
from pathlib import Path

import pytest

from console.scene.drawing import palette

TOKENS = (Path(__file__).parent.parent.parent / "static/css/tokens.css").read_text()


LAYERS = ["pose", "ghost", "convex", "concave", "scan", "plan", "preview", "closure", "doubt", "room", "wall", "free"]


@pytest.mark.parametrize("layer", LAYERS)
def test_the_legend_has_the_colour_of_the_scene(layer: str) -> None:
    told = re.search(rf"--scene-{layer}: rgb\((\d+) (\d+) (\d+)\);", TOKENS)
    assert told is not None
    assert tuple(map(int, told.groups())) == getattr(palette, layer.upper())
