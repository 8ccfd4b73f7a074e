"""The calibrations in use: `camera.json` and `mount.json`, each with its former versions next to it.

Each has the form of `core.calibration.reports.kept`, and besides that who accepted it, when, the name of the former
and a checksum. A file that was written by hand may lack them, and counts as not verified. Nothing that was accepted
is ever deleted: when another calibration is accepted, the former one stays beside it under a name with the date, and
undoing takes it back. The file in use is whole at every moment, also when the power fails or the disk is full.

A calibration that was accepted is used at once, and after every later start: `apply.calibrated` puts the camera's
model and the mount into the robot's profile, from which perception takes both.
"""

import json
import logging
import os
import time
from contextlib import suppress
from pathlib import Path
from threading import Lock

import numpy as np
import scipy

from console.calibration.answers import Document
from console.http.problems import Problem
from console.messages.calibration import CalibrationKind
from core.calibration.files.camera_files import CAMERA_NAME, parse_camera, read_json
from core.calibration.files.mount_files import read_mount
from core.calibration.reports import camera_numbers
from core.errors import BadInput, BeckonError
from core.files import SEAL, is_intact, replacing, saving, sealed, sync_folder, write_atomic
from core.geometry import OPTICAL, Transform
from core.optics import CameraModel
from core.sensors.camera import lens_faults

log = logging.getLogger(__name__)

NAMES: dict[CalibrationKind, str] = {"camera": "camera", "laser": "mount"}
MOST_BYTES = 2**22
COMPARED = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")


class CalibrationStore:
    """The calibrations in use, in memory and on disk. Only `open`, `put` and `undo` wait for the disk."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._documents: dict[CalibrationKind, Document] = {}
        self._turn = Lock()
        self.troubles: list[str] = []  # of files that cannot be used, or were written by hand and hardly can be
        self.left_out: dict[CalibrationKind, str] = {}  # why one that was accepted is not used in this run
        self._formers: set[CalibrationKind] = set()  # kinds of which a former one can be taken back

    def open(self) -> None:
        """Read the files; a file that cannot be used stays where it is, `troubles` has the reason."""
        for kind, name in NAMES.items():
            path = self._folder / f"{name}.json"
            try:
                if path.is_file():
                    document = self._documents[kind] = read(path, kind)
                    if "accepted" not in document:
                        self.troubles += _doubts(document)
            except (OSError, BeckonError) as wrong:
                why = str(wrong).rstrip(".")
                self.troubles.append(f"The calibration in {path.name} cannot be used: {why}. Calibrate again.")
                log.warning(self.troubles[-1])
            self._look_for_former(kind)

    @property
    def camera(self) -> CameraModel | None:
        document = self._documents.get("camera")
        return None if document is None else model_in(document)

    @property
    def mount(self) -> Transform | None:
        """The mount in use, laser_from_camera."""
        document = self._documents.get("laser")
        return None if document is None else read_mount(document["extrinsics"])

    @property
    def mount_camera(self) -> CameraModel | None:
        """The camera through which the mount in use was found."""
        document = self._documents.get("laser")
        return None if document is None else model_in(document)

    def report(self, kind: CalibrationKind) -> Document | None:
        document = self._documents.get(kind)
        if document is None:
            return None
        accepted = document.get("accepted") or {}
        report = accepted.get("report") or plain_report(document, kind)
        acceptance = {"accepted_s": accepted.get("when_s"), "accepted_by": accepted.get("who")}
        return {**report, **acceptance, "verified": SEAL in document, "former": kind in self._formers}

    def put(self, kind: CalibrationKind, document: Document, report: Document, who: str) -> None:
        """Use it from now on. Raises BadInput for a document that does not hold together, Unwritable."""
        path = self._folder / f"{NAMES[kind]}.json"
        with self._turn:
            aside = aside_of(path)
            former = aside.name if path.is_file() else None
            accepted = {"when_s": time.time(), "who": who, "report": report, "former": former}
            whole = sealed({**document, "accepted": accepted})
            checked(whole, kind)
            with saving("The calibration could not be saved"), replacing(path, lambda: keep(path, aside)) as file:
                file.write(json.dumps(whole, indent=1).encode())
            self._documents[kind] = whole
            self.left_out.pop(kind, None)
            self._look_for_former(kind)

    def undo(self, kind: CalibrationKind) -> None:
        """Take the former back; the present one is kept aside.

        Raises Problem 409 when there is nothing to undo, Unwritable when the disk does not take part; nothing has
        changed then.
        """
        with self._turn:
            if kind not in self._documents:
                raise Problem(409, "There is no calibration in use that could be taken back.")
            path = self._folder / f"{NAMES[kind]}.json"
            with saving("The calibration could not be taken back"):
                former = self._former(kind)
                keep(path, aside_of(path, "taken-back-"))
                if former is None:
                    path.unlink(missing_ok=True)
                else:
                    former[0].replace(path)
                sync_folder(self._folder)
            if former is None:
                del self._documents[kind]
            else:
                self._documents[kind] = former[1]
            self.left_out.pop(kind, None)
            self._look_for_former(kind)

    def _look_for_former(self, kind: CalibrationKind) -> None:
        self._formers.discard(kind)
        with suppress(OSError):
            if self._former(kind) is not None:
                self._formers.add(kind)

    def _former(self, kind: CalibrationKind) -> tuple[Path, Document] | None:
        """The former that can be used: the one in use names it, else the newest by its date.

        A damaged one is passed over and stays. Raises OSError.
        """
        named = (self._documents.get(kind, {}).get("accepted") or {}).get("former")
        formers = self._folder.glob(f"{NAMES[kind]}-[0-9]*.json")
        for path in sorted(formers, key=lambda former: (former.name == named, former.stem), reverse=True):
            try:
                return path, read(path, kind)
            except BeckonError as wrong:
                log.warning("The former calibration in %s cannot be used: %s", path.name, wrong)
        return None

    def compare(self, kind: CalibrationKind, report: Document) -> dict[str, tuple[float, float]] | None:
        mine = self.report(kind)
        if mine is None:
            return None
        now, used = (numbers_of(kind, document) for document in (report, mine))
        return {name: (value, used[name]) for name, value in now.items() if name in used}


def aside_of(path: Path, why: str = "") -> Path:
    """A free second name for the file, with the date."""
    stamp = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime())
    name = f"{path.stem}-{why}{stamp}"
    free = (path.with_name(f"{name}{f'-{number:03d}' if number else ''}.json") for number in range(1000))
    return next(each for each in free if not each.exists())


def keep(path: Path, aside: Path) -> None:
    """The file, if any, under a second name, which stays when the first is given to another. Raises OSError."""
    if not path.is_file():
        return
    try:
        os.link(path, aside)
    except OSError:  # no links on this disk
        write_atomic(aside, path.read_bytes())


def read(path: Path, kind: CalibrationKind) -> Document:
    """A file → the document, whole and sound. Raises BadInput, OSError."""
    if path.stat().st_size > MOST_BYTES:
        raise BadInput("It is too large.")
    document = read_json(path.read_text(encoding="utf-8", errors="replace"))
    if is_intact(document) is False:
        raise BadInput(f"It was changed after it was saved. If you changed it yourself, remove its “{SEAL}”.")
    checked(document, kind)
    return document


def checked(document: Document, kind: CalibrationKind) -> None:
    """Raises BadInput for a document that nothing could use."""
    model_in(document)
    if kind == "laser":
        if not isinstance(document.get("extrinsics"), dict):
            raise BadInput("It holds no mount.")
        read_mount(document["extrinsics"])


def model_in(document: Document) -> CameraModel:
    """The camera in a document. Raises BadInput."""
    return parse_camera(json.dumps(document))


def _doubts(document: Document) -> list[str]:
    return [one.statement for one in lens_faults(CAMERA_NAME, model_in(document))]


def plain_report(document: Document, kind: CalibrationKind) -> Document:
    """Return the report of a document in which nobody wrote one: its numbers."""
    if kind == "camera":
        return {**camera_numbers(model_in(document)), "warnings": _doubts(document)}
    mount = read_mount(document["extrinsics"])
    return {"rotation": mount.rotation.tolist(), "translation_m": mount.translation.tolist()}


def numbers_of(kind: CalibrationKind, report: Document) -> dict[str, float]:
    """The numbers of a report that two calibrations are compared by."""
    if kind == "camera":
        return {name: report[name] for name in COMPARED if name in report}
    turns = scipy.spatial.transform.Rotation.from_matrix(np.array(report["rotation"]) @ OPTICAL.T).as_euler(
        "xyz", degrees=True
    )
    names = ("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg")
    return dict(zip(names, [*report["translation_m"], *turns.tolist()], strict=True))
