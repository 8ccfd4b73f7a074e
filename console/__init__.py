"""The web console around `core`: command line, server, 3-D scene."""

import os
from importlib.metadata import PackageNotFoundError, version

from core.install import DISTRIBUTION

# OpenCV reads this once, at its first import: a picture that claims more pixels is refused instead of decoded.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(2**26))

# One thread for the algebra: the filter's small matrices lose more to waiting threads than they win from them.
for library in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(library, "1")


def beckon_version() -> str:
    """Return the installed version, or "unknown" when run from a bare checkout."""
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "unknown"
