"""Whisper's encoder and decoder (Radford et al., 2022; Vaswani et al., 2017): pre-norm transformers in 32-bit floats.

The encoder reads the sound and some seconds of silence instead of 30 s: a shorter table of positions does for it. The
decoder keeps the keys and values of what every row has said, and shares those of the sound among all rows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from core.message import Array
from core.speech.whisper.model_file import ModelFile

HEAD_VALUES = 64  # values of an attention head
CONTEXT_FRAMES = 1500  # frames of 20 ms that the encoder knows
MAX_TOKENS = 448  # tokens that the decoder knows
TOKEN_COUNT = 51_864  # tokens of English-only models
ALIGNED = {
    (4, 6): ((1, 0), (2, 0), (2, 5), (3, 0), (3, 1), (3, 2), (3, 3), (3, 4)),  # tiny.en
    (6, 8): ((3, 3), (4, 7), (5, 1), (5, 5), (5, 7)),  # base.en
}
"""Layers and heads that look at the word which is written, by how many there are (published with the models)."""
NORM_EPSILON = 1e-5
CACHED_VALUES = 65_536  # values of which a core's cache holds several arrays
ROOT_HALF = np.float32(math.sqrt(0.5))
ERF = tuple(map(np.float32, (1.061405429, -1.453152027, 1.421413741, -0.284496736, 0.254829592)))


@dataclass(frozen=True)
class Linear:
    """y = x Wᵀ + b."""

    weight: Array  # (outputs, inputs), in 32-bit floats or as in the file
    bias: Array  # (outputs,)

    def __call__(self, x: Array) -> Array:
        """x (…, inputs) → (…, outputs)."""
        return x @ self.weight.astype(np.float32, copy=False).T + self.bias


@dataclass(frozen=True)
class Norm:
    """Layer normalisation."""

    gamma: Array  # (width,)
    beta: Array  # (width,)

    def __call__(self, x: Array) -> Array:
        """x (…, width) → the same shape."""
        centred = x - x.mean(-1, keepdims=True)
        variance = np.mean(centred * centred, -1, keepdims=True)
        return centred / np.sqrt(variance + np.float32(NORM_EPSILON)) * self.gamma + self.beta


@dataclass(frozen=True)
class FeedForward:
    """The part of a layer that looks at one place at a time."""

    norm: Norm
    wide: Linear
    narrow: Linear

    def __call__(self, x: Array) -> Array:
        """x (…, width) → what is added to it."""
        return self.narrow(gelu(self.wide(self.norm(x))))


@dataclass(frozen=True)
class SelfAttention:
    """The part of a layer that looks at other places of the same sequence."""

    norm: Norm
    stacked: Linear  # queries, keys and values
    out: Linear


@dataclass(frozen=True)
class CrossAttention:
    """The part of a decoder's layer that looks at the sound."""

    norm: Norm
    query: Linear
    stacked: Linear  # keys and values
    out: Linear


@dataclass(frozen=True)
class EncoderLayer:
    """One layer of the encoder."""

    attention: SelfAttention
    feed: FeedForward


@dataclass(frozen=True)
class DecoderLayer:
    """One layer of the decoder."""

    attention: SelfAttention
    cross: CrossAttention
    feed: FeedForward


def gelu(x: Array) -> Array:
    """x Φ(x) of 32-bit floats, within 5e-7; Φ by Abramowitz and Stegun's formula 7.1.26."""
    values = x.reshape(-1)
    parts = [_gelu(values[begin : begin + CACHED_VALUES]) for begin in range(0, len(values), CACHED_VALUES)]
    return np.concatenate(parts).reshape(x.shape) if parts else x


def _gelu(x: Array) -> Array:
    """The same of few values."""
    size = np.abs(x) * ROOT_HALF
    t = 1 / (1 + np.float32(0.3275911) * size)
    polynomial = t * ERF[0]
    for factor in ERF[1:]:
        polynomial += factor
        polynomial *= t
    upper = np.float32(0.5) * polynomial * np.exp(-size * size)  # 1 - Φ(|x|)
    return np.where(x < 0, x * upper, x - x * upper)


def softmax(scores: Array) -> Array:
    """Scores (…, K) → probabilities."""
    raised = np.exp(scores - scores.max(-1, keepdims=True))
    return raised / raised.sum(-1, keepdims=True)


def heads(x: Array) -> Array:
    """(…, T, width) → (…, H, T, 64)."""
    return np.swapaxes(x.reshape(*x.shape[:-1], -1, HEAD_VALUES), -2, -3)


def joined(x: Array) -> Array:
    """(…, H, T, 64) → (…, T, width)."""
    swapped = np.swapaxes(x, -2, -3)
    return swapped.reshape(*swapped.shape[:-2], -1)


def attention(query: Array, key: Array, mask: Array | None = None) -> Array:
    """Queries (…, H, Q, 64), keys (…, H, K, 64), mask (Q, K) that is added → weights (…, H, Q, K)."""
    scores = query @ np.swapaxes(key, -1, -2) * np.float32(HEAD_VALUES**-0.5)
    return softmax(scores if mask is None else scores + mask)


def attend(query: Array, key: Array, value: Array, mask: Array | None = None) -> Array:
    """Queries (…, H, Q, 64), keys and values (…, H, K, 64), mask (Q, K) that is added → (…, H, Q, 64)."""
    return attention(query, key, mask) @ value


class Encoder:
    """Log mel spectrogram → what was heard."""

    def __init__(self, model: ModelFile) -> None:
        """Raises BadInput where a weight is missing."""
        self._positions = model.get("encoder/position_encodings/encodings", CONTEXT_FRAMES, None)
        width = self.width = self._positions.shape[1]
        self._first = _convolution(model, "conv1", width, 80)
        self._second = _convolution(model, "conv2", width, width)
        self._layers = [
            EncoderLayer(
                _self_attention(model, f"encoder/layer_{i}", width, compact=True),
                _feed(model, f"encoder/layer_{i}", width, compact=True),
            )
            for i in range(model.layers("encoder"))
        ]
        self._norm = _norm(model, "encoder", width)

    def __call__(self, mel: Array) -> Array:
        """Log mel spectrogram (80, F), F even and at most 3000 → (F/2, width)."""
        x = gelu(_convolved(mel.T, self._first, 1))
        x = gelu(_convolved(x, self._second, 2))
        x = x + self._positions[: len(x)]
        for layer in self._layers:
            query, key, value = np.split(layer.attention.stacked(layer.attention.norm(x)), 3, axis=-1)
            x = x + layer.attention.out(joined(attend(heads(query), heads(key), heads(value))))
            x = x + layer.feed(x)
        return self._norm(x)


@dataclass(frozen=True)
class DecoderWeights:
    """All numbers of a decoder, in 32-bit floats but for those that are used once in an utterance."""

    embeddings: Array  # (V, width)
    positions: Array  # (448, width)
    layers: tuple[DecoderLayer, ...]
    norm: Norm

    @classmethod
    def of(cls, model: ModelFile, width: int, tokens: Array) -> DecoderWeights:
        """Read them; `tokens` (V,): those that may be written. Raises BadInput where a weight is missing."""
        layers = range(model.layers("decoder"))
        weights = cls(
            model.rows("decoder/embeddings/weight", tokens, TOKEN_COUNT, width),
            model.get("decoder/position_encodings/encodings", MAX_TOKENS, width),
            tuple(_decoder_layer(model, f"decoder/layer_{i}", width) for i in layers),
            _norm(model, "decoder", width),
        )
        model.rest()  # rows of a table lie all over the file
        return weights


class Decoder:
    """Tokens so far and what was heard → what comes next."""

    def __init__(self, model: ModelFile, width: int, tokens: Array) -> None:
        """`tokens` (V,): those that it may write, counted from 0 here. Raises BadInput where a weight is missing."""
        self.width = width
        self._read = partial(DecoderWeights.of, model, width, tokens)
        self._weights: DecoderWeights | None = self._read()

    @property
    def weights(self) -> DecoderWeights:
        """Return the numbers, read again after a rest."""
        if self._weights is None:
            self._weights = self._read()
        return self._weights

    def rest(self) -> None:
        """Forget the numbers until they are needed: 50 MB of Whisper tiny.en, which are back in 15 ms."""
        self._weights = None

    def begin(self, heard: Array, first: int | None = None) -> Decoding:
        """Begin to write down what was heard (T, width), with the first so many of the tokens; None: with all."""
        return Decoding(self, heard, first)


class Decoding:
    """Rows of tokens that grow together, over one sound."""

    def __init__(self, decoder: Decoder, heard: Array, first: int | None = None) -> None:
        self._weights = decoder.weights
        self._written = self._weights.embeddings[:first].T
        self._sound = [
            tuple(heads(part) for part in np.split(layer.cross.stacked(heard), 2, axis=-1))
            for layer in self._weights.layers
        ]
        self._caches: list[tuple[Array, Array]] = []
        self._length = 0
        self._looks: list[Array] | None = None  # (H, tokens, T) of every layer, where they are wanted

    def prefill(self, tokens: tuple[int, ...]) -> Array:
        """Write the first tokens of a single row → scores of what follows them, (1, V)."""
        return self._step(np.array([tokens]))

    def advance(self, parents: list[int], tokens: list[int]) -> Array:
        """Each new row continues the row `parents[i]` with `tokens[i]` → scores of what follows, (rows, V)."""
        self._caches = [(key[parents], value[parents]) for key, value in self._caches]
        return self._step(np.array(tokens)[:, None])

    def alignment(self, tokens: tuple[int, ...]) -> Array:
        """Write the tokens of a single row → attention (tokens, T) to the sound: while the next token is written."""
        self._looks = []
        self._step(np.array([tokens]))
        looks, self._looks = np.array(self._looks), None  # (layers, H, tokens, T)
        layers, count = looks.shape[:2]
        half = [(layer, head) for layer in range(layers // 2, layers) for head in range(count)]
        return np.mean([looks[place] for place in ALIGNED.get((layers, count), half)], axis=0)

    @property
    def full(self) -> bool:
        """True where the decoder knows no further position."""
        return self._length >= MAX_TOKENS

    def _step(self, tokens: Array) -> Array:
        """Tokens (rows, T) → scores of what follows the last of each row, (rows, V)."""
        weights, (rows, count) = self._weights, tokens.shape
        places = np.tile(weights.positions[self._length : self._length + count], (rows, 1))
        x = weights.embeddings[tokens.reshape(-1)] + places  # flat, for products of two matrices: a third faster
        self._length += count
        mask = np.triu(np.full((count, count), -np.inf, np.float32), 1) if count > 1 else None
        caches: list[tuple[Array, Array]] = []
        for i, layer in enumerate(weights.layers):
            stacked = layer.attention.stacked(layer.attention.norm(x)).reshape(rows, count, -1)
            query, key, value = map(heads, np.split(stacked, 3, axis=-1))
            if self._caches:
                key = np.concatenate((self._caches[i][0], key), axis=2)
                value = np.concatenate((self._caches[i][1], value), axis=2)
            caches.append((key, value))
            x = x + layer.attention.out(joined(attend(query, key, value, mask)).reshape(x.shape))
            query = heads(layer.cross.query(layer.cross.norm(x)))
            key, value = self._sound[i]
            looks = attention(query, key)
            if self._looks is not None:
                self._looks.append(looks)
            x = x + layer.cross.out(joined(looks @ value))
            x = x + layer.feed(x)
        self._caches = caches
        return weights.norm(x[count - 1 :: count]) @ self._written


def _convolution(model: ModelFile, name: str, outputs: int, inputs: int) -> Linear:
    """A convolution over three places as one product."""
    weight = model.get(f"encoder/{name}/weight", outputs, inputs, 3)
    flat = np.ascontiguousarray(weight.transpose(0, 2, 1)).reshape(outputs, 3 * inputs)
    return Linear(flat, model.get(f"encoder/{name}/bias", outputs))


def _convolved(x: Array, convolution: Linear, stride: int) -> Array:
    """x (T, inputs) → (T / stride, outputs)."""
    padded = np.pad(x, ((1, 1), (0, 0)))
    return convolution(np.concatenate((padded[:-2:stride], padded[1:-1:stride], padded[2::stride]), axis=1))


def _norm(model: ModelFile, name: str, width: int) -> Norm:
    return Norm(model.get(f"{name}/layer_norm/gamma", width), model.get(f"{name}/layer_norm/beta", width))


def _linear(model: ModelFile, name: str, outputs: int, inputs: int, *, compact: bool = False) -> Linear:
    """`compact`: as in the file, which takes half the memory where it is used once in an utterance."""
    weight = (model.get_compact if compact else model.get)(f"{name}/weight", outputs, inputs)
    return Linear(weight, model.get(f"{name}/bias", outputs))


def _self_attention(model: ModelFile, layer: str, width: int, *, compact: bool = False) -> SelfAttention:
    name = f"{layer}/self_attention"
    return SelfAttention(
        _norm(model, name, width),
        _linear(model, f"{name}/linear_0", 3 * width, width, compact=compact),
        _linear(model, f"{name}/linear_1", width, width, compact=compact),
    )


def _feed(model: ModelFile, layer: str, width: int, *, compact: bool = False) -> FeedForward:
    name = f"{layer}/ffn"
    return FeedForward(
        _norm(model, name, width),
        _linear(model, f"{name}/linear_0", 4 * width, width, compact=compact),
        _linear(model, f"{name}/linear_1", width, 4 * width, compact=compact),
    )


def _decoder_layer(model: ModelFile, layer: str, width: int) -> DecoderLayer:
    name = f"{layer}/attention"
    cross = CrossAttention(
        _norm(model, name, width),
        _linear(model, f"{name}/linear_0", width, width),
        _linear(model, f"{name}/linear_1", 2 * width, width, compact=True),
        _linear(model, f"{name}/linear_2", width, width),
    )
    return DecoderLayer(_self_attention(model, layer, width), cross, _feed(model, layer, width))
