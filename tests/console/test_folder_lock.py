"""One console per data folder."""

import subprocess
import sys
from pathlib import Path

import pytest

from console.data_folder import NAME, locked
from core.errors import Unavailable

HOLD = """
import sys, time
from pathlib import Path
from console.data_folder import locked
with locked(Path(sys.argv[1])):
    sys.stdout.write("held\\n")
    sys.stdout.flush()
    time.sleep(60)
"""


def test_it_is_held_by_one_and_free_again_when_that_one_is_killed(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], cwd=Path(__file__).parents[2], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(Unavailable, match=rf"process {holder.pid}\).*--data"), locked(tmp_path):
        pass
    holder.kill()
    holder.wait()
    holder.stdout.close()
    assert (tmp_path / NAME).exists()
    for _ in range(2):
        with locked(tmp_path):
            pass


@pytest.mark.parametrize("left", ["", "{", "[]", "null", '{"pid": "x", "port": []}', "\x00" * 500], ids=repr)
def test_whatever_stands_in_the_file_the_sentence_is_one(tmp_path: Path, left: str) -> None:
    with locked(tmp_path):
        (tmp_path / NAME).write_text(left)
        with pytest.raises(Unavailable, match=r"^Another console uses the data folder"), locked(tmp_path):
            pass


def test_a_folder_that_cannot_be_written_is_refused_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(Unavailable, match=r"Nothing can be kept .*--data"), locked(tmp_path / "file" / "home"):
        pass
