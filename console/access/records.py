"""Keys and logins on disk: `access.json` in the data folder, its owner's alone. Fingerprints, never a secret.

The console and the command line both change it: under a lock, the file is read, the change is made to it, and the
whole is written again.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec

from core.errors import BadInput, Unavailable, Unwritable
from core.files import is_intact, locked, reason, saving, sealed, write_atomic

FILE = "access.json"
LOCK = "access.lock"
NOT_KEPT = "Keys and logins could not be saved"

KeyKind = Literal["start", "link", "file", "program"]
"""Printed when the console starts; made for someone; read from --token-file; fixed, for a program."""


RANK = {"public": 0, "viewer": 1, "operator": 2, "admin": 3}
BY_KEY = "token-"  # begins the id of who shows a key with every request


@dataclass(frozen=True)
class Person:
    """A person who is signed in, as others see them."""

    id: str
    name: str
    role: str = "operator"  # viewer | operator | admin

    def may(self, role: str) -> bool:
        """Return whether this person's role reaches `role`."""
        return RANK[self.role] >= RANK[role]


class KeyRecord(msgspec.Struct, frozen=True):
    """A secret by its fingerprint, and what it opens."""

    digest: str  # SHA-256, hexadecimal
    name: str
    role: Literal["viewer", "operator", "admin"]
    kind: KeyKind
    made_s: float  # Unix time
    end_s: float | None = None  # Unix time; None: until it is revoked

    @property
    def id(self) -> str:
        """How it is called where the secret is not to be seen."""
        return self.digest[:8]

    @property
    def person(self) -> Person:
        """The program that shows this key with every request."""
        return Person(f"{BY_KEY}{self.id}", self.name, self.role)


class LoginRecord(msgspec.Struct, frozen=True):
    """A login of a browser, by the fingerprint of its cookie."""

    digest: str  # SHA-256, hexadecimal
    id: str  # of the person
    name: str
    role: Literal["viewer", "operator", "admin"]
    key: str  # digest of the key that opened it; "": one that was good once
    made_s: float  # Unix time
    end_s: float  # Unix time
    key_name: str = ""  # of the key that opened it, which may be gone; "": an earlier console has not kept it

    @property
    def person(self) -> Person:
        return Person(self.id, self.name, self.role)


class Records(msgspec.Struct):
    """All keys and logins, by their digests."""

    keys: dict[str, KeyRecord] = msgspec.field(default_factory=dict[str, KeyRecord])
    logins: dict[str, LoginRecord] = msgspec.field(default_factory=dict[str, LoginRecord])

    def copy(self) -> Records:
        return Records(dict(self.keys), dict(self.logins))

    @property
    def people(self) -> dict[str, Person]:
        """Everybody who may act, by the digest that lets them."""
        return {digest: one.person for digest, one in (*self.logins.items(), *self.keys.items())}


class Change(msgspec.Struct, frozen=True):
    """Entries to put into the records, and digests that leave them: revoked with the logins that a key opened, or
    merely over.
    """

    keys: tuple[KeyRecord, ...] = ()
    logins: tuple[LoginRecord, ...] = ()
    revoked: frozenset[str] = frozenset()
    over: frozenset[str] = frozenset()

    def apply(self, records: Records) -> None:
        """Make it. A login whose key was revoked meanwhile does not come in."""
        records.keys |= {key.digest: key for key in self.keys}
        records.logins |= {one.digest: one for one in self.logins if not one.key or one.key in records.keys}
        orphans = {one.digest for one in records.logins.values() if one.key in self.revoked}
        for digest in self.revoked | self.over | orphans:
            records.keys.pop(digest, None)
            records.logins.pop(digest, None)


class AccessFile:
    """The file of one data folder. Reads and writes wait for the disk: not for the event loop."""

    def __init__(self, home: Path) -> None:
        self.path = home / FILE
        self._lock = home / LOCK
        self._seen: tuple[int, int, int] | None = None

    def read(self) -> Records:
        """All of it; empty where there is none yet. Raises BadInput for a file that is damaged, Unavailable."""
        try:
            raw = self.path.read_bytes()
        except FileNotFoundError:
            return Records()
        except OSError as trouble:
            raise Unavailable(f"{self.path} cannot be read: {reason(trouble)}") from None
        try:
            if not is_intact(msgspec.json.decode(raw, type=dict[str, object])):
                raise ValueError
            return msgspec.json.decode(raw, type=Records)
        except (ValueError, msgspec.MsgspecError):
            raise BadInput(
                f"{self.path} is damaged. Move it away: then everybody signs in again, and programs need new keys."
            ) from None

    def change(self, changes: Iterable[Change]) -> Records:
        """Make changes → all of it then. Raises BadInput, Unavailable, Unwritable."""
        with saving(NOT_KEPT), locked(self._lock):
            records = self.read()
            before = records.copy()
            for change in changes:
                change.apply(records)
            if records != before:
                document = sealed(msgspec.to_builtins(records))
                write_atomic(self.path, msgspec.json.format(msgspec.json.encode(document)) + b"\n", 0o600)
            self._seen = self._stamp()
        return records

    def changed(self) -> bool:
        """Return whether another process has changed it since this one last did."""
        return self._stamp() != self._seen

    def put_aside(self) -> Path:
        """Move a damaged file out of the way → where it is now. Raises Unwritable."""
        aside = self.path.with_name(f"{FILE}.damaged")
        try:
            self.path.replace(aside)
        except OSError as trouble:
            raise Unwritable(f"{self.path} is damaged and cannot be moved away: {reason(trouble)}") from None
        return aside

    def _stamp(self) -> tuple[int, int, int] | None:
        try:
            found = self.path.stat()
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns, found.st_size
