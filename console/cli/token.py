"""`beckon token`: fixed keys for programs, who is signed in, and the end of a key or a login."""

from __future__ import annotations

import argparse
import time
import unicodedata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from console.cli.answer import add_command, answer, tell, write, write_json
from core.errors import BadInput

if TYPE_CHECKING:
    from console.access.records import KeyRecord, LoginRecord, Records

KINDS = {"start": "printed at a start", "link": "link", "file": "--token-file", "program": "program"}


def add(subcommands: Any) -> None:
    parser = subcommands.add_parser("token", help="keys for programs; who may sign in")
    doings = parser.add_subparsers(dest="doing", metavar="DOING", required=True)
    adding = add_command(doings, "add", add_token, "make a fixed key for a program")
    adding.add_argument("name", metavar="NAME", help="of the program")
    adding.add_argument("--role", choices=("viewer", "operator", "admin"), required=True)
    listing = add_command(doings, "list", list_tokens, "all keys, links and logins; never a secret")
    revoking = add_command(doings, "revoke", revoke, "end a key with the logins that it opened, or one login")
    revoking.add_argument("which", metavar="ID|NAME", help="as beckon token list shows them")
    for one in (adding, listing, revoking):
        one.add_argument("--data", type=Path, metavar="DIR", help="the console's data folder")


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
    from console.access.records import AccessFile
    from console.data_folder import home_folder

    found = AccessFile(home_folder(chosen.data)).read()
    keys = sorted(found.keys.values(), key=lambda key: key.made_s)
    logins = sorted(found.logins.values(), key=lambda login: login.made_s)

    def row(one: KeyRecord | LoginRecord, **more: str) -> dict[str, object]:
        return {"id": one.id, "name": one.name, "role": one.role, **more, "since_s": one.made_s, "end_s": one.end_s}

    report = {"keys": [row(one, kind=one.kind) for one in keys], "sessions": [row(one) for one in logins]}
    shown = [(one, KINDS[one.kind]) for one in keys] + [(one, "signed in") for one in logins]
    lines = (f"{one.id:14}{one.name:20}{one.role:10}{kind:20}{until(one.end_s)}" for one, kind in shown)
    return answer(chosen, report, *lines)


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
    return "until revoked" if end is None else time.strftime("until %Y-%m-%d %H:%M", time.localtime(end))
