"""Straighten pictures from files: what `beckon correct` does."""

from collections.abc import Sequence
from pathlib import Path

import cv2

from core.calibration.camera.undistortion import exact_map, straighten, table_1_map
from core.calibration.files.camera_files import read_camera
from core.calibration.files.pictures import own_names, read_colour, size_words
from core.calibration.reports import CorrectedPictures, Method, RefusedPicture, StraightPicture, correction_report
from core.errors import BadInput
from core.files import folder_at, save
from core.progress import UNSEEN, WorkProgress
from core.sensors.camera import lens_faults
from core.sensors.checks import Fault, UnusableReading, faults_of, found_faults


def correct(
    files: Sequence[Path], camera: Path, out: Path, method: Method = "exact", progress: WorkProgress = UNSEEN
) -> CorrectedPictures:
    """Pictures → straight pictures in `out`, with the errors of Table 1's inverse and of the exact one.

    Raises BadInput when no picture can be corrected, Unavailable when nothing can be written.
    """
    model = read_camera(camera)
    lookup = exact_map(model) if method == "exact" else table_1_map(model)
    folder = folder_at(out)
    written: list[StraightPicture] = []
    refused: list[RefusedPicture] = []
    doubts = lens_faults(camera.name, model)
    faults: list[Fault] = [*doubts]
    taken: set[str] = set()
    for name, path in progress.each(list(zip(own_names(files), files, strict=True)), "pictures"):
        try:
            picture = read_colour(path)
            if picture.shape[:2] != (model.height, model.width):
                raise BadInput(f"it is {size_words(picture)}, the camera file is for {model.width}x{model.height}")
        except BadInput as wrong:
            refused.append({"image": name, "reason": str(wrong)})
            faults += faults_of(wrong)
            continue
        content = cv2.imencode(".png", straighten(picture, lookup))[1].tobytes()
        written.append({"image": name, "file": save(folder / free_name(path.stem, taken), content)})
    if not written:
        reasons = "; ".join(f"{each['image']}: {each['reason']}" for each in refused[:3])
        raise UnusableReading(f"No picture could be corrected. {reasons}".strip(), faults)
    return {
        "method": method,
        "pictures": written,
        "pictures_refused": refused,
        "faults": found_faults(faults),
        "warnings": [one.sentence for one in doubts],
        "error": correction_report(model),
    }


def free_name(stem: str, taken: set[str]) -> str:
    """A file name for the straight picture that none of these pictures has taken yet; it is taken from now on."""
    name, number = f"{stem}_straight.png", 1
    while name in taken:
        number += 1
        name = f"{stem}_straight_{number}.png"
    taken.add(name)
    return name
