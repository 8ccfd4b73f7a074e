"""Jobs: methods of workers that the console may call, and what crosses the pipe for them."""

import struct
from collections.abc import Callable
from functools import cache, cached_property, partial
from inspect import signature
from typing import (
    Annotated,
    Any,
    ClassVar,
    Concatenate,
    Generic,
    Literal,
    ParamSpec,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

import msgspec
import numpy as np

from core.errors import BeckonError
from core.message import Array
from core.sentences import SentenceCode
from core.sentences import plain as plain_words

LENGTH = struct.Struct("<I")
ArrayKind = Annotated[str, msgspec.Meta(pattern="^[<|][biuf][1248]$")]  # numbers as NumPy names them
Axes = Annotated[tuple[Annotated[int, msgspec.Meta(ge=0)], ...], msgspec.Meta(max_length=4)]

P = ParamSpec("P")
Answer = TypeVar("Answer")
Content = TypeVar("Content")
ErrorName = Literal["BadInput", "BadSettings", "Refused", "Unavailable", "Unwritable", "BeckonError"]


class Job(msgspec.Struct, Generic[Answer], frozen=True):
    """The arguments of a call on their way to a worker."""

    work: ClassVar[Callable[..., Any]]
    answer: ClassVar[Any]  # its type


class job(Generic[P, Answer]):
    """Mark a worker's method as one that the console may call: its annotated arguments and its result cross.

    Called on a worker it does the work, called on the worker's class it makes the Job to be sent there:
    `await worker.ask(RecorderWorker.cut(path, target, 0.0, 10.0), budget=60.0)`.
    """

    def __init__(self, work: Callable[Concatenate[Any, P], Answer]) -> None:
        self._work = work
        self.__isabstractmethod__ = getattr(work, "__isabstractmethod__", False)

    @overload
    def __get__(self, worker: None, owner: type) -> Callable[P, Job[Answer]]: ...
    @overload
    def __get__(self, worker: object, owner: type) -> Callable[P, Answer]: ...
    def __get__(self, worker: object | None, owner: type) -> Callable[P, Any]:
        return self.kind if worker is None else partial(self._work, worker)  # pyright: ignore

    @cached_property
    def kind(self) -> type[Job[Answer]]:
        """The message with the arguments of a call."""
        work, hints = self._work, get_type_hints(self._work, include_extras=True)
        fields: list[Any] = []
        for one in (one for one in signature(work).parameters.values() if one.name in hints):
            fields.append((one.name, hints[one.name], *([] if one.default is one.empty else [one.default])))
        name, own = work.__name__, {"work": staticmethod(work), "answer": hints["return"]}
        kind: Any = msgspec.defstruct(name, fields, bases=(Job,), namespace=own, tag=name, frozen=True)
        return kind


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


@cache
def answer_decoder(kind: type[Job[Answer]]) -> msgspec.msgpack.Decoder[JobResult[Answer] | JobFailure]:
    return decoder(JobResult[kind.answer] | JobFailure)


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
