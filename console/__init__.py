"""The web console around `core`: command line, server, 3-D scene."""

import os

# OpenCV reads this once, at its first import: a picture that claims more pixels is refused instead of decoded.
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(2**25))
