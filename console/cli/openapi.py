"""`beckon openapi`: the description of the HTTP interface, as a console has it at /openapi.json."""

import argparse
import json
from typing import Any

from console.cli.answer import write


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser(
        "openapi", help="print the description of the HTTP interface (OpenAPI), without a console that runs"
    )
    parser.add_argument("--server", default="http://127.0.0.1:8420", metavar="URL", help="address of the console")
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Print it."""
    from console.api.documentation import ADDRESS  # the whole console: only when it is asked for
    from console.app import described_app

    write(json.dumps(described_app().openapi()).replace(ADDRESS, chosen.server.rstrip("/")))
    return 0
