"""One picture of a recording, decoded only when it is played."""

import cv2

from core.calibration.files import pictures
from core.message import Array, message


@message
class RecordedPicture:
    """One recorded picture."""

    stamp: float  # [s]
    content: bytes  # JPEG, or what else the camera sent

    @property
    def pixels(self) -> Array:
        """(H, W, 3) uint8, blue-green-red. Raises BadInput."""
        return pictures.decode(self.content, cv2.IMREAD_COLOR)[0]
