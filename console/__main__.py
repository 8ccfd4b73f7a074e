"""The command `beckon`."""

import os
import sys

from console.cli import build_parser
from console.cli.answer import JSON_BEGUN, refusal_of, sentence_of, write_json
from console.logging_setup import json_line
from core.errors import BadSettings, BeckonError

DONE_CODE, FAILED_CODE, USAGE_CODE, INTERRUPTED_CODE = 0, 1, 2, 130


def with_default(arguments: list[str]) -> list[str]:
    """`beckon`, `beckon --port 0` → `beckon run …`."""
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in ("-h", "--help", "--version")):
        return ["run", *arguments]
    return arguments


def main(arguments: list[str] | None = None) -> int:
    """Run `beckon ARGUMENTS`; returns the exit code: 0 done, 1 could not be done, 2 wrong usage.

    Where `--out` cannot be written, nothing is begun. A refusal is a sentence, with `--json` one object, too.
    """
    given = with_default(sys.argv[1:] if arguments is None else arguments)
    JSON_BEGUN.set(False)
    try:
        chosen = build_parser().parse_args(given)
        if getattr(chosen, "out", None) is not None:
            chosen.check_out(chosen.out)
        return chosen.run(chosen)
    except KeyboardInterrupt:
        return INTERRUPTED_CODE
    except BrokenPipeError:
        sys.stderr.close()
        return FAILED_CODE
    except Exception as trouble:
        if os.environ.get("BECKON_DEBUG") and not isinstance(trouble, BeckonError | OSError):
            raise
        if "--json" in given and not JSON_BEGUN.get():
            write_json(refusal_of(trouble))
        sentence = sentence_of(trouble)
        sys.stderr.write((json_line(sentence) if "--log-json" in given else f"beckon: {sentence}") + "\n")
        return USAGE_CODE if isinstance(trouble, BadSettings) else FAILED_CODE


if __name__ == "__main__":
    sys.exit(main())
