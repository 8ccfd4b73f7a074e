"""Messages between the console and its workers: jobs, each with the type of its answer, and what comes back."""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any, Generic, Literal, Protocol, Self, TypeVar, get_args, get_origin

import msgspec

from core.errors import BeckonError

LENGTH = struct.Struct("<I")

Answer = TypeVar("Answer")
Content = TypeVar("Content")
ErrorName = Literal["BadInput", "BadSettings", "Refused", "Unavailable", "Unwritable", "BeckonError"]
Handler = tuple[type["Job[Any]"], Callable[[Any], object]]


class Job(msgspec.Struct, Generic[Answer], frozen=True, tag=True):
    """Base of all jobs: `class FindBoard(Job[FoundBoard], frozen=True)` is answered by a FoundBoard."""

    @classmethod
    def handled_by(cls, work: Callable[[Self], Answer]) -> Handler:
        """Return a row of a worker's table of handlers."""
        return cls, work


class JobWorker(Protocol):
    """A worker: its table says which function does which job."""

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """Every job it knows."""
        ...


class JobRequest(msgspec.Struct, Generic[Content], frozen=True):
    """A job on its way to a worker."""

    job: Content
    budget: float  # [s] of processor time


class JobResult(msgspec.Struct, Generic[Content], frozen=True, tag="result"):
    """The answer to a job."""

    result: Content


class JobFailure(msgspec.Struct, frozen=True, tag="failure"):
    """The sentence that says why there is no answer, and for the log where Beckon itself failed."""

    error: ErrorName
    sentence: str
    details: str = ""


@cache
def answer_decoder(kind: type[Job[Answer]]) -> msgspec.msgpack.Decoder[JobResult[Answer] | JobFailure]:
    """Return the decoder of what comes back for jobs of this kind."""
    bases = (base for each in kind.__mro__ for base in each.__dict__.get("__orig_bases__", ()))
    answer = get_args(next(base for base in bases if get_origin(base) is Job))[0]
    return msgspec.msgpack.Decoder(JobResult[answer] | JobFailure)


def error_name(error: BeckonError) -> ErrorName:
    """Return the name under which an error crosses: its own, or that of what it is made from."""
    names = (each.__name__ for each in type(error).__mro__)
    return msgspec.convert(next(name for name in names if name in get_args(ErrorName)), ErrorName)


def packed(message: msgspec.Struct) -> bytes:
    """A message as it goes through the pipe."""
    raw = msgspec.msgpack.encode(message)
    return LENGTH.pack(len(raw)) + raw
