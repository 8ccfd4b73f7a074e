"""The textures of one world, painted once: its walls in one image, its floor and ceiling, its furniture."""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import cv2
import numpy as np

from core.message import Array
from core.simulation.rendering.mipmap import BOOKS, Colour, TextureCanvas, darker, pyramid, shade
from core.simulation.world import Dressing, Solid, World


class Paint(NamedTuple):
    """Two colours of a wall, the rail between them, and whether it is of brick."""

    lower: Colour
    upper: Colour
    rail: Colour
    split: float  # [m] height of the rail
    brick: bool = False


PAINTS: dict[str, Paint] = {
    "mint": Paint((166, 184, 118), (218, 230, 230), (232, 236, 238), 0.95),
    "sand": Paint((122, 168, 206), (206, 226, 236), (228, 236, 240), 0.95),
    "slate": Paint((142, 106, 78), (190, 172, 156), (216, 208, 200), 1.15),
    "brick": Paint((90, 110, 170), (130, 150, 194), (206, 214, 222), 0.0, brick=True),
}


def paint_wall(sheet: TextureCanvas, paint: Paint) -> None:
    """Cover a whole wall."""
    sheet.pixels[:] = paint.upper
    if paint.brick:
        _bricks(sheet, paint)
    else:
        sheet.fill(0, 0, sheet.width, paint.split, paint.lower)
        sheet.fill(0, paint.split - 0.05, sheet.width, paint.split, paint.rail)
        sheet.fill(0, paint.split - 0.062, sheet.width, paint.split - 0.05, darker(paint.lower, 0.75))
    sheet.grain(0.012)
    sheet.fill(0, 0, sheet.width, 0.085, (78, 74, 70))
    sheet.fill(0, 0.075, sheet.width, 0.085, (120, 116, 112))


def _bricks(sheet: TextureCanvas, paint: Paint) -> None:
    length, course, joint = 0.25, 0.085, 0.012
    rows = (sheet.z / course).astype(int)
    shifted = sheet.u[None, :] / length + 0.5 * (rows % 2)[:, None]
    columns = shifted.astype(int)
    tone = sheet.rng.normal(1.0, 0.07, (rows.max() + 1, columns.max() + 1)).astype(np.float32)
    sheet.pixels[:] = np.asarray(paint.lower, np.float32) * tone[rows[:, None], columns][:, :, None]
    mortar = ((sheet.z % course) < joint)[:, None] | ((shifted % 1.0) * length < joint)
    sheet.pixels[mortar] = paint.upper


def corners(sheet: TextureCanvas, left: int, right: int) -> None:
    """Darken towards a concave corner (-1), brighten the worn edge of a convex one (+1)."""
    for kind, distance in ((left, sheet.u), (right, sheet.width - sheet.u)):
        if kind < 0:
            sheet.times((1 - 0.16 * np.exp(-distance / 0.16))[None, :])
        elif kind > 0:
            sheet.times((1 + 0.12 * (distance < 0.018))[None, :])


def _door(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    wood = (96, 132, 172)
    sheet.fill(u, z, u + w, z + h, (206, 212, 216))
    a, b = u + 0.06, u + w - 0.06
    sheet.fill(a, z, b, z + h - 0.06, wood)
    sheet.fill(a, z, b, z + 0.22, (168, 166, 162))
    for low, high in ((0.34, 0.92), (1.08, h - 0.22)):
        sheet.fill(a + 0.1, z + low, b - 0.1, z + high, darker(wood, 0.74))
        sheet.fill(a + 0.125, z + low + 0.025, b - 0.1, z + high, darker(wood, 0.94))
    sheet.fill(b - 0.13, z + 0.98, b - 0.03, z + 1.02, (60, 60, 60))
    sheet.fill(b - 0.015, z, b, z + h - 0.06, darker(wood, 0.45))
    sheet.fill(a, z, a + 0.015, z + h - 0.06, darker(wood, 0.45))


def _poster(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    back = BOOKS[int(sheet.rng.integers(4))]
    sheet.fill(u, z, u + w, z + h, (244, 246, 246))
    sheet.fill(u + 0.03, z + 0.03, u + w - 0.03, z + h - 0.03, back)
    sheet.fill(u + 0.07, z + h - 0.17, u + w - 0.07, z + h - 0.09, (240, 244, 246))
    centre = (round((u + 0.5 * w) * sheet.scale), round((sheet.height - z - 0.45 * h) * sheet.scale))
    radius = round(0.28 * min(w, h) * sheet.scale)
    cv2.circle(sheet.pixels, centre, radius, (120, 210, 245), -1, cv2.LINE_AA)
    cv2.circle(sheet.pixels, centre, radius * 2 // 3, darker(back, 0.8), -1, cv2.LINE_AA)
    for line in range(3):
        low = z + 0.06 + 0.045 * line
        sheet.fill(u + 0.08, low, u + w * (0.9 - 0.12 * line), low + 0.018, (236, 236, 236))


def _board(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (150, 150, 150))
    sheet.fill(u + 0.03, z + 0.03, u + w - 0.03, z + h - 0.03, (246, 248, 248))
    for row in range(4):
        high = z + h - 0.16 - 0.16 * row
        length = float(sheet.rng.uniform(0.3, 0.8)) * w
        for piece in np.arange(0.1, length, 0.09):
            ink = ((60, 60, 70), (170, 80, 40), (50, 50, 190))[int(sheet.rng.integers(3))]
            sheet.fill(u + piece, high, u + piece + 0.06, high + 0.022, ink)
    sheet.fill(u + 0.2, z - 0.03, u + w - 0.2, z, (110, 110, 112))


def _window(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (236, 240, 240))
    a, b, low, high = u + 0.06, u + w - 0.06, z + 0.06, z + h - 0.06
    for share in np.linspace(0, 1, 24):
        sky = (255 - 10 * share, 236 - 40 * share, 220 - 80 * share)
        sheet.fill(a, low + (high - low) * share * 0.98, b, high, sky)
    sheet.fill(a, low, b, low + 0.18, (120, 160, 130))
    sheet.fill(u + w / 2 - 0.025, z, u + w / 2 + 0.025, z + h, (236, 240, 240))
    sheet.fill(u - 0.05, z - 0.05, u + w + 0.05, z, (220, 226, 228))


def _sign(sheet: TextureCanvas, u: float, z: float, w: float, h: float) -> None:
    sheet.fill(u, z, u + w, z + h, (130, 84, 40))
    sheet.fill(u + 0.02, z + h * 0.55, u + w - 0.02, z + h * 0.8, (245, 245, 245))


DRESSINGS: dict[str, Callable[[TextureCanvas, float, float, float, float], None]] = {
    "door": _door,
    "poster": _poster,
    "board": _board,
    "window": _window,
    "sign": _sign,
}


def _cabinet(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (204, 212, 214)
    count = max(1, round(sheet.width / 0.5))
    for door in range(count + 1):
        u = door * sheet.width / count
        sheet.fill(u - 0.01, 0.08, u + 0.01, sheet.height - 0.03, (112, 118, 120))
        sheet.fill(u + 0.05, sheet.height * 0.5, u + 0.07, sheet.height * 0.5 + 0.16, (70, 70, 72))
    sheet.fill(0, sheet.height - 0.03, sheet.width, sheet.height, (96, 130, 168))
    sheet.fill(0, 0, sheet.width, 0.08, (64, 62, 60))


def _shelf(sheet: TextureCanvas) -> None:
    frame = (120, 156, 188)
    sheet.pixels[:] = (62, 70, 78)
    level = 0.08
    while level < sheet.height - 0.2:
        u = 0.05
        while u < sheet.width - 0.08:
            thick, tall = float(sheet.rng.uniform(0.025, 0.06)), float(sheet.rng.uniform(0.18, 0.28))
            book = BOOKS[int(sheet.rng.integers(len(BOOKS)))]
            if sheet.rng.random() < 0.88:
                sheet.fill(u, level, min(u + thick, sheet.width - 0.04), level + tall, book)
                sheet.fill(
                    u, level + tall * 0.7, min(u + thick, sheet.width - 0.04), level + tall * 0.78, (210, 220, 224)
                )
            u += thick + 0.004
        level += 0.34
        sheet.fill(0, level - 0.03, sheet.width, level, frame)
    sheet.fill(0, sheet.height - 0.04, sheet.width, sheet.height, frame)
    sheet.fill(0, 0, sheet.width, 0.08, darker(frame, 0.7))
    sheet.fill(0, 0, 0.035, sheet.height, frame)
    sheet.fill(sheet.width - 0.035, 0, sheet.width, sheet.height, frame)


def _cardboard(sheet: TextureCanvas) -> None:
    card = (112, 158, 196)
    sheet.pixels[:] = card
    sheet.grain(0.03)
    middle = sheet.width / 2
    sheet.fill(middle - 0.03, 0, middle + 0.03, sheet.height, (150, 190, 216))
    sheet.fill(sheet.width * 0.62, sheet.height * 0.2, sheet.width * 0.9, sheet.height * 0.45, (236, 240, 240))
    sheet.fill(sheet.width * 0.66, sheet.height * 0.3, sheet.width * 0.86, sheet.height * 0.34, (60, 60, 60))
    for u in (0.0, sheet.width - 0.012):
        sheet.fill(u, 0, u + 0.012, sheet.height, darker(card, 0.8))


def _concrete(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (178, 182, 182)
    sheet.grain(0.02)
    sheet.fill(0, 0, sheet.width, 0.9, (140, 152, 158))
    sheet.fill(0, 0.9, sheet.width, 0.93, (40, 150, 220))


def _plain(sheet: TextureCanvas, colour: Colour) -> None:
    sheet.pixels[:] = colour


def _bin(sheet: TextureCanvas) -> None:
    sheet.pixels[:] = (120, 76, 44)
    for z in (0.04, sheet.height - 0.05):
        sheet.fill(0, z, sheet.width, z + 0.03, (168, 120, 76))


FURNITURE: dict[str, Callable[[TextureCanvas], None]] = {
    "cabinet": _cabinet,
    "shelf": _shelf,
    "box": _cardboard,
    "column": _concrete,
    "pillar": _concrete,
    "steel": partial(_plain, colour=(150, 146, 142)),
    "bin": _bin,
    "wood": partial(_plain, colour=(118, 158, 194)),
    "seat": partial(_plain, colour=(58, 54, 150)),
}


def paint_round(sheet: TextureCanvas) -> None:
    """Light a texture that goes around a post, u from the side that looks to +x."""
    around = sheet.u / sheet.width * 2 * np.pi
    sheet.times(np.asarray(shade(around), np.float32)[None, :])


# Floor and ceiling.


def paint_floor(width: float, height: float, scale: float, obstacles: Sequence[Array]) -> Array:
    """Tiles in the light of the lamps, dark where `obstacles` (polygons (K, 2) [m]) stand → (H, W, 3) uint8."""
    rows, columns = round(height * scale), round(width * scale)
    x = (np.arange(columns, dtype=np.float32) + 0.5) / scale
    y = (np.arange(rows, dtype=np.float32) + 0.5) / scale
    tile, joint = 0.5, 0.009
    tone = np.random.default_rng(7).normal(1.0, 0.025, (int(height / tile) + 2, int(width / tile) + 2))
    tone[::2, ::2] *= 0.93
    tone[1::2, 1::2] *= 0.93
    bright = tone.astype(np.float32)[(y / tile).astype(int)[:, None], (x / tile).astype(int)[None, :]]
    bright[(y % tile < joint), :] *= 0.72
    bright[:, (x % tile < joint)] *= 0.72
    lamps = (0.90 + 0.10 * np.cos(2 * np.pi * y / 2.4))[:, None] * (0.93 + 0.07 * np.cos(2 * np.pi * x / 2.4))[
        None, :
    ]
    small = np.full((rows // 4 + 1, columns // 4 + 1), 255, np.uint8)
    for polygon in obstacles:
        cv2.fillPoly(small, [np.round(polygon * scale / 4).astype(np.int32)], 0)
    away = cv2.distanceTransform(small, cv2.DIST_L2, 5) * 4 / scale
    shadow = cv2.resize(1 - 0.42 * np.exp(-away / 0.13), (columns, rows), interpolation=cv2.INTER_LINEAR)
    bright *= lamps
    bright *= shadow
    image = np.empty((rows, columns, 3), np.uint8)
    for channel, level in enumerate((150.0, 166.0, 178.0)):
        image[:, :, channel] = np.clip(bright * level, 0, 255)
    return image


def paint_ceiling(width: float, height: float, scale: float) -> Array:
    """Panels and lamps → (H, W, 3) uint8."""
    rows, columns = round(height * scale), round(width * scale)
    x = (np.arange(columns, dtype=np.float32) + 0.5)[None, :] / scale
    y = (np.arange(rows, dtype=np.float32) + 0.5)[:, None] / scale
    bright = np.full((rows, columns), 214.0, np.float32)
    bright[np.broadcast_to((x % 0.6 < 0.02) | (y % 0.6 < 0.02), bright.shape)] = 186.0
    bright[(np.abs(x % 2.4 - 1.2) < 0.6) & (np.abs(y % 2.4 - 1.2) < 0.16)] = 255.0
    return np.repeat(bright.astype(np.uint8)[:, :, None], 3, axis=2)


PYRAMID_LEVELS = 4  # of halving, for what is far away
FLOOR_LEVELS = 6
MAX_WIDTH_PX = 30_000  # OpenCV samples no image beyond 32767
MAX_PIXELS_PER_METRE = 125.0  # [pixel/m] of walls
FLOOR_FINEST, FLOOR_PIXELS = 200.0, 6e6
SHADOW_REACH_M = 0.15  # how far the shadow of something placed reaches


class Mipmap(NamedTuple):
    """A texture and its halves."""

    images: list[Array]
    scale: float  # [pixel/m] of the first

    def level(self, footprint: float) -> tuple[Array, float]:
        """The image whose pixels are about as large as `footprint` [m], and its scale [pixel/m]."""
        level = int(np.clip(np.log2(max(footprint * self.scale, 1e-6)) + 0.5, 0, len(self.images) - 1))
        return self.images[level], self.scale / 2**level


class WallTexture:
    """All walls side by side, at every level below each other."""

    def __init__(self, world: World) -> None:
        walls = world.walls
        lengths = np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1])
        self.height, self.lengths = world.height, lengths
        self.scale = min(MAX_PIXELS_PER_METRE, MAX_WIDTH_PX / (lengths.sum() + 0.1 * len(walls)))
        images = [pyramid(image, PYRAMID_LEVELS) for image in _painted_walls(world, lengths, self.scale)]
        sizes = np.array([[level.shape[:2] for level in image] for image in images])  # (W, LEVELS, 2)
        # by level and column: (LEVELS, W)
        self.left = np.hstack((np.zeros((PYRAMID_LEVELS, 1)), np.cumsum(sizes[:, :, 1].T, axis=1)[:, :-1]))
        self.widths, self.heights = sizes[:, :, 1].T, sizes[0, :, 0]
        self.top = np.concatenate(([0], np.cumsum(self.heights + 2)[:-1])) + 1
        self.pixels = np.zeros((int(sum(self.heights + 2)), int(sizes[:, 0, 1].sum()), 3), np.uint8)
        for level in range(PYRAMID_LEVELS):
            row = np.hstack([image[level] for image in images])
            row = cv2.copyMakeBorder(row, 1, 1, 0, 0, cv2.BORDER_REPLICATE)
            self.pixels[self.top[level] - 1 : self.top[level] + self.heights[level] + 1, : row.shape[1]] = row


def _painted_walls(world: World, lengths: Array, scale: float) -> list[Array]:
    walls = world.walls
    sheets: list[TextureCanvas] = []
    for number, (wall, length) in enumerate(zip(walls, lengths, strict=True)):
        sheet = TextureCanvas(float(length), world.height, scale, f"{world.name} {number}")
        middle = (wall[:2] + wall[2:]) / 2
        paint = [zone.paint for zone in world.zones if zone.area.contains(*middle)]
        paint_wall(sheet, PAINTS[paint[-1] if paint else "sand"])
        sheets.append(sheet)
    shine = [hung for hung in world.dressings if hung.what == "window"]
    for hung in world.dressings:
        if hung not in shine:
            _hang(hung, walls, lengths, sheets)
    for number, (wall, sheet) in enumerate(zip(walls, sheets, strict=True)):
        corners(sheet, _bend(walls, number, end=True), _bend(walls, number, end=False))
        sheet.footing()
        looks = np.arctan2(wall[2] - wall[0], wall[1] - wall[3])  # the direction of its open side
        sheet.times(np.array([[shade(float(looks))]], np.float32))
    for hung in shine:  # daylight, whatever way the wall looks
        _hang(hung, walls, lengths, sheets)
    return [sheet.finished() for sheet in sheets]


def _hang(hung: Dressing, walls: Array, lengths: Array, sheets: list[TextureCanvas]) -> None:
    number, along = _nearest_wall(walls, hung.x, hung.y)
    u = lengths[number] - along - hung.width / 2  # a wall is seen from its left: it runs from right to left
    DRESSINGS[hung.what](sheets[number], u, hung.bottom, hung.width, hung.top - hung.bottom)


def _nearest_wall(walls: Array, x: float, y: float) -> tuple[int, float]:
    """The wall at (x, y), and how far along it that is [m]."""
    edge = walls[:, 2:] - walls[:, :2]
    length = np.hypot(edge[:, 0], edge[:, 1])
    along = np.einsum("ij,ij->i", (x, y) - walls[:, :2], edge) / length
    held = np.clip(along, 0, length)
    gap = (x, y) - walls[:, :2] - held[:, None] * edge / length[:, None]
    number = int(np.hypot(gap[:, 0], gap[:, 1]).argmin())
    return number, float(held[number])


def _bend(walls: Array, number: int, *, end: bool) -> int:
    """Corner at one end of a wall: -1 concave, +1 convex, 0 none."""
    point = walls[number, 2:] if end else walls[number, :2]
    ends = walls[:, :2] if end else walls[:, 2:]
    neighbours = np.flatnonzero(np.abs(ends - point).max(axis=1) < 1e-6)
    if len(neighbours) != 1:
        return 0
    first, second = (walls[number], walls[neighbours[0]]) if end else (walls[neighbours[0]], walls[number])
    (ax, ay), (bx, by) = first[2:] - first[:2], second[2:] - second[:2]
    return -int(np.sign(ax * by - ay * bx))


class _Room(NamedTuple):
    walls: WallTexture
    corner: tuple[float, float]  # [m] of floor and ceiling
    floor: Mipmap  # without the shadows of what was placed in the world
    ceiling: Mipmap


@lru_cache(maxsize=2)
def _room(world: World) -> _Room:
    """Paint a world, or return it as it was painted: worlds are keys by identity and never change."""
    bounds = world.bounds
    corner = (bounds.x0 - 0.1, bounds.y0 - 0.1)
    size = bounds.x1 - bounds.x0 + 0.2, bounds.y1 - bounds.y0 + 0.2
    scale = min(FLOOR_FINEST, (FLOOR_PIXELS / (size[0] * size[1])) ** 0.5)
    standing = [
        _plan(solid) - corner
        for thing in world.things
        if thing.fixed
        for solid in thing.solids
        if solid.bottom == 0.0
    ]
    bare = pyramid(paint_floor(*size, scale, [*_walls_plan(world, corner), *standing]), FLOOR_LEVELS)
    ceiling = pyramid(paint_ceiling(*size, 40.0), PYRAMID_LEVELS)
    return _Room(WallTexture(world), corner, Mipmap(bare, scale), Mipmap(ceiling, 40.0))


class WorldTextures:
    """The textures of the camera's picture of a world."""

    def __init__(self, world: World) -> None:
        self.walls, self.corner, self._bare, self.ceiling = _room(world)
        self.floor = self._bare  # the first shadow takes a copy
        self._shaded: list[tuple[Array, Array]] = []  # parts of the floor, and how they are when bare
        self._furniture: dict[tuple[str, float, float], Mipmap] = {}

    def furniture(self, solid: Solid, width: float) -> Mipmap:
        """The texture of one face, `width` [m] wide, or around a post."""
        key = (solid.look, round(width, 2), round(solid.top - solid.bottom, 2))
        if key not in self._furniture:
            sheet = TextureCanvas(key[1], key[2], 200.0 if width < 1 else MAX_PIXELS_PER_METRE, repr(key))
            FURNITURE[solid.look](sheet)
            if solid.bottom == 0.0:
                sheet.footing()
            if solid.radius > 0:
                paint_round(sheet)
            self._furniture[key] = Mipmap(pyramid(sheet.finished(), PYRAMID_LEVELS), sheet.scale)
        return self._furniture[key]

    def cast_shadows(self, world: World) -> None:
        """Draw the shadows of what was placed in the world on the bare floor."""
        for part, bare in self._shaded:
            part[:] = bare
        self._shaded.clear()
        placed = [solid for thing in world.things if not thing.fixed for solid in thing.solids if solid.bottom == 0.0]
        if placed and self.floor is self._bare:
            self.floor = Mipmap([level.copy() for level in self._bare.images], self._bare.scale)
        for level, (image, bare) in enumerate(zip(self.floor.images, self._bare.images, strict=True)):
            for solid in placed:
                self._darken(image, bare, _plan(solid) - self.corner, self.floor.scale / 2**level)

    def _darken(self, image: Array, bare: Array, polygon: Array, scale: float) -> None:
        low = np.maximum(np.floor((polygon.min(axis=0) - 2 * SHADOW_REACH_M) * scale), 0).astype(int)
        high = np.minimum(np.ceil((polygon.max(axis=0) + 2 * SHADOW_REACH_M) * scale), image.shape[1::-1]).astype(int)
        if (high - low < 3).any():
            return
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), np.float32)
        cv2.fillPoly(mask, [np.round(polygon * scale - low).astype(np.int32)], 1.0)
        mask = cv2.GaussianBlur(mask, (0, 0), max(0.5, 0.5 * SHADOW_REACH_M * scale))
        area = (slice(low[1], high[1]), slice(low[0], high[0]))
        image[area] = image[area] * (1 - 0.6 * mask)[:, :, None]
        self._shaded.append((image[area], bare[area]))


def _plan(solid: Solid) -> Array:
    """Its footprint as a polygon (K, 2) [m]."""
    if solid.radius == 0:
        return solid.corners
    around = np.linspace(0, 2 * np.pi, 17)[:-1]
    return solid.centre + solid.radius * np.column_stack((np.cos(around), np.sin(around)))


def _walls_plan(world: World, corner: tuple[float, float]) -> list[Array]:
    """Thin strips behind the walls, as polygons [m] from `corner`."""
    strips: list[Array] = []
    for wall in world.walls - np.tile(corner, 2):
        edge = wall[2:] - wall[:2]
        behind = np.array([edge[1], -edge[0]]) / np.hypot(*edge) * 0.06
        strips.append(np.array([wall[:2], wall[2:], wall[2:] + behind, wall[:2] + behind]))
    return strips
