"""A small ray-caster of its own: walls as segments, a laser like the URG-04LX, and a camera that paints bearings."""

import numpy as np

from core.geometry import Pose, arc
from core.sensors import Camera, Laser, Scan

LASER = Laser()


def cast(walls: np.ndarray, origins: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Walls (W, 4) x0 y0 x1 y1, rays from (N, 2) along (N,) → distances (N,), inf where nothing stands."""
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    nearest = np.full(len(angles), np.inf)
    for x0, y0, x1, y1 in walls:
        along = np.array([x1 - x0, y1 - y0])
        start = np.array([x0, y0]) - origins
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = rays[:, 0] * along[1] - rays[:, 1] * along[0]
            distance = (start[:, 0] * along[1] - start[:, 1] * along[0]) / crossing
            share = (start[:, 0] * rays[:, 1] - start[:, 1] * rays[:, 0]) / crossing
        hit = (distance > 0) & (share >= 0) & (share <= 1) & (distance < nearest)
        nearest = np.where(hit, distance, nearest)
    return nearest


def scan_of(
    walls: np.ndarray,
    rng: np.random.Generator,
    *,
    pose: Pose | None = None,
    floor: float = 0.01,
    share: float = 0.01,
    range_max: float = 5.6,
    speed: float = 0.0,
    turn_rate: float = 0.0,
) -> Scan:
    """One scan from a pose, at rest or on an arc that passes the pose when the scan begins."""
    pose = pose or Pose()
    times = LASER.time_step * np.arange(LASER.beams)
    moving = speed != 0.0 or turn_rate != 0.0
    way = [pose @ arc(speed * t, turn_rate * t) for t in times] if moving else [pose] * LASER.beams
    origins = np.array([(p.x, p.y) for p in way])
    headings = np.array([p.heading for p in way])
    distance = cast(walls, origins, headings + LASER.angle_min + LASER.angle_step * np.arange(LASER.beams))
    seen = np.where(distance <= range_max, distance, np.nan)
    noisy = seen + rng.normal(size=len(seen)) * np.maximum(floor, share * seen)
    return Scan(
        stamp=0.0,
        ranges=np.where(np.isfinite(distance), noisy, np.inf),
        angle_min=LASER.angle_min,
        angle_step=LASER.angle_step,
        range_max=range_max,
        time_step=LASER.time_step if moving else 0.0,
    )


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    """The four walls (4, 4) of a rectangle."""
    return np.array([(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)])


def two_walls(
    distance: float, convex: bool, rng: np.random.Generator, length: float = 1.2
) -> tuple[np.ndarray, np.ndarray]:
    """A right-angled corner `distance` ahead, somewhat turned → where it is (2,), and its walls (2, 4)."""
    bearing, turned = rng.uniform(-1.5, 1.5), rng.uniform(-0.35, 0.35)
    corner = distance * np.array([np.cos(bearing), np.sin(bearing)])
    middle = bearing + turned + (0.0 if convex else np.pi)
    ends = [corner + length * np.array([np.cos(middle + side), np.sin(middle + side)]) for side in (0.785, -0.785)]
    return corner, np.array([(*corner, *end) for end in ends])


def picture(
    camera: Camera, bearings: list[float], rng: np.random.Generator, contrast: float = 25.0, lean: float = 0.0
) -> np.ndarray:
    """Walls that change their shade at bearings [rad] seen from the camera, with a floor, a ceiling and noise.

    `lean` [rad]: how far the shade's border leans off the vertical.
    """
    model, fine = camera.model, 3
    u, v = np.meshgrid(
        (np.arange(model.width * fine) + 0.5) / fine - 0.5, (np.arange(model.height * fine) + 0.5) / fine - 0.5
    )
    rays = model.unproject(np.column_stack((u.ravel(), v.ravel())))
    ways = np.column_stack((rays, np.ones(len(rays)))) @ camera.mounting.rotation.T
    azimuth = np.arctan2(ways[:, 1], ways[:, 0]).reshape(u.shape)
    height = (ways[:, 2] / np.hypot(ways[:, 0], ways[:, 1])).reshape(u.shape)
    shade = np.full(u.shape, 120.0)
    for index, bearing in enumerate(sorted(bearings)):
        step = contrast if index % 2 == 0 else -contrast
        shade = np.where(azimuth + np.tan(lean) * height > bearing, shade + step, shade)
    shade = np.where(height < -0.25, 80.0, np.where(height > 0.35, 160.0, shade))
    shade = shade.reshape(model.height, fine, model.width, fine).mean(axis=(1, 3))
    grey = np.clip(shade + rng.normal(0, 2.0, shade.shape), 0, 255).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)
