"""`beckon link`: a link that signs in who opens it, made beside a running console."""

import argparse
import sys
import time
from pathlib import Path
from typing import Any

from console.cli.answer import add_command, tell, write, write_json
from core.errors import Unavailable


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "link", run, "a link by which someone else may sign in")
    parser.add_argument("--role", choices=("viewer", "operator"), default="operator", help="default: operator")
    parser.add_argument("--name", default="", help="what who opens it is called, such as tablet")
    parser.add_argument("--data", type=Path, metavar="DIR", help="the console's data folder")


def run(chosen: argparse.Namespace) -> int:
    """Print it, and on a terminal its QR code. Raises Unavailable where no console runs."""
    from console.access.logins import LINK_LIFE_S, key_for
    from console.cli.token import tidy
    from console.data_folder import home_folder, running_at
    from console.http import qr

    home = home_folder(chosen.data)
    base = running_at(home)
    if base is None:
        raise Unavailable(f"No console runs with the data folder {home}; start one with: beckon run")
    now = time.time()
    name = tidy(chosen.name) if chosen.name else chosen.role
    token, key = key_for(home, name, chosen.role, "link", now, end=now + LINK_LIFE_S)
    address = f"{base}#t={token}"
    if chosen.json:
        write_json({"id": key.id, "address": address, "name": key.name, "role": key.role, "end_s": key.end_s})
        return 0
    write(address)
    if sys.stdout.isatty():
        write(qr.drawn(address))
    tell(f"It signs in who opens it, for thirty days. To end it: beckon token revoke {key.id}")
    return 0
