"""MediaPipe's two pose networks and what runs them: OpenCV the landmark network, LiteRT both, and faster.

Neither network is part of Beckon; `core.models` knows where they come from (package mediapipe 0.10.21, Apache-2.0).
"""

import importlib.util
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.message import Array

LANDMARK_SIDE, DETECTOR_SIDE = 256, 224  # [pixel] of what goes in
LANDMARK_FILE = "pose_landmark/pose_landmark_full.tflite"
DETECTOR_FILE = "pose_detection/pose_detection.tflite"
LITERT = "ai_edge_litert"
DAMAGED = "The file {} of the pose model cannot be used: beckon models get people"


class PoseNetworks(Protocol):
    """An engine that runs the networks."""

    @property
    def name(self) -> str:
        """The engine, for people: "LiteRT"."""
        ...

    @property
    def detects(self) -> bool:
        """True where the detector network runs as well."""
        ...

    def landmarks(self, crop: Array) -> tuple[Array, float]:
        """Crop (256, 256, 3) uint8 → 39 rows of x, y [pixel of the crop], z, visibility, presence (both logits), and
        how sure it is that someone is there, 0..1.
        """
        ...

    def faces(self, square: Array) -> tuple[Array, Array]:
        """Picture (224, 224, 3) uint8 → the detector's rows (2254, 12) and scores (2254,). Raises Unavailable."""
        ...


class OpenCvNetworks:
    """The landmark network alone: OpenCV does not read the detector (its DENSIFY)."""

    name = "OpenCV"
    detects = False

    def __init__(self, folder: Path) -> None:
        """Raises BadInput where the file is damaged."""
        path = str(folder / LANDMARK_FILE)
        try:
            classic = getattr(cv2.dnn, "ENGINE_CLASSIC", None)  # OpenCV 5's other engine drops outputs
            read: Any = cv2.dnn.readNetFromTFLite
            self._net: Any = read(path) if classic is None else read(path, classic)
        except cv2.error:
            raise BadInput(DAMAGED.format(LANDMARK_FILE)) from None

    def landmarks(self, crop: Array) -> tuple[Array, float]:
        """Run the landmark network."""
        self._net.setInput(cv2.dnn.blobFromImage(crop, 1 / 255, swapRB=True))
        rows, sure = self._net.forward(["Identity", "Identity_1"])
        return rows.reshape(39, 5).astype(float), first_number(sure)

    def faces(self, square: Array) -> tuple[Array, Array]:
        """There is no detector here."""
        raise Unavailable(f"OpenCV does not run the detector network: {install_extra('people')}")


class LiteRtNetworks:
    """Both networks by LiteRT."""

    name = "LiteRT"
    detects = True

    def __init__(self, folder: Path) -> None:
        """Raises Unavailable without the package, BadInput where a file is damaged."""
        if not has_litert():
            raise Unavailable(f"LiteRT is not installed: {install_extra('people')}")
        self._landmarks = _LiteRtNetwork(folder / LANDMARK_FILE)
        self._faces = _LiteRtNetwork(folder / DETECTOR_FILE)

    def landmarks(self, crop: Array) -> tuple[Array, float]:
        """Run the landmark network."""
        rows, sure = self._landmarks.run(crop[None, :, :, ::-1].astype(np.float32) / np.float32(255))
        return rows.reshape(39, 5).astype(float), first_number(sure)

    def faces(self, square: Array) -> tuple[Array, Array]:
        """Run the detector network."""
        rows, scores = self._faces.run(square[None, :, :, ::-1].astype(np.float32) / np.float32(127.5) - 1)
        return rows.reshape(-1, 12).astype(float), scores.reshape(-1).astype(float)


class _LiteRtNetwork:
    """One network with its outputs `Identity` and `Identity_1`."""

    def __init__(self, path: Path) -> None:
        from ai_edge_litert.interpreter import Interpreter  # an optional package

        try:
            self._net: Any = Interpreter(str(path), num_threads=1)
            self._net.allocate_tensors()
            named = {each["name"]: each["index"] for each in self._net.get_output_details()}
            self._outputs = named["Identity"], named["Identity_1"]
            self._input = self._net.get_input_details()[0]["index"]
        except (ValueError, RuntimeError, KeyError, IndexError):
            raise BadInput(DAMAGED.format(path.name)) from None

    def run(self, given: Array) -> tuple[Array, Array]:
        self._net.set_tensor(self._input, given)
        self._net.invoke()
        first, second = self._outputs
        return self._net.get_tensor(first), self._net.get_tensor(second)


def open_networks(folder: Path) -> PoseNetworks:
    """Open the faster one that is here. Raises BadInput."""
    networks = LiteRtNetworks(folder) if has_litert() else OpenCvNetworks(folder)
    networks.landmarks(np.zeros((LANDMARK_SIDE, LANDMARK_SIDE, 3), np.uint8))  # the first run takes longer
    if networks.detects:
        networks.faces(np.zeros((DETECTOR_SIDE, DETECTOR_SIDE, 3), np.uint8))
    return networks


def has_litert() -> bool:
    """Return whether LiteRT is installed."""
    return importlib.util.find_spec(LITERT) is not None


def first_number(values: Array) -> float:
    """The first number of an output."""
    return float(np.ravel(values)[0])
