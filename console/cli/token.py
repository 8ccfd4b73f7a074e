"""`beckon token`: fixed keys for programs, who is signed in, and the end of a key or a login."""

from __future__ import annotations

import argparse
import time
import unicodedata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_json, answer, tell, write, write_json
from core.errors import BadInput

if TYPE_CHECKING:
    from console.access.records import Records

KINDS = {"start": "printed at a start", "link": "link", "file": "--token-file", "program": "program"}


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("token", help="keys for programs; who may sign in")
    doings = parser.add_subparsers(dest="doing", metavar="DOING", required=True)
    adding = doings.add_parser("add", help="make a fixed key for a program")
    adding.add_argument("name", metavar="NAME", help="of the program")
    adding.add_argument("--role", choices=("viewer", "operator", "admin"), required=True)
    adding.set_defaults(run=add_token)
    listing = doings.add_parser("list", help="all keys, links and logins; never a secret")
    listing.set_defaults(run=list_tokens)
    revoking = doings.add_parser("revoke", help="end a key with the logins that it opened, or one login")
    revoking.add_argument("which", metavar="ID|NAME", help="as beckon token list shows them")
    revoking.set_defaults(run=revoke)
    for one in (adding, listing, revoking):
        one.add_argument("--data", type=Path, metavar="DIR", help="the console's data folder")
        add_json(one)


def add_token(chosen: argparse.Namespace) -> int:
    """Print the key, this once. Raises BadInput for a name that another program has."""
    from console.access.logins import key_for
    from console.access.records import AccessFile
    from console.data_folder import home_folder, prepare

    home, name = home_folder(chosen.data), tidy(chosen.name)
    prepare(home)
    if any(key.name.casefold() == name.casefold() for key in AccessFile(home).read().keys.values()):
        raise BadInput(f"There is a key {name} already; end it with: beckon token revoke {name}")
    token, key = key_for(home, name, chosen.role, "program", time.time())
    if chosen.json:
        write_json({"id": key.id, "name": key.name, "role": key.role, "token": token})
        return 0
    write(token)
    tell("Send it with every request: Authorization: Bearer KEY. It is not shown again.")
    return 0


def list_tokens(chosen: argparse.Namespace) -> int:
    """Print keys and logins."""
    from console.access.records import AccessFile
    from console.data_folder import home_folder

    found = AccessFile(home_folder(chosen.data)).read()
    keys = sorted(found.keys.values(), key=lambda key: key.made_s)
    logins = sorted(found.logins.values(), key=lambda login: login.made_s)
    if chosen.json:
        rows = [(key.id, key.name, key.role, key.kind, key.made_s, key.end_s) for key in keys]
        people = [(login.id, login.name, login.role, login.made_s, login.end_s) for login in logins]
        names = ("id", "name", "role", "kind", "since_s", "end_s")
        sessions = [dict(zip((*names[:3], *names[4:]), row, strict=True)) for row in people]
        write_json({"keys": [dict(zip(names, row, strict=True)) for row in rows], "sessions": sessions})
        return 0
    for key in keys:
        write(f"{key.id:14}{key.name:20}{key.role:10}{KINDS[key.kind]:20}{until(key.end_s)}")
    for login in logins:
        write(f"{login.id:14}{login.name:20}{login.role:10}{'signed in':20}{until(login.end_s)}")
    return 0


def revoke(chosen: argparse.Namespace) -> int:
    """End one. Raises BadInput where there is none of that id or name, or several of that name."""
    from console.access.records import AccessFile, Change
    from console.data_folder import home_folder

    file = AccessFile(home_folder(chosen.data))
    digest, name = named(file.read(), chosen.which)
    file.change([Change(revoked=frozenset({digest}))])
    return answer(chosen, {"revoked": name}, f"{name} is revoked; a running console signs it out within a second.")


def named(found: Records, which: str) -> tuple[str, str]:
    """An id or a name → (digest, name). Raises BadInput."""
    rows = [(one.digest, one.id, one.name) for one in (*found.keys.values(), *found.logins.values())]
    alike = [row for row in rows if row[1] == which] or [row for row in rows if row[2] == which]
    if not alike:
        raise BadInput(f"There is no key or login {which[:40]!r}; see: beckon token list")
    if len(alike) > 1:
        raise BadInput(f"Several are called {which[:40]!r}; give the id that beckon token list shows.")
    return alike[0][0], alike[0][2]


def tidy(given: str) -> str:
    """A name in its tidy form. Raises BadInput for one that cannot be read as it is."""
    from console.people.store import MAX_NAME_CHARACTERS, is_name

    name = unicodedata.normalize("NFC", " ".join(given.split()))
    if not is_name(name):
        raise BadInput(f"A name has 1 to {MAX_NAME_CHARACTERS} letters or signs, all of them to be seen.")
    return name


def until(end: float | None) -> str:
    """When it ends, in words."""
    return "until revoked" if end is None else time.strftime("until %Y-%m-%d %H:%M", time.localtime(end))
