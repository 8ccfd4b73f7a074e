"""Storage of the microphones' accepted orientation: one file, sealed by a checksum."""

from __future__ import annotations

import json
import math
from pathlib import Path

import msgspec

from core.calibration.files.camera_files import read_json
from core.errors import BadInput
from core.files import SEAL, is_intact, sealed, sync_folder, write_atomic
from core.perception.sound.array_orientation import Orientation


class AcceptedOrientation(msgspec.Struct, frozen=True):
    """The file of an orientation; one that someone wrote by hand may do without the lower half."""

    yaw: float  # [rad] robot_from_microphones
    yaw_sd: float  # [rad]
    mirrored: bool  # the array is mounted upside down
    residual: float  # [rad] rms
    claps: int | None = None
    accepted_s: float | None = None
    who: str | None = None

    @property
    def orientation(self) -> Orientation:
        """As the array takes it."""
        return Orientation(yaw=self.yaw, yaw_sd=self.yaw_sd, mirrored=self.mirrored, residual=self.residual)


def read_orientation(path: Path) -> tuple[AcceptedOrientation | None, bool]:
    """Return the orientation in the file, or None without a file, and whether it has its checksum.

    Raises BadInput if it cannot be used.
    """
    try:
        document = read_json(path.read_text(encoding="utf-8"))
        found = msgspec.convert(document, AcceptedOrientation)
        why = ""
        if not all(abs(number) <= math.tau for number in (found.yaw, found.yaw_sd, found.residual)):
            why = "its numbers cannot be"
        if is_intact(document) is False:
            why = f"it was changed after it was saved (if you changed it yourself, remove its “{SEAL}”)"
        if not why:
            return found, SEAL in document
    except FileNotFoundError:
        return None, False
    except (OSError, ValueError, BadInput, msgspec.ValidationError) as trouble:
        why = trouble.strerror if isinstance(trouble, OSError) else "it is damaged"
    raise BadInput(f"The microphones' orientation in {path.name} cannot be used: {why}. Measure it again.")


def write_orientation(path: Path, found: AcceptedOrientation | None) -> None:
    """Put the orientation into the file, whole or not at all; None removes it. Raises OSError."""
    if found is None:
        path.unlink(missing_ok=True)
        if path.parent.is_dir():
            sync_folder(path.parent)
        return
    write_atomic(path, json.dumps(sealed(msgspec.structs.asdict(found))))
