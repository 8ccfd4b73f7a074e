"""The web console around `core`: command line, server, 3-D scene."""

import os
from importlib.metadata import PackageNotFoundError, version

from core.install import DISTRIBUTION
from core.library_threads import ONE_THREAD

# OpenCV reads this once, at its first import: a picture that claims more pixels is refused instead of decoded.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(2**26))

os.environ.update(ONE_THREAD | os.environ)


def beckon_version() -> str:
    """Return the installed version, or "unknown" when run from a bare checkout."""
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "unknown"
