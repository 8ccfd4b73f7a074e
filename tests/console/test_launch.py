"""The command `beckon` where another package or folder is called as one of Beckon's own."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from console import launch

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", ["console", "core"])
@pytest.mark.parametrize("form", ["package", "module", "nothing"])
def test_what_hides_a_package_of_beckon_is_named_in_one_sentence(tmp_path: Path, name: str, form: str) -> None:
    if form == "module":
        (tmp_path / f"{name}.py").write_text("")
    elif form == "package":
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("")
    path = [str(tmp_path), str(ROOT)]
    done = launched(tmp_path, path if form != "nothing" else path[:1])
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1 and "Beckon's own package" in done.stderr
    assert (str(tmp_path / name) in done.stderr) == (form != "nothing")


def test_beckons_own_packages_are_run(tmp_path: Path) -> None:
    done = launched(tmp_path, [str(ROOT)])
    assert done.returncode == 0 and done.stdout.startswith("beckon ")


def test_the_first_process_of_a_container_ends_at_a_stop_while_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(os, "getpid", lambda: 1)
    monkeypatch.setattr("console.__main__.main", lambda: signal.raise_signal(signal.SIGTERM))
    try:
        assert launch.main() == launch.INTERRUPTED_CODE
    finally:
        signal.signal(signal.SIGTERM, before)


def launched(place: Path, path: list[str]) -> subprocess.CompletedProcess[str]:
    """Run the launcher as installed, a module of its own, with this path of modules."""
    code = "import sys; sys.argv = ['beckon', '--version']; from beckon_launch import main; sys.exit(main())"
    (place / "bin").mkdir()
    (place / "bin" / "beckon_launch.py").write_text((ROOT / "console" / "launch.py").read_text())
    path = [*path, str(place / "bin")]
    own = [each for each in sys.path if each.endswith("-packages")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((*path, *own))}
    return subprocess.run(
        [sys.executable, "-S", "-c", code], capture_output=True, text=True, env=environment, cwd=place, check=False
    )
