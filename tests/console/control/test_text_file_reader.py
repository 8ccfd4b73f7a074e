"""The paper's text files: read whole, obeyed once, emptied after."""

import asyncio
import math
import os
import time
from pathlib import Path
from typing import Any

import pytest

from console.control.command_freshness import Spoken
from console.control.text_file_commands import WRITER, TextFileCommands
from console.control.text_files import MAX_SENTENCE_BYTES, SOURCE, SPEECH, TextFileReader
from core.errors import BadInput
from tests.console.live import Live


def write(folder: Path, words: str | bytes, age: float = 0.0, now: float = 1000.0) -> Path:
    """Words written `age` seconds before `now`."""
    file = folder / SPEECH
    file.write_bytes(words if isinstance(words, bytes) else words.encode())
    os.utime(file, (now - age, now - age))
    return file


def test_words_are_taken_when_they_stand_still_once_and_the_file_is_empty_then(tmp_path: Path) -> None:
    files = TextFileReader(tmp_path)
    assert files.look(1000.0) is None
    speech = write(tmp_path, "turn ")
    assert files.look(1000.0) is None
    write(tmp_path, "turn left\r\n")
    assert files.look(1000.0) is None
    told = files.look(1000.1)
    assert told is not None and (told.words, told.trouble) == ("turn left", "")
    assert speech.read_bytes() == b""
    assert files.look(1000.2) is None
    assert files.look(1000.3) is None


def test_the_same_words_said_again_are_obeyed_again(tmp_path: Path) -> None:
    files = TextFileReader(tmp_path)
    for now in (1000.0, 1001.0):
        write(tmp_path, "turn left", now=now)
        assert files.look(now) is None
        told = files.look(now + 0.1)
        assert told is not None and told.words == "turn left"


def test_a_file_that_was_renamed_into_place_is_read_like_any_other(tmp_path: Path) -> None:
    files = TextFileReader(tmp_path)
    (tmp_path / "new").write_text("stop moving")
    os.utime(tmp_path / "new", (1000.0, 1000.0))
    (tmp_path / "new").rename(tmp_path / SPEECH)
    assert files.look(1000.0) is None
    told = files.look(1000.1)
    assert told is not None and told.words == "stop moving"


def reading(live: Live, folder: Path) -> TextFileCommands:
    runtime = live.runtime
    parts = (runtime.dispatcher, runtime.lease, runtime.history, runtime.notifications)
    return TextFileCommands(TextFileReader(folder), *parts, lambda: runtime.snapshot)


@pytest.mark.parametrize(
    ("content", "age", "sentence"),
    [
        ("turn left", 5.0, "not of now"),
        ("turn left", -60.0, "not of now"),
        (b"\xff\xfe\x00turn", 0.0, "no text"),
        ("x" * (MAX_SENTENCE_BYTES + 1), 0.0, "longer than a sentence"),
    ],
)
def test_what_nobody_should_obey_is_told_and_emptied(
    tmp_path: Path, content: str | bytes, age: float, sentence: str
) -> None:
    files = TextFileReader(tmp_path)
    speech = write(tmp_path, content, age)
    files.look(1000.0)
    told = files.look(1000.1)
    assert told is not None and sentence in told.trouble
    assert speech.read_bytes() == b""


def test_a_link_is_not_followed_and_that_is_told_once(tmp_path: Path) -> None:
    secret = tmp_path / "secret"
    secret.write_text("turn left")
    (tmp_path / SPEECH).symlink_to(secret)
    files = TextFileReader(tmp_path)
    told = [files.look(1000.0 + k) for k in range(3)]
    assert told[0] is not None and "cannot be opened" in told[0].trouble
    assert told[1:] == [None, None]
    assert secret.read_text() == "turn left"


def test_a_folder_or_pipe_of_that_name_blocks_nothing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / SPEECH)
    files = TextFileReader(tmp_path)
    assert [files.look(1000.0 + k) for k in range(3)] == [None, None, None]


@pytest.mark.parametrize(("text", "azimuth", "sd"), [("30", 30, 10), ("-45.5 4\n", -45.5, 4), ("350, 2", -10, 2)])
def test_a_direction_is_read_in_degrees(tmp_path: Path, text: str, azimuth: float, sd: float) -> None:
    (tmp_path / SOURCE).write_text(text)
    told = TextFileReader(tmp_path).source(time.time())
    assert (math.degrees(told.azimuth), math.degrees(told.sd)) == pytest.approx((azimuth, sd))


@pytest.mark.parametrize("text", ["", "left", "nan", "1 2 3", "10 -2", "10 0", "10 90", "1e9", "\x00"])
def test_what_is_no_direction_is_told(tmp_path: Path, text: str) -> None:
    (tmp_path / SOURCE).write_text(text)
    with pytest.raises(BadInput, match="one direction in degrees"):
        TextFileReader(tmp_path).source(time.time())


@pytest.mark.parametrize("age", [3.0, 3600.0, -60.0])
def test_a_direction_of_another_time_is_refused_with_its_age(tmp_path: Path, age: float) -> None:
    (tmp_path / SOURCE).write_text("90")
    os.utime(tmp_path / SOURCE, (1000.0 - age, 1000.0 - age))
    with pytest.raises(BadInput, match=rf"source\.txt is not of now, its date is {abs(age):.0f} s off"):
        TextFileReader(tmp_path).source(1000.0)


def test_a_pipe_of_that_name_blocks_nothing_and_is_no_direction(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / SOURCE)
    writer = os.open(tmp_path / SOURCE, os.O_RDWR)  # one that says nothing
    for _ in range(2):
        with pytest.raises(BadInput, match="no plain file"):
            TextFileReader(tmp_path).source(time.time())
        os.write(writer, b"90")
    os.close(writer)


def test_a_file_of_another_name_is_not_emptied_through_a_hard_link(tmp_path: Path) -> None:
    files, other = TextFileReader(tmp_path), tmp_path / "letter.txt"
    other.write_text("come here")
    (tmp_path / SPEECH).hardlink_to(other)
    told = [files.look(1000.0 + 0.1 * number) for number in range(4)]
    assert [one.words for one in told if one is not None] == [""] and other.read_text() == "come here"


def test_words_and_directions_come_with_their_age(tmp_path: Path) -> None:
    files = TextFileReader(tmp_path)
    write(tmp_path, "turn left", age=1.5)
    files.look(1000.0)
    told = files.look(1000.1)
    assert told is not None and told.age == pytest.approx(1.6)
    (tmp_path / SOURCE).write_text("90")
    os.utime(tmp_path / SOURCE, (998.5, 998.5))
    assert files.source(1000.0).age == pytest.approx(1.5)


def test_a_writer_lives_while_the_file_changes_by_another_hand(tmp_path: Path) -> None:
    files = TextFileReader(tmp_path)
    speech = write(tmp_path, "follow wall")
    lives = []
    for now in (1000.0, 1000.1, 1000.2, 1000.3):  # with the second look it is emptied: that is no sign of the writer
        files.look(now)
        lives.append(files.writer_lives)
    assert lives == [True, False, False, False]
    os.utime(speech, (1001.0, 1001.0))
    lives = []
    for now in (1001.0, 1001.1):
        files.look(now)
        lives.append(files.writer_lives)
    assert lives == [True, False]
    speech.unlink()
    assert files.look(1002.0) is None and not files.writer_lives


def test_a_file_that_is_touched_renews_its_writers_lease(live: Live, tmp_path: Path) -> None:
    orders, lease = reading(live, tmp_path), live.runtime.lease
    live.on_loop(lambda: lease.take(WRITER, time.monotonic() - 4.0))
    task = asyncio.run_coroutine_threadsafe(orders.run(), live.loop)
    try:
        (tmp_path / SPEECH).touch()
        live.until(lambda: time.monotonic() - lease._seen < 2.0, 3.0)
    finally:
        task.cancel()


def test_a_missing_direction_or_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"source\.txt cannot be read"):
        TextFileReader(tmp_path).source(time.time())
    with pytest.raises(BadInput, match="no such folder"):
        TextFileReader(tmp_path / "nowhere")


def test_words_in_the_file_move_the_robot_and_unmatched_ones_are_deleted_with_a_notice(
    live: Live, tmp_path: Path
) -> None:
    runtime = live.runtime
    orders = reading(live, tmp_path)
    task = asyncio.run_coroutine_threadsafe(orders.run(), live.loop)

    def history() -> list[dict[str, Any]]:
        return live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"]

    before = {row["id"] for row in history()}

    def newest(words: str) -> dict[str, Any] | None:
        rows = [row for row in history()[:1] if row["id"] not in before]
        return next((row for row in rows if row["words"] == words and row["source"] == "file"), None)

    try:
        (tmp_path / SPEECH).write_text("turn left")
        told = live.until(lambda: newest("turn left"))
        assert told["state"] in ("running", "done")
        assert (tmp_path / SPEECH).read_text() == ""
        (tmp_path / SPEECH).write_text("stop moving")
        live.until(lambda: newest("stop moving"))
        (tmp_path / SPEECH).write_text("dance with me")
        told = live.until(lambda: newest("dance with me"))
        assert told["state"] == "refused"
        assert (tmp_path / SPEECH).read_text() == ""
        live.until(lambda: any("From the text file" in one.text for one in runtime.notifications.shown))
    finally:
        task.cancel()


def test_come_here_wants_to_be_told_from_where(live: Live, tmp_path: Path) -> None:
    orders = reading(live, tmp_path)
    asyncio.run_coroutine_threadsafe(orders.order("come here", Spoken.now()), live.loop).result(10)
    told = live.ask("GET", "/api/commands/history", token=live.viewer).json["commands"][0]
    assert told["state"] == "refused"
    assert "source.txt cannot be read" in told["remark"]
