"""A console that is killed loses no more of its map than the last minute."""

import signal
import subprocess
import sys
import time
from pathlib import Path

from console.maps.export import FLOOR
from console.maps.service import LAST_MAP
from console.maps.store import MapStore
from core.slam.map.map_file import SavedMap

ROOT = Path(__file__).resolve().parents[3]
START_S = 60.0  # on a busy machine


def names(home: Path) -> list[str]:
    return [kept.card.name for kept in MapStore(home / "maps").all()]


def test_a_killed_console_has_kept_its_map(tmp_path: Path) -> None:
    with (tmp_path / "said.txt").open("w") as said:
        command = [sys.executable, "-m", "tests.console.maps.driving_console", str(tmp_path)]
        console = subprocess.Popen(command, cwd=ROOT, stdout=said, stderr=subprocess.STDOUT)
    try:
        until = time.monotonic() + START_S
        while names(tmp_path) != [LAST_MAP]:
            assert console.poll() is None and time.monotonic() < until, (tmp_path / "said.txt").read_text()
            time.sleep(0.05)
    finally:
        console.send_signal(signal.SIGKILL)
        console.wait()
    store = MapStore(tmp_path / "maps")
    store.clean()
    kept = store.find(LAST_MAP)
    assert kept is not None and kept.card.by == "Beckon" and kept.card.width_m > 3.0
    assert SavedMap.from_files(store.checked(kept) / FLOOR).submaps
