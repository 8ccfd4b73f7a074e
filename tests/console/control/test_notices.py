"""The list of notices: one of a cause, no sentence twice, what the pilot changes changes here."""

from console.control.notices import MAX_SHOWN, Notifications
from core.pilot.notices import KEEPS_UP, SLOW, Notices


def texts(board: Notifications) -> list[str]:
    return [notice.text for notice in board.shown]


def test_a_trouble_of_the_pilot_is_one_notice_here_too_however_slow_it_is() -> None:
    pilot, board = Notices(), Notifications()
    board.tell("info", "Anna took over.")
    numbers: set[int] = set()
    for stamp, pace in enumerate((0.85, 0.48, 0.54, 0.60, 0.63, 0.68, 0.89, 1.0)):
        pilot.watch(stamp, "pace", SLOW if pace < 1 else "", "warning", KEEPS_UP)
        board.adopt(pilot.newest, stamp)
        numbers.add(board.shown[-1].id)
        assert len(board.shown) == 2
        assert ("too slow" in board.shown[-1].text) == (pace < 1)
    assert len(numbers) == 1
    assert board.shown[-1].level == "info" and "keeps up" in board.shown[-1].text


def test_a_notice_is_dated_by_the_wall_clock_and_anew_only_when_it_changes() -> None:
    pilot, now = Notices(), [1000.0]
    board = Notifications(lambda: now[0])
    board.tell("info", "Anna took over.")
    now[0] = 1001.0
    pilot.watch(5.0, "laser", "The laser is silent.", "error", "The laser is back.")
    board.adopt(pilot.newest, 5.0)
    before = board.shown
    assert [notice.at for notice in before] == [1000.0, 1001.0]
    now[0] = 1002.0
    board.adopt(pilot.newest, 6.0)
    assert board.shown is before  # what did not change is not sent again
    pilot.watch(7.0, "laser", "", "error", "The laser is back.")
    board.adopt(pilot.newest, 7.0)
    assert [notice.at for notice in board.shown] == [1000.0, 1002.0]


def test_a_trouble_that_comes_again_is_new_and_the_old_line_goes() -> None:
    pilot, board = Notices(), Notifications()
    for stamp in range(60):
        pilot.watch(stamp, "laser", "Trouble." if stamp % 3 else "", "error", "Relief.")
        pilot.watch(stamp, "camera", f"Picture {stamp}." if stamp % 5 else "", "warning", "Pictures again.")
        board.adopt(pilot.newest, stamp)
    assert sorted(texts(board)) == ["Picture 59.", "Trouble."]
    assert max(notice.id for notice in board.shown) > 10


def test_what_the_console_tells_of_one_cause_replaces_what_it_told_before() -> None:
    board = Notifications()
    for _ in range(30):
        board.tell("error", "The link is lost.", "link")
        board.tell("info", "Anna halted the robot.")
        board.tell("info", "The robot is back.", "link")
    assert texts(board) == ["Anna halted the robot.", "The robot is back."]
    for number in range(2 * MAX_SHOWN):
        board.tell("info", f"Number {number}.")
    assert texts(board) == [f"Number {number}." for number in range(MAX_SHOWN, 2 * MAX_SHOWN)]


def test_a_new_pilot_counts_from_the_beginning_and_finds_troubles_by_itself() -> None:
    board, first, second = Notifications(), Notices(), Notices()
    for text in ("one", "two", "three"):
        first.add(0.0, "info", text)
    first.watch(0.0, "laser", "Trouble.", "error", "Relief.")
    board.adopt(first.newest, 0.0)
    board.reset_pilot()
    second.add(0.0, "info", "four")
    board.adopt(second.newest, 0.0)
    assert texts(board) == ["one", "two", "three", "four"]


def test_faults_of_two_causes_are_two_notices_and_one_that_lasts_stays_one() -> None:
    pilot, board = Notices(), Notifications()
    numbers: set[tuple[int, ...]] = set()
    for step in range(1, 9):
        stamp = 5.0 * step
        pilot.add(stamp, "warning", f"Scans are {step} s late.", "scan.late laser")
        pilot.add(stamp, "warning", "The base was restarted.", "odometry.restarted base")
        pilot.add(stamp, "info", "The laser was lost; it is looked for.")
        board.adopt(pilot.newest, stamp)
        numbers.add(tuple(notice.id for notice in board.shown))
        assert [notice.stamp for notice in board.shown] == [stamp] * 3
    assert len(numbers) == 1
    assert texts(board)[:2] == ["Scans are 8 s late.", "The base was restarted."]
    pilot.add(90.0, "warning", "Scans are 9 s late.", "scan.late laser")
    board.adopt(pilot.newest, 90.0)
    assert board.shown[-1].text == "Scans are 9 s late." and len(board.shown) == 3


def test_what_was_lost_twice_is_said_twice() -> None:
    pilot = Notices()
    for stamp, text in enumerate(("It was lost.", "It is back.", "It was lost.")):
        pilot.add(float(stamp), "info", text)
    assert [notice.text for notice in pilot.newest] == ["It was lost.", "It is back.", "It was lost."]
