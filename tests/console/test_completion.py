"""`beckon completion`: scripts that shells accept and that complete what the command line knows."""

import shutil
import subprocess
from pathlib import Path

import pytest

from console.__main__ import main
from console.cli.completion import SHELLS, script

ASK = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
$(complete -p beckon | sed 's/.*-F \\([^ ]*\\).*/\\1/') 2>/dev/null
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def bash_script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("completion") / "beckon.bash"
    path.write_text(script("bash"))
    return path


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash here")
@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (["se"], {"settings"}),
        (["calibrate", "c"], {"camera"}),
        (["experiment", "dead"], {"dead-reckoning-vs-slam"}),
        (["run", "--rob"], {"--robot"}),
        (["slam", "walk.log", "--ids", ""], {"given", "hidden"}),
        (["slam", "w"], {"walk.log"}),
        (["correct", "--camera", "w"], {"walk.log"}),
        (["correct", "--out", ""], {"maps"}),
        (["completion", "z"], {"zsh"}),
    ],
)
def test_bash_completes_subcommands_options_values_files_and_folders(
    bash_script: Path, tmp_path: Path, words: list[str], offered: set[str]
) -> None:
    (tmp_path / "walk.log").write_text("")
    (tmp_path / "maps").mkdir()
    asked = ["bash", "-c", ASK, "bash", str(bash_script), "beckon", *words]
    answer = subprocess.run(asked, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=True)
    assert set(answer.stdout.split()) == offered


@pytest.mark.parametrize("shell", SHELLS)
def test_every_shells_script_is_printed_and_knows_every_subcommand(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["completion", shell]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in ("speech-quality", "dead-reckoning-vs-slam", "completion"))
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=printed, text=True, timeout=300, check=True)


def test_an_unknown_shell_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "fish"]) == 2
    assert "bash" in capsys.readouterr().err
