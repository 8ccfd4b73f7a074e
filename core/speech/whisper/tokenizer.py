"""Text ↔ tokens: byte-level byte-pair encoding out of a `tokenizer.json` (Sennrich et al., 2016; GPT-2's form)."""

import re
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import msgspec

from core.errors import BadInput

MOST_BYTES = 8_000_000
PIECE = re.compile(r"'(?:s|t|re|ve|m|ll|d)| ?[A-Za-z]+| ?[0-9]+| ?[^\sA-Za-z0-9]+|\s+")
"""Tokens never reach over the bounds of such pieces."""


class _Model(msgspec.Struct):
    vocab: dict[str, int]
    merges: list[str | tuple[str, str]]


class _File(msgspec.Struct):
    model: _Model


def _letters() -> dict[int, str]:
    """Return the printable letter that stands for each byte in the file."""
    plain = [*range(ord("!"), ord("~") + 1), *range(ord("¡"), ord("¬") + 1), *range(ord("®"), ord("ÿ") + 1)]
    rest = [byte for byte in range(256) if byte not in plain]
    return {byte: chr(byte) for byte in plain} | {byte: chr(256 + place) for place, byte in enumerate(rest)}


class Tokenizer:
    """The tokens of one model."""

    def __init__(self, path: Path) -> None:
        """Raises BadInput where the file is no tokenizer of this form."""
        try:
            if path.stat().st_size > MOST_BYTES:
                raise BadInput(f"{path.name!r} is too long for a tokenizer.")
            model = msgspec.json.decode(path.read_bytes(), type=_File).model
        except (OSError, msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as trouble:
            raise BadInput(f"{path.name!r} is no usable tokenizer ({trouble}). Get the model again.") from None
        pairs = (one if isinstance(one, str) else " ".join(one) for one in model.merges)
        self._ranks = {pair: rank for rank, pair in enumerate(pairs)}  # "a b"
        self._ids = model.vocab
        self._letters = _letters()
        self._bytes = {letter: byte for byte, letter in self._letters.items()}
        if any(letter not in self._ids for letter in self._bytes):
            raise BadInput(f"{path.name!r} is no usable tokenizer: single letters are missing. Get the model again.")
        self._known: dict[str, tuple[int, ...]] = {}

    def encode(self, text: str) -> tuple[int, ...]:
        """Text → tokens."""
        for piece in (pieces := PIECE.findall(text)):
            if piece not in self._known:
                self._known[piece] = self._merged(piece)
        return tuple(token for piece in pieces for token in self._known[piece])

    def raw(self, tokens: Iterable[int]) -> list[bytes]:
        """Return the bytes of each token; special ones have none."""
        texts = {number: text for text, number in self._ids.items()}
        letters = (texts.get(token, "") for token in tokens)
        return [bytes(self._bytes[letter] for letter in text if letter in self._bytes) for text in letters]

    def _merged(self, piece: str) -> tuple[int, ...]:
        parts = [self._letters[byte] for byte in piece.encode()]
        never = len(self._ranks)
        while len(parts) > 1:
            rank, at = min((self._ranks.get(" ".join(pair), never), at) for at, pair in enumerate(pairwise(parts)))
            if rank == never:
                break
            parts[at : at + 2] = [parts[at] + parts[at + 1]]
        return tuple(self._ids[part] for part in parts)
