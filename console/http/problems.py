"""Errors as the web tells them: `application/problem+json`, one sentence to act on, never the input."""

from collections.abc import Mapping, MutableMapping
from http import HTTPStatus
from typing import Any

import msgspec

from console.messages import state as messages
from core.errors import BadInput, BeckonError, Refused, Unavailable, Unwritable
from core.sentences import code_of, plain

MEDIA_TYPE = b"application/problem+json"

Headers = list[tuple[bytes, bytes]]


class Problem(Exception):
    """A refusal with its HTTP status; `more` holds further keys of the answer, such as suggestions."""

    def __init__(
        self,
        status: int,
        detail: str,
        *,
        headers: Mapping[str, str] | None = None,
        more: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.detail = detail
        self.headers = dict(headers or {})
        self.more = dict(more or {})

    def body(self) -> bytes:
        title = HTTPStatus(self.status).phrase
        body = {"type": "about:blank", "title": title, "status": self.status, "detail": self.detail, **self.more}
        found = code_of(self.detail)
        return msgspec.json.encode(body if found.code is None else body | found._asdict(), enc_hook=plain)

    def header_list(self) -> Headers:
        extra = [(name.lower().encode(), value.encode()) for name, value in self.headers.items()]
        return [(b"content-type", MEDIA_TYPE), (b"content-length", str(len(self.body())).encode()), *extra]


def wanted_page(scope: MutableMapping[str, Any]) -> str | None:
    """Return the way from the address that a browser opens to the root of the console; None for a program."""
    accepts = b"".join(value for name, value in scope["headers"] if name == b"accept")
    if scope["type"] != "http" or scope["method"] != "GET" or b"text/html" not in accepts:
        return None
    return "../" * (scope["path"].count("/") - 1) or "./"


STATUS = ((BadInput, 422), (Refused, 409), (Unwritable, 507), (Unavailable, 503))


def problem_of(error: BeckonError) -> Problem:
    """An error of the core → the same sentence with a proper status."""
    status = next((status for kind, status in STATUS if isinstance(error, kind)), 500)
    return Problem(status, str(error))


def refused(ref: int, error: Problem | BeckonError) -> messages.AnswerMessage:
    problem = error if isinstance(error, Problem) else problem_of(error)
    found = code_of(problem.detail)
    return messages.AnswerMessage(
        ref,
        False,
        problem.status,
        problem.detail,
        problem.more.get("suggestions"),
        code=found.code,
        values=found.values,
    )
