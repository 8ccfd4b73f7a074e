"""Logins: tokens open a login, a login is a random id in a cookie. All in memory; a restart ends every login."""

from __future__ import annotations

import hashlib
import hmac
import itertools
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from math import inf

RANK = {"public": 0, "viewer": 1, "operator": 2, "admin": 3}

BY_KEY = "token-"  # begins the id of who shows a key with every request
LIFE = 12 * 3600.0  # [s] of a login
WINDOW = 60.0  # [s] in which an address may be wrong
WRONG = 5  # times
MOST_LOGINS = 300  # of one role
MOST_ADDRESSES = 1000  # that are remembered for being wrong


@dataclass(frozen=True)
class Person:
    """A person who is signed in, as others see them."""

    id: str
    name: str
    role: str = "operator"  # viewer | operator | admin

    def may(self, role: str) -> bool:
        """Return whether this person's role reaches `role`."""
        return RANK[self.role] >= RANK[role]


ANYBODY = Person("local", "operator", "operator")
"""Who acts where no login is asked for: on this machine, with the simulator."""


@dataclass(frozen=True)
class LoginToken:
    """A secret's fingerprint and the login that it opens."""

    digest: bytes
    name: str
    role: str
    once: bool = False  # spent by the first login
    end: float = inf  # [s] after which it opens nothing more


class Logins:
    """Tokens, the logins they opened, and the addresses that guessed."""

    def __init__(self) -> None:
        self._tokens: list[LoginToken] = []
        self._open: dict[str, tuple[Person, float]] = {}  # cookie → person, end [s]
        self._wrong: dict[str, list[float]] = {}
        self._names = 0

    def issue(self, name: str, role: str, *, once: bool = False, end: float = inf) -> str:
        """Make a token of 256 bits, good for one login or for many, until `end` [s]; only its fingerprint is kept."""
        token = secrets.token_urlsafe(32)
        self._tokens.append(LoginToken(fingerprint(token), name, role, once, end))
        return token

    def bearer(self, token: str) -> Person | None:
        """The script that shows this token."""
        found = self._token(token)
        found = None if found is None or found.once else found
        return Person(f"{BY_KEY}{found.digest.hex()[:8]}", found.name, found.role) if found else None

    def open(
        self, token: str, name: str, now: float, shown: str = "", present: Callable[[Person], bool] = lambda _: False
    ) -> tuple[str, Person] | None:
        """A token → (cookie, person), or None when it is wrong. `name` is how the person wants to be called.

        A browser that shows the cookie of a login with the same role (another tab) keeps its person. Where
        a role has too many logins, the eldest of that role whose person is not `present` ends.
        """
        found = self._token(token)
        if found is None or now >= found.end:
            return None
        if found.once:
            self._tokens.remove(found)
        same = self.of_cookie(shown, now)
        if same is not None and same.role == found.role:
            self._open[shown] = (same, now + LIFE)
            return shown, same
        self._make_room(found.role, present)
        self._names += 1
        cookie = secrets.token_urlsafe(32)
        person = Person(secrets.token_hex(6), self._unique_name(name or f"{found.name} {self._names}"), found.role)
        self._open[cookie] = (person, now + LIFE)
        return cookie, person

    def of_cookie(self, cookie: str, now: float) -> Person | None:
        """The person behind a cookie, while the login lasts."""
        person, end = self._open.get(cookie, (None, 0.0))
        return person if now < end else None

    def close(self, person: Person) -> None:
        """End this person's login."""
        self._open = {cookie: entry for cookie, entry in self._open.items() if entry[0].id != person.id}

    def expire(self, now: float) -> list[Person]:
        """End the logins whose time is over; whose they were."""
        over = [person for person, end in self._open.values() if now >= end]
        for person in over:
            self.close(person)
        return over

    def blocked(self, address: str, now: float) -> bool:
        """Return whether this address has been wrong too often within the last minute."""
        recent = [moment for moment in self._wrong.get(address, ()) if now - moment < WINDOW]
        if recent:
            self._wrong[address] = recent
        else:
            self._wrong.pop(address, None)
        return len(recent) >= WRONG

    def guessed(self, address: str, now: float) -> None:
        """This address showed a wrong token."""
        if len(self._wrong) >= MOST_ADDRESSES:
            self._wrong.pop(next(iter(self._wrong)))
        self._wrong.setdefault(address, []).append(now)

    def _unique_name(self, name: str) -> str:
        """Return the name, with a number where another person has the same name."""
        others = {person.name.casefold() for person, _ in self._open.values()}
        numbered = (name if number == 1 else f"{name} ({number})" for number in itertools.count(1))
        return next(name for name in numbered if name.casefold() not in others)

    def _make_room(self, role: str, present: Callable[[Person], bool]) -> None:
        alike = [(cookie, person) for cookie, (person, _) in self._open.items() if person.role == role]
        if len(alike) >= MOST_LOGINS:
            absent = (cookie for cookie, person in alike if not present(person))
            self._open.pop(next(absent, alike[0][0]))

    def _token(self, token: str) -> LoginToken | None:
        shown = fingerprint(token)
        found = None
        for known in self._tokens:
            if hmac.compare_digest(known.digest, shown):
                found = known
        return found


def fingerprint(token: str) -> bytes:
    """SHA-256 of a token of any characters."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()
