"""Stored calibration sessions: one folder each, with the session, its pictures and its exports."""

from __future__ import annotations

import contextlib
import logging
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import msgspec
import numpy as np

from console.messages.calibration import CalibrationBoard, CalibrationKind, CalibrationSessionState, CalibrationSource
from core.calibration.mount import Mount
from core.errors import BadInput
from core.files import write_atomic
from core.geometry import Transform
from core.optics import CameraModel

log = logging.getLogger(__name__)

FORM_VERSION = 1
MOST_BYTES = 2**27  # of one session's file
NAME = "session.json"
NO_STATE = msgspec.Raw(b"null")


class StoredMount(msgspec.Struct, frozen=True):
    """Prior knowledge of a mount: laser_from_camera, and its standard deviations."""

    rotation: list[list[float]]
    translation_m: list[float]
    spread: list[float]  # [rad, m]

    @classmethod
    def of(cls, mount: Mount) -> StoredMount:
        nominal = mount.nominal
        return cls(nominal.rotation.tolist(), nominal.translation.tolist(), [float(sd) for sd in mount.spread])

    @property
    def mount(self) -> Mount:
        nominal = Transform(rotation=np.array(self.rotation), translation=np.array(self.translation_m))
        return Mount(nominal=nominal, spread=tuple(self.spread))


class SessionInfo(msgspec.Struct):
    """A session's facts, which stay from its beginning to its end."""

    id: str
    kind: CalibrationKind
    source: CalibrationSource
    board: CalibrationBoard
    created_s: float
    camera: CameraModel | None = None  # laser: the camera in use when it began
    mount: StoredMount | None = None  # laser


class StoredSession(msgspec.Struct):
    version: int
    card: SessionInfo
    shown: CalibrationSessionState
    state: msgspec.Raw = NO_STATE  # JSON of the core's session, which its workers alone read
    pictures: dict[str, str] = msgspec.field(default_factory=dict[str, str])  # view → file
    exports: dict[str, tuple[str, str]] = msgspec.field(default_factory=dict[str, tuple[str, str]])


class SessionStore:
    """One session on disk. Its methods wait for the disk: call them from a thread."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def save(self, raw: bytes) -> None:
        """Replace the session's file, whole or not at all."""
        write_atomic(self.path / NAME, raw)

    def save_picture(self, number: int, picture: bytes, small: bytes) -> str:
        """A view's picture and its thumbnail → the file's name."""
        kind = "png" if picture.startswith(b"\x89PNG") else "jpg"
        name = f"view_{number:04d}.{kind}"
        write_atomic(self.path / name, picture)
        write_atomic(self.path / small_name(name), small)
        return name

    def read(self, name: str) -> bytes:
        """A file of this session. Raises OSError."""
        return (self.path / name).read_bytes()

    def packed(self, exports: dict[str, tuple[str, str]], pictures: dict[str, str]) -> IO[bytes]:
        """Everything needed to solve again, as a zip at its beginning; its file is gone when it is closed.

        It lies on this session's disk, not in memory. Raises OSError.
        """
        with contextlib.ExitStack() as held:
            packed: IO[bytes] = held.enter_context(tempfile.TemporaryFile(dir=self.path))
            with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as box:
                box.write(self.path / NAME, NAME)
                for name, text in exports.values():
                    box.writestr(name, text)
                for name in pictures.values():
                    if (self.path / name).is_file():
                        box.write(self.path / name, f"views/{name}", zipfile.ZIP_STORED)
            packed.seek(0)
            held.pop_all()
        return packed

    def remove(self) -> None:
        shutil.rmtree(self.path, ignore_errors=True)


def small_name(name: str) -> str:
    return name.partition(".")[0] + "_small.jpg"


def kept_sessions(base: Path) -> Iterator[StoredSession]:
    """All sessions that can be read, in no order; the others stay where they are, untouched."""
    for path in base.glob(f"*/{NAME}"):
        try:
            if path.stat().st_size > MOST_BYTES:
                raise ValueError("too large")
            kept = msgspec.json.decode(path.read_bytes(), type=StoredSession)
            if kept.version != FORM_VERSION or kept.card.id != path.parent.name:
                raise ValueError("of another version, or in another's folder")
        except (OSError, ValueError, msgspec.MsgspecError, BadInput) as trouble:
            log.warning("A calibration session cannot be read: %s: %s", path, trouble)
            continue
        yield kept
