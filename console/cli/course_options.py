"""Options of some experiments beyond runs, seed and folder: above all `dead-reckoning-vs-slam`."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from core.experiments import EXPERIMENTS

NAMES = ("data", "noise", "field", "still", "ids", "through", "settings")
LEAST_NOISE, MOST_NOISE = 0.05, 20.0


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    own = parser.add_argument_group("dead-reckoning-vs-slam")
    own.add_argument("--data", type=Path, metavar="FILE.npz", help="frozen draws instead of the simulator")
    own.add_argument("--noise", type=noise, metavar="X", help="all of eq. 43 X times as large")
    own.add_argument("--field", choices=("laser", "camera"), help="what is seen: 240 degrees (default), or 56")
    own.add_argument("--still", action="store_true", default=None, help="ten frames at rest before the first move")
    own.add_argument(
        "--ids", choices=("given", "hidden"), help="given: the filter knows the corners' names; hidden: it does not"
    )
    own.add_argument(
        "--through",
        choices=("drawn", "sensors"),
        help="sightings drawn about the true corners (default), or made out by the whole robot in sim:lab",
    )
    own.add_argument(
        "--settings",
        type=Path,
        metavar="FILE.toml",
        help="noise, gates and the filter's form, [ekf] mode; without it the paper's form (others take it too)",
    )
    parser.set_defaults(wrong=parser.error)


def chosen_options(chosen: argparse.Namespace, name: str) -> dict[str, object]:
    """Return the options beyond the usual; exit with wrong usage where the experiment does not know them."""
    asked: dict[str, object] = {key: getattr(chosen, key) for key in NAMES if getattr(chosen, key) is not None}
    strange = [f"--{key}" for key in asked if key not in EXPERIMENTS[name].options]
    if strange:
        chosen.wrong(f"{name} does not take {', '.join(strange)}")
    if "settings" in asked:
        from core.settings import load  # scipy and OpenCV take a moment: only where they are needed

        asked["settings"] = load(chosen.settings)
    return asked


def noise(text: str) -> float:
    """'2' → a factor."""
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not LEAST_NOISE <= factor <= MOST_NOISE:
        raise argparse.ArgumentTypeError(f"Give a number between {LEAST_NOISE:g} and {MOST_NOISE:g}.")
    return factor
