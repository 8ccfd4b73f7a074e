"""The command of a benchmark: its options are the parameters of its `main`, its figures are what that returns.

`def main(folder: Path, *, runs: int = 20, engine: Annotated[str, ENGINES] = "whisper", plain: bool = False)` is
`python -m tests.benchmarks.NAME FOLDER --runs 5 --plain`. What stands before the star has no dashes; a sequence takes
several words; an `Annotated` value is one of those named.
"""

import argparse
import inspect
import json
import sys
from collections.abc import Callable, Sequence
from types import NoneType
from typing import Any, get_args, get_origin


def print_row(row: object) -> None:
    """Print a line at once: a text as it is, anything else as JSON."""
    sys.stdout.write((row if isinstance(row, str) else json.dumps(row)) + "\n")
    sys.stdout.flush()


def run_command(main: Callable[..., object]) -> None:
    """Call a benchmark as the command line says, and print what it returns; a whole number is the exit code."""
    parser = argparse.ArgumentParser(description=sys.modules[main.__module__].__doc__)
    for name, parameter in inspect.signature(main, eval_str=True).parameters.items():
        how = _option(parameter.annotation)
        has_flag = parameter.kind is parameter.KEYWORD_ONLY
        if parameter.default is not parameter.empty:
            how |= {"default": parameter.default} if has_flag else {"default": parameter.default, "nargs": "?"} | how
        elif has_flag:
            how["required"] = True
        parser.add_argument(f"--{name.replace('_', '-')}" if has_flag else name, **how)
    given = vars(parser.parse_args())
    figures = main(**given)
    if isinstance(figures, int):
        sys.exit(figures)
    if figures is not None:
        print_row(figures if isinstance(figures, str) else json.dumps(figures, indent=1))


def _option(kind: Any) -> dict[str, Any]:
    """What argparse is to know of a parameter's type."""
    if get_origin(kind) is Sequence:
        return {"nargs": "*", **_option(get_args(kind)[0])}
    if hasattr(kind, "__metadata__"):
        return {**_option(kind.__origin__), "choices": tuple(kind.__metadata__[0])}
    if kind is bool:
        return {"action": "store_true"}
    return {"type": next((one for one in get_args(kind) if one is not NoneType), kind)}
