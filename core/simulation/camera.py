"""Makes the camera's pictures: the world, the lens, the light, the sensor's noise."""

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from core.geometry import Pose, Transform
from core.message import Array
from core.optics import CameraModel
from core.sensors.camera import Camera, Image
from core.simulation.rendering.render import Renderer
from core.simulation.rendering.view import Eye, PinholeView
from core.simulation.world import World

DRAWN_PER_PIXEL = 1.4  # pixels of the drawn view for each of the picture's
SPARE_PX = 160  # how much larger the stored noise is than a picture


class SimulatedCamera:
    """A camera in a world. It must look nearly level: rays steeper than 45° are not drawn."""

    def __init__(
        self,
        camera: Camera,
        world: World,
        rng: np.random.Generator,
        *,
        light: float = 1.0,
        snr: float = 42.0,
        exposure: float = 0.0,
        defocus: float = 0.0,
    ) -> None:
        """`exposure` [s] blurs by the turn meanwhile; `defocus` is the sd [pixel] of a blur everywhere."""
        self.camera, self._rng, self._light = camera, rng, light
        self._exposure, self._defocus = exposure, defocus
        self._lens = _lens(camera.model, camera.mounting)
        self._renderer = Renderer(self._lens.view, world)
        noise_sd = 255 / 10 ** (snr / 20)
        shape = (camera.model.height + SPARE_PX, camera.model.width + SPARE_PX, 3)
        self._noise = np.round(rng.normal(0.0, noise_sd, shape)).astype(np.int16)
        self._view: tuple[World, Eye, float] | None = None  # what the pixels without noise show
        self._pixels = np.empty(0, np.uint8)

    def take(self, world: World, stamp: float, pose: Pose, turn_rate: float = 0.0) -> Image:
        """The picture of a robot at `pose`, in the middle of the exposure, that turns at `turn_rate` [rad/s]."""
        model, mounting = self.camera.model, self.camera.mounting
        x, y = pose.apply(mounting.translation[None, :2])[0]
        eye = Eye(float(x), float(y), float(mounting.translation[2]), pose.heading + self._lens.heading)
        turned = abs(turn_rate) * self._exposure
        if self._view is None or self._view[0] is not world or self._view[1:] != (eye, turned):
            self._view, self._pixels = (world, eye, turned), self._without_noise(world, eye, turned)
        row, column = self._rng.integers(SPARE_PX, size=2)
        noise = self._noise[row : row + model.height, column : column + model.width]
        return Image(stamp=stamp, pixels=cv2.add(self._pixels, noise, dtype=cv2.CV_8U))

    def _without_noise(self, world: World, eye: Eye, turned: float) -> Array:
        """The picture (H, W, 3) uint8 as light and lens make it; a standing robot needs it only once."""
        drawn = cv2.GaussianBlur(self._renderer.draw(world, eye), (3, 3), 0.6)
        drawn = self._blurred(drawn, turned)
        pixels = cv2.remap(drawn, *self._lens.maps, cv2.INTER_LINEAR)
        return cv2.convertScaleAbs(pixels, alpha=self._light) if self._light != 1.0 else pixels

    def _blurred(self, drawn: Array, turned: float) -> Array:
        """The drawn view as it smears while the robot turns by `turned` [rad], and out of focus."""
        length = DRAWN_PER_PIXEL * self.camera.model.fx * turned
        if length > 1:
            drawn = cv2.filter2D(drawn, -1, _box(length), borderType=cv2.BORDER_REPLICATE)
        if self._defocus > 0:
            drawn = cv2.GaussianBlur(drawn, (0, 0), DRAWN_PER_PIXEL * self._defocus)
        return drawn


def _box(length: float) -> Array:
    """A mean over `length` > 1 [pixel] of a row (1, N), its ends taken in part."""
    reach = math.ceil(0.5 * (length - 1))
    kernel = np.clip(0.5 * (length + 1) - np.abs(np.arange(-reach, reach + 1.0)), 0.0, 1.0)
    return (kernel / kernel.sum())[None, :]


class _Lens(NamedTuple):
    view: PinholeView
    heading: float  # [rad] of the view, in the robot's axes
    maps: tuple[Array, Array]  # the picture's pixels in the view, as `cv2.remap` takes them


@lru_cache(maxsize=4)
def _lens(model: CameraModel, mounting: Transform) -> _Lens:
    """The lens of a camera; messages are keys by identity, so robots with the camera of every day share one."""
    rays, heading = _level_rays(model, mounting.rotation)
    view = _view_around(rays, DRAWN_PER_PIXEL * model.fx)
    map_u = (view.cx + view.focal * rays[:, :, 0]).astype(np.float32)
    map_v = (view.cy + view.focal * rays[:, :, 1]).astype(np.float32)
    first, second = cv2.convertMaps(map_u, map_v, cv2.CV_16SC2)
    return _Lens(view, heading, (first, second))


def _level_rays(model: CameraModel, rotation: Array) -> tuple[Array, float]:
    """Return the ray of each pixel (H, W, 2), right and down per metre ahead, and the level heading [rad]."""
    u, v = np.meshgrid(np.arange(model.width), np.arange(model.height))
    ideal = model.unproject(np.column_stack((u.ravel(), v.ravel())).astype(float))
    rays = np.column_stack((ideal, np.ones(len(ideal)))) @ rotation.T
    heading = math.atan2(rotation[1, 2], rotation[0, 2])
    c, s = math.cos(heading), math.sin(heading)
    ahead, right = c * rays[:, 0] + s * rays[:, 1], s * rays[:, 0] - c * rays[:, 1]
    ahead = np.maximum(ahead, 1e-3)
    level = np.column_stack((right / ahead, -rays[:, 2] / ahead))
    return np.clip(level, -1.2, 1.2).reshape(model.height, model.width, 2), heading


def _view_around(rays: Array, focal: float) -> PinholeView:
    low, high = rays.reshape(-1, 2).min(axis=0) * focal, rays.reshape(-1, 2).max(axis=0) * focal
    width, height = np.ceil(high - low).astype(int) + 3
    return PinholeView(int(width), int(height), focal, 1 - float(low[0]), 1 - float(low[1]))
