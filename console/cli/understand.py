"""`beckon understand`: words → command or refusal, no robot."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

from console.cli.answer import add_command, write, write_json

if TYPE_CHECKING:
    from core.commands.command import Command
    from core.speech.understanding.grammar import Refusal


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "understand", run, "what a sentence would make the robot do, without a robot")
    parser.add_argument("words", nargs="+", metavar="TEXT")
    parser.add_argument("--spoken", action="store_true", help="judge it by the stricter bounds for speech")


def run(chosen: argparse.Namespace) -> int:
    """Exit code 0 also for a refusal: the question was answered."""
    from core.speech.understanding.grammar import Refusal, understand  # the vocabulary takes a moment

    heard = understand(" ".join(chosen.words), spoken=chosen.spoken)
    if chosen.json:
        write_json(as_json(heard))
    elif not isinstance(heard, Refusal):
        numbers = ", ".join(f"{name} = {value:g}" for name, value in heard.numbers.items())
        write(f"{heard.name}({numbers}): {heard.heard_as}")
    else:
        write("Refused: " + heard.reason)
        for suggestion in heard.suggestions:
            write(f"  did you mean: {suggestion}")
    return 0


class Understanding(TypedDict):
    accepted: bool
    command: dict[str, object] | None  # name, and its numbers with their units
    heard_as: NotRequired[str]
    reason: str
    suggestions: list[str]


def as_json(heard: Command | Refusal) -> Understanding:
    """The keys of the contract: accepted, command, reason, suggestions."""
    from core.commands import particulars  # see run
    from core.speech.understanding.grammar import Refusal

    if not isinstance(heard, Refusal):
        return {
            "accepted": True,
            "command": {"name": heard.name, **particulars(heard.name, heard.numbers)},
            "heard_as": heard.heard_as,
            "reason": "",
            "suggestions": [],
        }
    return {"accepted": False, "command": None, "reason": heard.reason, "suggestions": list(heard.suggestions)}
