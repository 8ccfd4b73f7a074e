"""The command `beckon`."""

from __future__ import annotations

import os
import sys

from console.cli import build_parser
from console.cli.answer import write_unusable
from core.errors import BadSettings, BeckonError
from core.sensors.checks import UnusableReading

DONE, COULD_NOT, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130


def with_default(arguments: list[str]) -> list[str]:
    """`beckon`, `beckon --port 0` → `beckon run …`."""
    if not arguments or (arguments[0].startswith("-") and arguments[0] not in ("-h", "--help", "--version")):
        return ["run", *arguments]
    return arguments


def main(arguments: list[str] | None = None) -> int:
    """Run `beckon ARGUMENTS`; returns the exit code: 0 done, 1 could not be done, 2 wrong usage.

    Where `--out` cannot be written, nothing is begun.
    """
    parser = build_parser()
    chosen = parser.parse_args(with_default(sys.argv[1:] if arguments is None else arguments))
    try:
        if getattr(chosen, "out", None) is not None:
            chosen.check_out(chosen.out)
        return chosen.run(chosen)
    except BeckonError as trouble:
        if isinstance(trouble, UnusableReading) and getattr(chosen, "json", False):
            write_unusable(trouble)
        sys.stderr.write(f"beckon: {trouble}\n")
        return WRONG_USAGE if isinstance(trouble, BadSettings) else COULD_NOT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()
        return COULD_NOT
    except OSError as trouble:
        sys.stderr.write(f"beckon: The system refuses {trouble.filename or 'this'}: {trouble.strerror or trouble}.\n")
        return COULD_NOT
    except Exception as fault:
        if os.environ.get("BECKON_DEBUG"):
            raise
        sys.stderr.write(
            f"beckon: something went wrong inside Beckon ({type(fault).__name__}). "
            "Run the same command with BECKON_DEBUG=1 and report what it prints.\n"
        )
        return COULD_NOT


if __name__ == "__main__":
    sys.exit(main())
