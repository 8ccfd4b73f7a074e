"""Check that the numbers of a camera describe a lens: its picture can be mapped to rays and back."""

import numpy as np

from core.errors import BadInput
from core.optics import CameraModel

MIN_VIEW, MAX_VIEW = np.radians(0.5), np.radians(160.0)  # field of view across and down
MAX_ASPECT = 3.0  # between the focal lengths across and down
MAX_COEFFICIENT = 1e9
MAX_ERROR_PX = 1.0  # there and back
MAX_UNREACHED = 0.1  # share of the picture, in its corners, that no ray may reach
GRID_POINTS = 33  # points across and down, the rim included


def check_lens(model: CameraModel) -> None:
    """Raise BadInput for a camera whose distortion cannot be inverted over its picture or that no lens has."""
    if not 1 / MAX_ASPECT <= model.fx / model.fy <= MAX_ASPECT:
        raise BadInput(f"The focal lengths fx and fy differ by more than a factor of {MAX_ASPECT:g}; check both.")
    if np.abs(model.distortion).max() > MAX_COEFFICIENT:
        raise BadInput("A distortion coefficient is far beyond that of any lens; check k1, k2, p1, p2 and k3.")
    u, v = np.linspace(0, model.width, GRID_POINTS), np.linspace(0, model.height, GRID_POINTS)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    with np.errstate(all="ignore"):
        rays = model.unproject(pixels)
        back = model.distort(rays) * (model.fx, model.fy) + (model.cx, model.cy)
        reached = (np.abs(back - pixels).max(axis=1) < MAX_ERROR_PX).reshape(GRID_POINTS, GRID_POINTS)
    lost = 1.0 - float(reached.mean())
    middle = slice(GRID_POINTS // 4, -(GRID_POINTS // 4))
    if lost > MAX_UNREACHED or not reached[middle, middle].all():
        share = f"{100 * lost:.0f} % of the picture"
        raise BadInput(f"The camera's distortion cannot be inverted in {share}; calibrate the camera again.")
    angles = np.arctan(np.where(reached[..., None], rays.reshape(GRID_POINTS, GRID_POINTS, 2), np.nan))
    for name, angle in (("across", angles[GRID_POINTS // 2, :, 0]), ("down", angles[:, GRID_POINTS // 2, 1])):
        view = float(np.nanmax(angle) - np.nanmin(angle))
        if not MIN_VIEW <= view <= MAX_VIEW:
            low, high = np.degrees((MIN_VIEW, MAX_VIEW))
            raise BadInput(
                f"The camera's field of view {name} is {np.degrees(view):.3g} degrees; this model holds for "
                f"{low:g} to {high:g}. Check fx, fy and the distortion, or calibrate the camera again."
            )
