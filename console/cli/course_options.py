"""Options of some experiments beyond runs, seed and folder: above all `dead-reckoning-vs-slam`."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

TAKES = {
    "audio-visual": ("settings", "workers"),
    "dead-reckoning-vs-slam": ("data", "noise", "field", "still", "ids", "through", "settings", "workers"),
    "figure-16-conditions": ("data", "workers"),
    "printed-and-ours": ("workers",),
    "tour": ("settings",),
}
LEAST_NOISE, MOST_NOISE = 0.05, 20.0
MOST_WORKERS = 64


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
    own.add_argument("--workers", type=workers, metavar="N", help="processes; the answer does not depend on it")
    own.add_argument(
        "--settings",
        type=Path,
        metavar="FILE.toml",
        help="noise, gates and the filter's form, [ekf] mode; without it the paper's form (tour: takes it too)",
    )
    parser.set_defaults(wrong=parser.error)


def chosen_options(chosen: argparse.Namespace) -> dict[str, object]:
    """Return the options beyond the usual; exit with wrong usage where the experiment does not know them."""
    every = sorted({name for names in TAKES.values() for name in names})
    asked: dict[str, object] = {name: getattr(chosen, name) for name in every if getattr(chosen, name) is not None}
    strange = [f"--{name}" for name in asked if name not in TAKES.get(chosen.name, ())]
    if strange:
        chosen.wrong(f"{chosen.name} does not take {', '.join(strange)}")
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


def workers(text: str) -> int:
    """'4' → a number of processes."""
    if not (text.isascii() and text.isdigit() and len(text) <= 4 and 1 <= int(text) <= MOST_WORKERS):
        raise argparse.ArgumentTypeError(f"Give a whole number of processes between 1 and {MOST_WORKERS}.")
    return int(text)
