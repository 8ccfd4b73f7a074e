"""Messages between the console and its workers: jobs, each with the type of its answer, and what comes back."""

import struct
from collections.abc import Callable, Iterator
from functools import cache
from inspect import getmembers, isfunction
from typing import Annotated, Any, Generic, Literal, TypeVar, get_args, get_origin, get_type_hints

import msgspec
import numpy as np

from core.errors import BeckonError
from core.message import Array
from core.sentences import SentenceCode
from core.sentences import plain as plain_words

LENGTH = struct.Struct("<I")
ArrayKind = Annotated[str, msgspec.Meta(pattern="^[<|][biuf][1248]$")]  # numbers as NumPy names them
Axes = Annotated[tuple[Annotated[int, msgspec.Meta(ge=0)], ...], msgspec.Meta(max_length=4)]

Answer = TypeVar("Answer")
Content = TypeVar("Content")
ErrorName = Literal["BadInput", "BadSettings", "Refused", "Unavailable", "Unwritable", "BeckonError"]
Handler = tuple[type["Job[Any]"], Callable[[Any], object]]


class Job(msgspec.Struct, Generic[Answer], frozen=True, tag=True):
    """Base of all jobs: `class FindBoard(Job[FoundBoard], frozen=True)` is answered by a FoundBoard."""


class JobRequest(msgspec.Struct, Generic[Content], frozen=True):
    job: Content
    budget: float  # [s] of processor time


class JobResult(msgspec.Struct, Generic[Content], frozen=True, tag="result"):
    result: Content


class JobFailure(msgspec.Struct, frozen=True, tag="failure"):
    """The sentence that says why there is no answer; where Beckon itself failed, `details` for the log."""

    error: ErrorName
    sentence: str
    details: str = ""
    said: SentenceCode = SentenceCode()


def handlers_of(worker: object) -> Iterator[Handler]:
    """A worker's table: each public method whose argument is annotated with a kind of job does that job."""
    for name, work in getmembers(type(worker), isfunction):
        if name.startswith("_"):
            continue
        for argument, given in get_type_hints(work).items():
            for kind in get_args(given) or (given,):
                if argument != "return" and isinstance(kind, type) and issubclass(kind, Job):
                    yield kind, getattr(worker, name)


def answer_type(kind: type[Job[Any]]) -> Any:
    bases = (base for each in kind.__mro__ for base in each.__dict__.get("__orig_bases__", ()))
    return get_args(next(base for base in bases if get_origin(base) is Job))[0]


@cache
def answer_decoder(kind: type[Job[Answer]]) -> msgspec.msgpack.Decoder[JobResult[Answer] | JobFailure]:
    return decoder(JobResult[answer_type(kind)] | JobFailure)


def error_name(error: BeckonError) -> ErrorName:
    """Return the name under which an error crosses: its own, or that of what it is made from."""
    names = (each.__name__ for each in type(error).__mro__)
    return msgspec.convert(next(name for name in names if name in get_args(ErrorName)), ErrorName)


def packed(message: msgspec.Struct) -> bytes:
    """A message as it goes through the pipe; core's own values are written as they are, with their arrays."""
    raw = msgspec.msgpack.encode(message, enc_hook=plain)
    return LENGTH.pack(len(raw)) + raw


def decoder(kind: Any) -> msgspec.msgpack.Decoder[Any]:
    """Return the decoder of this type, in which arrays of numbers may stand."""
    return msgspec.msgpack.Decoder(kind, dec_hook=_array)


class PackedArray(msgspec.Struct, frozen=True, array_like=True):
    """An array on its way: nothing but numbers, no larger than its message."""

    kind: ArrayKind
    shape: Axes
    numbers: bytes


def plain(value: object) -> object:
    """NumPy's values and sentences → those that msgspec writes. Raises NotImplementedError for anything else."""
    if isinstance(value, np.generic):
        return value.item()
    if not isinstance(value, np.ndarray):
        return plain_words(value)
    array: Array = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
    return array.dtype.str, array.shape, array.tobytes()


def _array(kind: Any, given: object) -> Array:
    """An array as another process packed it. Raises ValidationError where it is none."""
    if get_origin(kind) is not np.ndarray:
        raise NotImplementedError(f"Objects of type {kind} do not cross.")
    found = msgspec.convert(given, PackedArray)
    try:
        return np.frombuffer(found.numbers, found.kind).reshape(found.shape)
    except (TypeError, ValueError) as wrong:
        raise msgspec.ValidationError(str(wrong)) from None
