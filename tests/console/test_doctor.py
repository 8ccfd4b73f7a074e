"""What the doctor says of what is missing and of what failed."""

import json
import re
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from console.__main__ import main
from console.cli import doctor, self_test, step_profile
from core.install import install_extra, install_packages
from core.models import InstalledModel

ROOT = Path(__file__).parents[2]


def test_every_declared_package_is_looked_for() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    assert set(doctor.needed("3.11")) == {re.split(r"[<>=]", line)[0] for line in declared}
    assert {"soundfile", "pydantic", "h11", "lz4", "zstandard"} <= set(doctor.needed())


@pytest.mark.parametrize("python", ["3.12", "3.14"])
def test_where_no_recognizer_is_ready_made_nothing_is_missing_and_the_way_out_is_told(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, python: str
) -> None:
    def absent(name: str) -> str:
        raise PackageNotFoundError(name)

    assert "pocketsphinx" not in doctor.needed(python) and "pocketsphinx" in doctor.needed("3.13")
    monkeypatch.setattr(doctor, "version", absent)
    told = doctor.words(python)
    assert not told.needed and f"for Python {python}" in told.found and "3.11 or 3.13" in told.remedy
    assert "Python 3" not in doctor.words("3.11").found
    monkeypatch.setattr(doctor, "find", lambda _: None)
    assert "not what" in doctor.words(python).found and "models get" in doctor.human_voices().remedy
    monkeypatch.setattr(doctor, "find", lambda _: InstalledModel(tmp_path, ours=True))
    assert "Whisper spots STOP" in doctor.words(python).found and doctor.human_voices().good


def test_a_failed_self_test_is_not_called_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    findings = [("turn left", False, "turned 3.0°, 90° were asked"), ("gate", True, "100 rows")]
    monkeypatch.setattr(self_test, "self_test", lambda: iter(findings))
    assert main(["doctor", "--self-test"]) == 1
    told = capsys.readouterr().out
    assert re.search(r"^FAILED  turn left +turned 3.0°", told, re.M) and "MISSING" not in told
    assert told.strip().endswith(doctor.FAILED) and doctor.MISSING not in told
    assert main(["doctor", "--self-test", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["ok"] is False


def test_without_a_voice_all_is_well_and_the_remedy_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("core.speech.synthesis.can_speak", lambda: False)
    assert main(["doctor"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"^absent  voice \(espeak-ng\)", told, re.M) and f"→ {install_extra('voice')}" in told


def test_without_matplotlib_all_is_well_and_the_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def installed(name: str) -> str:
        if name == "matplotlib":
            raise PackageNotFoundError
        return "1.0"

    monkeypatch.setattr(doctor, "version", installed)
    assert main(["doctor"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"^absent  figures \(matplotlib\)", told, re.M) and f"→ {install_extra('figures')}" in told


def test_what_is_missing_comes_with_an_arrow(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "needed", lambda: ["numpy", "no-such-package"])
    assert main(["doctor"]) == 1
    told = capsys.readouterr().out
    assert "MISSING no-such-package" in told and f"→ {install_packages('no-such-package')}" in told
    assert doctor.MISSING in told and doctor.FAILED not in told and doctor.WELL not in told


def test_without_portaudio_all_is_well_and_the_library_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def absent(name: str) -> None:
        raise OSError(f"{name}: PortAudio library not found")

    monkeypatch.setattr("core.robots.usb_audio.importlib.import_module", absent)
    assert main(["doctor"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"^absent  microphones \(audio:\)", told, re.M) and "apt install libportaudio2" in told


def test_the_profile_parts_the_time_of_the_steps(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(step_profile, "SIMULATED_S", 4.0)
    assert main(["doctor", "--profile", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["steps"] == 4 * told["rate_hz"] and {"corners and edges", "scan matching", "filter"} <= set(
        told["rooms"]
    )
    assert sum(told["rooms"].values()) == pytest.approx(told["mean_ms"], rel=1e-6)
    assert told["p50_ms"] <= told["p95_ms"] <= told["p99_ms"]
    assert main(["doctor", "--profile", "nowhere.mcap"]) == 1
    assert "nowhere.mcap" in capsys.readouterr().err


def test_a_slower_processor_is_multiplied_and_said_to_be() -> None:
    one = step_profile.StepProfile(
        source="sim:lab",
        steps=100,
        rate_hz=40.0,
        mean_ms=5.0,
        p50_ms=4.0,
        p95_ms=10.0,
        p99_ms=12.0,
        rooms=(("map", 3.0), ("filter", 2.0)),
    )
    words = "\n".join(step_profile.lines_of(one))
    assert "| map | 3.00 | 60 % |" in words and "multiplied, not measured" in words
    assert "20.0 ms a step, 80 % of a core" in words and "do not fit into the 25 ms" in words
