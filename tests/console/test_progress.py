"""The progress of a command: nothing at first, a bar on a terminal, a line now and then elsewhere."""

import io
import re

import pytest

from console.cli.answer import ShownProgress
from core.progress import UNSEEN, WorkProgress


class Screen(io.StringIO):
    """Standard error, as a terminal or not."""

    def __init__(self, terminal: bool) -> None:
        super().__init__()
        self._terminal = terminal

    def isatty(self) -> bool:
        return self._terminal


class Work:
    """Steps of work that each take a second."""

    def __init__(self, terminal: bool) -> None:
        self.now, self.screen = 100.0, Screen(terminal)
        self.progress = ShownProgress(self.screen, clock=lambda: self.now)

    def do(self, steps: int, seconds: float = 1.0) -> str:
        for _ in self.progress.each(range(steps), "counting"):
            self.now += seconds
        return self.screen.getvalue()


@pytest.mark.parametrize("terminal", [True, False])
def test_short_work_shows_nothing(terminal: bool) -> None:
    assert Work(terminal).do(10, 0.19) == ""


def test_on_a_terminal_one_line_shows_the_share_and_the_time_to_go() -> None:
    shown = Work(terminal=True).do(100)
    assert "\n" not in shown
    states = shown.split("\r\x1b[K")[1:]
    assert states[0].startswith("[") and "2% 1:38 to go counting" in states[0]
    assert "[##########..........]  50% 0:50 to go counting" in states
    assert "100% 0:00 to go" in states[-1]
    assert all(len(one) < 80 for one in states)


def test_elsewhere_there_is_a_line_for_every_tenth_and_no_two_within_two_seconds() -> None:
    lines = Work(terminal=False).do(100).splitlines()
    assert lines[1:10] == [f"{share}%, {_words(100 - share)} to go, counting" for share in range(10, 100, 10)]
    assert len(lines) <= 12 and "\r" not in "".join(lines)
    quick = Work(terminal=False).do(1000, 0.01).splitlines()
    assert 1 <= len(quick) <= 5


def test_work_that_is_slow_within_a_tenth_still_shows_a_sign_of_life() -> None:
    lines = Work(terminal=False).do(100, 9.0).splitlines()
    assert len(lines) >= 40


def test_the_parts_of_work_make_one_progress() -> None:
    shares: list[float] = []

    class Kept(WorkProgress):
        def at(self, share: float, doing: str = "") -> None:
            shares.append(share)

    whole = Kept()
    for number in range(2):
        assert list(whole.part(number, 2).each("ab", "letters")) == ["a", "b"]
    assert shares == [0.0, 0.25, 0.5, 0.5, 0.75, 1.0]
    assert list(UNSEEN.each([], "nothing")) == []


def test_words_stand_on_the_same_line_on_a_terminal_and_are_cut_to_its_width() -> None:
    work = Work(terminal=True)
    work.progress("x" * 500)
    assert re.fullmatch(r"\r\x1b\[Kx{20,499}", work.screen.getvalue())


def _words(seconds: int) -> str:
    return f"{seconds // 60}:{seconds % 60:02}"
