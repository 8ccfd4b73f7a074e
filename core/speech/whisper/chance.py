"""How likely words are written down by chance: by the decoder without any sound, its internal language model (Meng et
al., 2021). What people often say is also heard where something else was said.
"""

from collections.abc import Sequence

import numpy as np

from core.message import Array
from core.speech.whisper.transformer import Decoder, Decoding


def by_chance(
    decoder: Decoder, begin: tuple[int, int], end: int, texts: Sequence[Sequence[int]], first: int | None = None
) -> Array:
    """Return the logarithmic probability [nats] of each text without a sound, (N,).

    `texts`: columns of the decoder, each at least one; `begin` and `end`: those around every text; `first`: how many
    columns are written at all, None: all.
    """
    return written(decoder.begin(np.zeros((1, decoder.embeddings.shape[1]), np.float32), first), begin, end, texts)


def written(decoding: Decoding, begin: tuple[int, ...], end: int, texts: Sequence[Sequence[int]]) -> Array:
    """The same behind `begin` for what a decoding has heard, (N,)."""
    scores = decoding.prefill(begin)
    rows = list(range(len(texts)))
    nats = np.zeros(len(texts))
    for place in range(max(map(len, texts)) + 1):
        likely = scores - np.logaddexp.reduce(scores, axis=1, keepdims=True)
        following = [[*text, end][min(place, len(text))] for text in texts]
        going = np.array([place <= len(text) for text in texts])
        nats += np.where(going, likely[rows if place else 0, following], 0.0)
        scores = decoding.advance(rows if place else [0] * len(rows), following)
    return nats
