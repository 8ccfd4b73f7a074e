"""Sound that is read at once."""

from core.speech.settings import PIECE_S, VOICE_PIECE_S
from core.speech.transcription.piece_length import AFTER_VOICE_S, PieceLength


def at(length: PieceLength, now: float, speaking: bool) -> float:
    """The length [s] from `now` on."""
    length.follow(now, speaking)
    return length.seconds


def test_little_sound_waits_while_someone_speaks_and_until_their_sentence_may_be_read():
    length = PieceLength()
    assert length.seconds == at(length, 10.0, False) == PIECE_S
    assert at(length, 10.1, True) == VOICE_PIECE_S
    assert at(length, 10.1 + AFTER_VOICE_S, False) == VOICE_PIECE_S
    assert at(length, 10.2 + AFTER_VOICE_S, False) == PIECE_S


def test_a_robot_that_was_started_again_has_another_clock():
    length = PieceLength()
    length.follow(10.0, True)
    assert at(length, 0.1, False) == PIECE_S
    assert at(length, 0.2, True) == VOICE_PIECE_S
