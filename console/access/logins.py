"""Logins: a key opens a login, a login is a random id in a cookie. Only fingerprints are kept, in memory and on disk.

All of it is decided in memory, on the clock that is passed in; `sync` brings memory and file together from a thread.
"""

import hashlib
import hmac
import itertools
import secrets
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Literal, cast

from console.access.records import RANK, AccessFile, Change, KeyKind, KeyRecord, LoginRecord, Person, Records
from core.errors import BadInput

Role = Literal["viewer", "operator", "admin"]

DAY = 24 * 3600.0
LOGIN_LIFE_S = 7 * DAY  # of a login
LINK_LIFE_S = 30 * DAY  # of a link
WRONG_WINDOW_S = 60.0  # in which an address may be wrong
MAX_WRONG = 5  # times
MOST_LOGINS = 300  # of one role
MOST_LINKS = 100  # of one role, in which the eldest end
MOST_ADDRESSES = 1000  # that are remembered for being wrong


ANYBODY = Person("local", "operator", "admin")
"""The person who acts where no login is asked for: on this machine, with the simulator."""


@dataclass(frozen=True)
class OnceToken:
    """A secret's fingerprint that opens one login and is never written down."""

    name: str
    role: Role
    end: float  # [s] after which it opens nothing more


class Logins:
    """Keys, the logins they opened, and the addresses that guessed. Lives on the event loop."""

    def __init__(self, file: AccessFile | None = None, ahead: float = 0.0) -> None:
        """`ahead`: Unix time less the clock that is passed in [s]; a clock that is set later ends no login."""
        self._file, self._ahead = file, ahead
        self._records = Records()
        self._unsaved: list[Change] = []
        self._once: dict[str, OnceToken] = {}
        self._wrong: dict[str, list[float]] = {}
        self._names = 0

    # keys

    def issue(self, name: str, role: str, *, once: bool = False, end: float = inf) -> str:
        """Make a key of 256 bits, good for one login or for many, until `end` [s] → the key, which is not kept."""
        token = new_token()
        if once:
            self._once[fingerprint(token)] = OnceToken(name, cast(Role, role), end)
        else:
            self.admit(token, name, role, "link", 0.0, end=end)
        return token

    def admit(self, token: str, name: str, role: str, kind: KeyKind, now: float, *, end: float = inf) -> KeyRecord:
        """Let a key open logins from `now` [s] to `end`; of links, the eldest beyond a number end."""
        wall = None if end == inf else end + self._ahead
        key = KeyRecord(fingerprint(token), name, cast(Role, role), kind, now + self._ahead, wall)
        alike = [old for old in self._records.keys.values() if old.end_s is not None and old.role == role]
        eldest = sorted(alike, key=lambda old: old.made_s)[: max(0, len(alike) + 1 - MOST_LINKS)]
        self._make(Change(keys=(key,), over=frozenset(old.digest for old in eldest)))
        return key

    def supersede_file_keys(self, keep: KeyRecord | None = None) -> None:
        """Revoke the keys of token files, or all of them but one, with the logins they opened."""
        others = (key.digest for key in self._records.keys.values() if key.kind == "file" and key != keep)
        if revoked := frozenset(others):
            self._make(Change(revoked=revoked))

    def bearer(self, token: str, now: float) -> Person | None:
        """The program that shows this key."""
        found = self._key(fingerprint(token), now)
        return found.person if found else None

    def all_keys(self) -> list[KeyRecord]:
        """All keys, eldest first."""
        return sorted(self._records.keys.values(), key=lambda key: key.made_s)

    def revoke_key(self, number: str) -> list[Person]:
        """End a key and the logins it opened → whose they were; nobody where there is no such key."""
        return self._end({key.digest for key in self._records.keys.values() if key.id == number})

    # logins

    def open(
        self, token: str, name: str, now: float, shown: str = "", present: Callable[[Person], bool] = lambda _: False
    ) -> tuple[str, Person] | None:
        """A key → (cookie, person), or None when it is wrong. `name` is how the person wants to be called.

        A browser that shows the cookie of a login with the same role (another tab) keeps its person. Where
        a role has too many logins, the eldest of that role whose person is not `present` ends.
        """
        digest = fingerprint(token)
        once, key = self._once.get(digest), self._key(digest, now)
        found = once if once is not None and now < once.end else key
        if found is None:
            return None
        self._once.pop(digest, None)
        opener = key.digest if key else ""
        same = self._login(shown, now)
        if same is not None and same.role == found.role:
            self._keep(shown, same.person, opener, found.name, now, made=same.made_s)
            return shown, same.person
        self._make_room(found.role, present)
        self._names += 1
        cookie = new_token()
        own = f"{found.name} {self._names}" if found.name in RANK else found.name  # of who says no name
        person = Person(secrets.token_hex(6), self._unique_name(name or own), found.role)
        self._keep(cookie, person, opener, found.name, now)
        return cookie, person

    def of_cookie(self, cookie: str, now: float) -> Person | None:
        """The person behind a cookie, while the login lasts."""
        found = self._login(cookie, now)
        return found.person if found else None

    def all_logins(self) -> list[LoginRecord]:
        """All logins, eldest first."""
        return sorted(self._records.logins.values(), key=lambda login: login.made_s)

    def close(self, person: Person) -> None:
        self.revoke_login(person.id)

    def revoke_login(self, number: str) -> list[Person]:
        """End the login of the person with this id → whose it was."""
        return self._end({login.digest for login in self._records.logins.values() if login.id == number})

    def expire(self, now: float) -> list[Person]:
        """End the keys and logins whose time is over → whose they were."""
        wall = now + self._ahead
        keys = (key.digest for key in self._records.keys.values() if key.end_s is not None and wall >= key.end_s)
        logins = {login.digest for login in self._records.logins.values() if wall >= login.end_s}
        return self._end(logins, frozenset(keys))

    # the disk

    def take_unsaved(self) -> list[Change]:
        return list(self._unsaved)

    def synced(self, on_disk: Records, saved: int) -> list[Person]:
        """The file holds this, with the first `saved` of the unsaved changes → the people whom others signed out."""
        del self._unsaved[:saved]
        before = self._records.people
        self._records = on_disk.copy()
        for change in self._unsaved:
            change.apply(self._records)
        after = self._records.people
        return [person for digest, person in before.items() if digest not in after]

    def open_file(self) -> str:
        """Read what earlier consoles left → a sentence where that was damaged, else "". Raises Unavailable."""
        if self._file is None:
            return ""
        damage = ""
        try:
            found = self._file.read()
        except BadInput:
            found, aside = Records(), self._file.put_aside()
            damage = f"Keys and logins were damaged and lie in {aside.name} now: programs need new keys."
        self.synced(found, 0)
        self._names = len(self._records.logins)
        return damage

    def write_out(self, changes: Iterable[Change]) -> Records | None:
        """From a thread: write changes, and read what others changed → all of it; None where nothing is new.

        Raises Unavailable, Unwritable.
        """
        pending = list(changes)
        if self._file is None or not (pending or self._file.changed()):
            return None
        return self._file.change(pending)

    # steps of the above

    def _make(self, change: Change) -> None:
        change.apply(self._records)
        if self._file is not None:
            self._unsaved.append(change)

    def _end(self, digests: set[str], over: frozenset[str] = frozenset()) -> list[Person]:
        if not digests | over:
            return []
        before = self._records.people
        self._make(Change(revoked=frozenset(digests), over=over))
        after = self._records.people
        return [person for digest, person in before.items() if digest not in after]

    def _keep(
        self, cookie: str, person: Person, opener: str, key_name: str, now: float, made: float | None = None
    ) -> None:
        wall = now + self._ahead
        role, since = cast(Role, person.role), wall if made is None else made
        login = LoginRecord(
            fingerprint(cookie), person.id, person.name, role, opener, since, wall + LOGIN_LIFE_S, key_name
        )
        self._make(Change(logins=(login,)))

    def _login(self, cookie: str, now: float) -> LoginRecord | None:
        found = self._records.logins.get(fingerprint(cookie))
        return found if found is not None and now + self._ahead < found.end_s else None

    def _key(self, digest: str, now: float) -> KeyRecord | None:
        found = None
        for known in self._records.keys.values():
            if hmac.compare_digest(known.digest, digest):
                found = known
        return found if found and (found.end_s is None or now + self._ahead < found.end_s) else None

    def _unique_name(self, name: str) -> str:
        others = {login.name.casefold() for login in self._records.logins.values()}
        numbered = (name if number == 1 else f"{name} ({number})" for number in itertools.count(1))
        return next(name for name in numbered if name.casefold() not in others)

    def _make_room(self, role: str, present: Callable[[Person], bool]) -> None:
        alike = [login for login in self.all_logins() if login.role == role]
        if len(alike) >= MOST_LOGINS:
            absent = (login for login in alike if not present(login.person))
            self._end({next(absent, alike[0]).digest})

    def blocked(self, address: str, now: float) -> bool:
        """Return whether this address has been wrong too often within the last minute."""
        recent = [moment for moment in self._wrong.get(address, ()) if now - moment < WRONG_WINDOW_S]
        if recent:
            self._wrong[address] = recent
        else:
            self._wrong.pop(address, None)
        return len(recent) >= MAX_WRONG

    def guessed(self, address: str, now: float) -> None:
        if len(self._wrong) >= MOST_ADDRESSES:
            self._wrong.pop(next(iter(self._wrong)))
        self._wrong.setdefault(address, []).append(now)


def new_token() -> str:
    """A secret of 256 bits, as it may stand in an address."""
    return secrets.token_urlsafe(32)


def key_for(
    home: Path, name: str, role: Role, kind: KeyKind, now: float, end: float | None = None
) -> tuple[str, KeyRecord]:
    """Make a key beside a console that may run; `now`, `end`: Unix time → the key and what is kept of it.

    Raises Unavailable, Unwritable.
    """
    token = new_token()
    key = KeyRecord(fingerprint(token), name, role, kind, now, end)
    AccessFile(home).change([Change(keys=(key,))])
    return token, key


def fingerprint(token: str) -> str:
    """SHA-256 of a token of any characters, hexadecimal."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
