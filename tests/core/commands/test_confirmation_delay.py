"""Commands that wait before they start, and how long."""

import pytest

from core.commands import needs_confirmation
from core.commands.command import Command
from core.commands.confirmation_delay import (
    CONFIRMATION_DELAY_S,
    MAX_POSTPONED_S,
    RECOGNITION_TIME_S,
    ConfirmationDelay,
)
from core.speech.understanding.grammar import understand


@pytest.mark.parametrize(
    ("words", "waits"),
    [
        ("continue 2 meters", False),
        ("continue 2.1 meters", True),
        ("turn left", False),
        ("stop moving", False),
        ("follow wall", False),
        ("stop at 0.2 and 0", True),
        ("come here", True),
        ("follow me", True),
    ],
)
def test_what_goes_far_or_to_a_place_or_a_person_waits(words: str, waits: bool) -> None:
    command = understand(words)
    assert isinstance(command, Command)
    assert needs_confirmation(command) == waits


def test_a_command_is_postponed_while_a_person_speaks_but_not_for_ever() -> None:
    moment = ConfirmationDelay.from_now(10.0)
    assert moment.begins == 10.0 + CONFIRMATION_DELAY_S
    early = moment.while_speaking(10.1)
    assert early == moment
    late = moment.while_speaking(11.5)
    assert late.begins == 11.5 + RECOGNITION_TIME_S and late.latest == moment.latest
    for k in range(100):
        late = late.while_speaking(11.5 + 0.1 * k)
    assert late.begins == 10.0 + CONFIRMATION_DELAY_S + MAX_POSTPONED_S
