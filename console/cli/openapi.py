"""`beckon openapi`: the description of the HTTP interface, as a console has it at /openapi.json."""

import argparse
import json
from typing import Any

from console.cli.answer import add_command, write


def add(subcommands: Any) -> None:
    parser = add_command(
        subcommands,
        "openapi",
        run,
        "print the description of the HTTP interface (OpenAPI), without a console that runs",
        json=False,
    )
    parser.add_argument("--server", default="http://127.0.0.1:8420", metavar="URL", help="address of the console")


def run(chosen: argparse.Namespace) -> int:
    from console.api.documentation import ADDRESS  # the whole console: only when it is asked for
    from console.app import described_app

    write(json.dumps(described_app().openapi()).replace(ADDRESS, chosen.server.rstrip("/")))
    return 0
