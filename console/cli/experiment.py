"""`beckon experiment`: one figure or table, computed anew."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from console.cli.answer import add_json, tell, write, write_json
from core.experiments import EXPERIMENTS


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("experiment", help="compute a figure or a table anew")
    parser.add_argument("name", choices=sorted(EXPERIMENTS), metavar="NAME", help=", ".join(sorted(EXPERIMENTS)))
    parser.add_argument("--runs", type=int, default=None, help="how often (the experiment's own number)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=None, metavar="DIR", help="where files go")
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Run it and say what came out."""
    result = EXPERIMENTS[chosen.name](runs=chosen.runs, seed=chosen.seed, out=chosen.out, tell=tell)
    if chosen.json:
        write_json(result)
    else:
        for line in sentences(result):
            write(line)
    return 0


def sentences(result: dict[str, Any], indent: str = "") -> list[str]:
    """A result as lines `name  value`, nested ones indented."""
    lines: list[str] = []
    for name, value in result.items():
        if isinstance(value, dict):
            lines += [f"{indent}{name}", *sentences(value, indent + "  ")]
        elif isinstance(value, float):
            lines.append(f"{indent}{name:34}{value:.4g}")
        else:
            lines.append(f"{indent}{name:34}{value}")
    return lines
