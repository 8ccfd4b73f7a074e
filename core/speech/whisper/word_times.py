"""When words were said in an utterance: where the decoder looks in the sound while it writes them.

This separates them from another talker in the same utterance. The frames of a text are a chain through the attention
of its tokens in which every token follows the one before soon. Another talker who was there first attracts the first
token, so that more chains are sought, each behind the one before; the sound of each has to be read to choose.
"""

from collections.abc import Iterator

import numpy as np

from core.message import Array

FRAME_S = 0.02  # [s]
MAX_TOKEN_GAP_S = 0.5  # between two tokens of a sentence, at most
FIRST_TOKEN_DELAY_S = 0.4  # from the begin of words to the frame of their first token, at most
LAST_TOKEN_LENGTH_S = 0.2  # from the frame of their last token to their end
MIN_ATTENTION = 1e-6  # below which there is none


def spans_of(attention: Array) -> Iterator[tuple[float, float]]:
    """Attention (W, T) of the tokens of words → from when to when [s] they may have been said, likeliest first."""
    since = 0
    while len(attention) and attention.shape[1] > since + len(attention):
        frames = _chain(np.log(attention[:, since:] + MIN_ATTENTION))
        first, last = since + frames[0], since + frames[-1]
        yield first * FRAME_S - FIRST_TOKEN_DELAY_S, last * FRAME_S + LAST_TOKEN_LENGTH_S
        since = last + round(LAST_TOKEN_LENGTH_S / FRAME_S)


def _chain(likely: Array) -> list[int]:
    """Logarithms of attention (W, T) → the frame of each token: the chain of the greatest sum."""
    reach = round(MAX_TOKEN_GAP_S / FRAME_S) + 1
    best, came = likely[0], list[Array]()
    for row in likely[1:]:
        padded = np.concatenate((np.full(reach - 1, -np.inf), best))
        windows = np.lib.stride_tricks.sliding_window_view(padded, reach)  # (T, reach): every frame and those before
        from_which = windows.argmax(axis=1)
        came.append(from_which + np.arange(len(best)) - reach + 1)
        best = windows.max(axis=1) + row
    frames = [int(best.argmax())]
    for back in reversed(came):
        frames.append(int(back[frames[-1]]))
    return frames[::-1]
