"""Pictures of a world for a level, undistorted pinhole view: column by column, what is near over what is far."""

import math

import cv2
import numpy as np

from core.message import Array
from core.simulation.rendering.chessboard import see
from core.simulation.rendering.mipmap import shade
from core.simulation.rendering.person import (
    DRAWING_HEIGHT_M,
    DRAWING_WIDTH_M,
    PERSON_HEIGHT_M,
    PIXELS_PER_METRE,
    VIEW_COUNT,
    figure,
)
from core.simulation.rendering.textures import PYRAMID_LEVELS, WorldTextures
from core.simulation.rendering.view import Eye, Patch, PinholeView, ahead_of, plane
from core.simulation.world import HeldBoard, Solid, Surfaces, Thing, World, cast

NEAR_PLANE_M = 0.03  # nothing is drawn closer to the eye


class Renderer:
    """Draws one view of a world again and again; owns the pixels it works on."""

    def __init__(self, view: PinholeView, world: World) -> None:
        self.view, self._world = view, world
        self._scenery = WorldTextures(world)
        self._walls = Surfaces(faces=world.walls, posts=np.empty((0, 3)))
        self._x, self._y = view.x, view.y.astype(np.float32)
        self._far = np.empty(view.width, np.float32)  # [m] ahead to the wall in every column
        shape = (view.height, view.width)
        self._picture = np.empty((*shape, 3), np.uint8)
        self._ground = np.empty((*shape, 3), np.uint8)
        self._depth = np.empty(shape, np.float32)
        self._below = np.empty(shape, bool)  # the eye sees this by its reflection in the floor
        self._map_u, self._map_v = np.empty(shape, np.float32), np.empty(shape, np.float32)
        steep = np.clip(self._y / 0.45, 0.0, 1.0)
        self._gloss = (0.10 + 0.34 * (1 - steep) ** 3)[:, None].astype(np.float32)

    def draw(self, world: World, eye: Eye) -> Array:
        """The picture (H, W, 3) uint8, blue-green-red; valid until the next call."""
        if world is not self._world:
            self._scenery.cast_shadows(world)
            self._world = world
        self._draw_walls(eye)
        for thing in world.things:
            if thing.what == "person":
                self._draw_person(thing, eye)
            else:
                for solid in thing.solids:
                    self._draw_solid(solid, eye)
        if world.board is not None:
            self._draw_board(world.board, eye)
        self._draw_floor(eye)
        return self._picture

    def _draw_walls(self, eye: Eye) -> None:
        sheet, view = self._scenery.walls, self.view
        c, s = math.cos(eye.heading), math.sin(eye.heading)
        rays = np.column_stack((c + s * self._x, s - c * self._x))
        hits = cast(np.array([eye.x, eye.y]), rays, self._walls)
        far = np.where(np.isfinite(hits.distance), hits.distance, 1e3).astype(np.float32)
        wall = np.maximum(hits.surface, 0)
        u = sheet.lengths[wall] - np.nan_to_num(hits.along)
        stretch = np.abs(np.gradient(u))
        stretch[np.diff(wall, append=wall[-1]) != 0] = 0.0
        footprint = np.maximum(far / view.focal, np.minimum(stretch, 0.3)) * sheet.scale
        level = np.clip(np.log2(footprint) + 0.4, 0, PYRAMID_LEVELS - 1).astype(int)
        scale = sheet.scale / 2.0**level
        width = sheet.widths[level, wall]
        self._map_u[:] = sheet.left[level, wall] + np.clip(u * scale, 0.5, width - 0.5) - 0.5
        z = np.subtract(np.float32(eye.z), self._y[:, None] * far[None, :], out=self._map_v)
        np.less(z, 0, out=self._below)
        above = far.max() * -self._y[0] > sheet.height - eye.z
        open_rows = z > sheet.height if above else None
        np.abs(z, out=z)
        np.minimum(z, sheet.height, out=z)
        z *= -(scale[None, :].astype(np.float32))
        z += (sheet.top[level] + sheet.height * scale - 0.5)[None, :].astype(np.float32)
        cv2.remap(sheet.pixels, self._map_u, self._map_v, cv2.INTER_LINEAR, dst=self._picture)
        self._far = far
        self._depth[:] = far
        if open_rows is not None:
            self._draw_ceiling(eye, open_rows)

    def _draw_ceiling(self, eye: Eye, where: Array) -> None:
        rise = self._scenery.walls.height - eye.z
        last = int(np.flatnonzero(where.any(axis=1))[-1]) + 1
        image, scale = self._scenery.ceiling.level(0.02)
        matrix = plane(self.view, eye, -rise, self._scenery.corner, scale)
        seen = cv2.warpPerspective(image, matrix, (self.view.width, last), flags=_SAMPLE, borderMode=_EDGE)
        cv2.copyTo(seen, where[:last].view(np.uint8), self._picture[:last])

    def _draw_floor(self, eye: Eye) -> None:
        """Under everything that stands on it, with a faint reflection of that."""
        view = self.view
        first = int(self._below.any(axis=1).argmax())
        if not self._below[-1].any():
            return
        slope = np.maximum(self._y[np.arange(first, view.height)], 1e-3)
        far = eye.z / slope
        footprint = far / view.focal * np.sqrt(far / eye.z)
        level = np.clip(np.log2(footprint * self._scenery.floor.scale) + 0.8, 0, len(self._scenery.floor.images) - 1)
        level = level.astype(int)
        for start, end in _runs(level):
            image, scale = self._scenery.floor.level(2.0 ** level[start] / self._scenery.floor.scale)
            matrix = plane(view, eye, eye.z, self._scenery.corner, scale, first + start)
            band = self._ground[first + start : first + end]
            cv2.warpPerspective(image, matrix, (view.width, end - start), dst=band, flags=_SAMPLE, borderMode=_EDGE)
        shine = self._gloss[first:]
        below = self._below[first:]
        scene_weight = np.where(below, shine, np.float32(1.0))
        picture = self._picture[first:]
        picture[:] = cv2.blendLinear(picture, self._ground[first:], scene_weight, 1 - scene_weight)

    def _draw_solid(self, solid: Solid, eye: Eye) -> None:
        ahead, right = eye.sees(solid.centre[None])[0]
        extent = solid.radius or float(np.hypot(*(solid.corners - solid.centre).T).max())
        if ahead < -extent or abs(right) > extent * 1.6 + (ahead + extent) * abs(self._x).max():
            return
        if solid.radius > 0:
            self._draw_post(solid, eye, ahead, right)
            return
        seen = eye.sees(solid.corners)
        if solid.bottom > eye.z:
            self._draw_underside(solid, eye, seen)
        for corner in range(len(seen)):
            self._draw_face(solid, eye, seen[corner], seen[(corner + 1) % len(seen)], corner)

    def _draw_face(self, solid: Solid, eye: Eye, start: Array, end: Array, number: int) -> None:
        """One face of a prism, from its left end to its right one as seen from outside."""
        (ahead, right), edge = start, end - start
        if ahead * edge[1] - right * edge[0] <= 0 or max(ahead, end[0]) <= NEAR_PLANE_M:
            return  # turned away, or behind the eye
        ends = [
            point if point[0] > NEAR_PLANE_M else start + edge * (NEAR_PLANE_M - ahead) / edge[0]
            for point in (start, end)
        ]
        columns = self.view.columns(ends[0][1] / ends[0][0], ends[1][1] / ends[1][0])
        x = self._x[columns]
        share = np.clip((x * ahead - right) / (edge[1] - x * edge[0]), 0.0, 1.0)
        depth = ahead + share * edge[0]
        length = float(np.hypot(*edge))
        if not (depth < self._far[columns]).any():
            return
        texture, scale = self._scenery.furniture(solid, length).level(float(depth.min()) / self.view.focal)
        side = solid.corners[(number + 1) % len(solid.corners)] - solid.corners[number]
        gain = float(shade(math.atan2(-side[0], side[1])))
        self._paint(Patch(columns, depth, share * length, solid.bottom, solid.top, texture, scale, gain), eye)

    def _draw_post(self, solid: Solid, eye: Eye, ahead: float, right: float) -> None:
        away = math.hypot(ahead, right)
        if away <= solid.radius + NEAR_PLANE_M:
            return
        middle, half = math.atan2(right, ahead), math.asin(solid.radius / away)
        if middle + half >= 1.5 or middle - half <= -1.5:
            return
        columns = self.view.columns(math.tan(middle - half), math.tan(middle + half))
        x = self._x[columns]
        towards, square = ahead + x * right, 1 + x * x
        depth = (towards - np.sqrt(np.maximum(towards**2 - square * (away**2 - solid.radius**2), 0.0))) / square
        if not (depth < self._far[columns]).any():
            return
        normal = eye.heading - np.arctan2(x * depth - right, depth - ahead)
        along = (normal % (2 * np.pi)) * solid.radius
        texture = self._scenery.furniture(solid, 2 * np.pi * solid.radius)
        pixels, scale = texture.level(float(depth.min()) / self.view.focal)
        self._paint(Patch(columns, depth, along, solid.bottom, solid.top, pixels, scale), eye)

    def _draw_person(self, thing: Thing, eye: Eye) -> None:
        ahead, right = eye.sees(np.array([[thing.pose.x, thing.pose.y]]))[0]
        if ahead < 0.15:
            return
        side = math.atan2(eye.y - thing.pose.y, eye.x - thing.pose.x) - thing.pose.heading
        drawing = figure(round(side / (2 * np.pi) * VIEW_COUNT), thing.look, thing.gesture, thing.stride)
        scale = PIXELS_PER_METRE * PERSON_HEIGHT_M / thing.height
        half = DRAWING_WIDTH_M / 2 * thing.height / PERSON_HEIGHT_M
        columns = self.view.columns((right - half) / ahead, (right + half) / ahead)
        if not (ahead < self._far[columns]).any():
            return
        along = self._x[columns] * ahead - right + half
        top = DRAWING_HEIGHT_M * thing.height / PERSON_HEIGHT_M
        self._paint(Patch(columns, np.full(len(along), ahead), along, 0.0, top, drawing, scale), eye)

    def _draw_board(self, board: HeldBoard, eye: Eye) -> None:
        seen = see(board, self.view, eye)
        if seen is None:
            return
        area = (seen.rows, seen.columns)
        cover = seen.cover * (seen.depth < self._depth[area])
        picture = self._picture[area]
        panel = cv2.merge([np.round(seen.grey).astype(np.uint8)] * 3)
        picture[:] = cv2.blendLinear(panel, picture, cover, 1 - cover)
        shows = cover > 0.5
        np.copyto(self._depth[area], seen.depth, where=shows)
        self._below[area][shows] = False

    def _draw_underside(self, solid: Solid, eye: Eye, seen: Array) -> None:
        """Draw the underside of a table for an eye below it."""
        rise = solid.bottom - eye.z
        if seen[:, 0].max() <= NEAR_PLANE_M:
            return
        outline = ahead_of(seen, 0.1)
        pixels = np.column_stack(
            (
                self.view.cx + self.view.focal * outline[:, 1] / outline[:, 0],
                self.view.cy - self.view.focal * rise / outline[:, 0],
            )
        )
        mask = np.zeros(self._below.shape, np.uint8)
        cv2.fillConvexPoly(mask, np.round(np.clip(pixels, -4000, 4000) * 16).astype(np.int32), 1, cv2.LINE_8, 4)
        with np.errstate(divide="ignore"):
            depth = np.where(self._y < 0, rise / -self._y, np.inf)[:, None]
        shows = (mask > 0) & (depth < self._depth)
        self._picture[shows] = (82, 104, 122)
        self._below[shows] = False
        np.copyto(self._depth, depth.astype(np.float32), where=shows)

    def _paint(self, patch: Patch, eye: Eye) -> None:
        """Over everything that is farther away, upright and mirrored in the floor."""
        nearest = float(patch.depth.min())
        rows = self.view.rows((eye.z - patch.top) / nearest, (eye.z + patch.top) / nearest)
        if rows.start == rows.stop:
            return
        area = (rows, patch.columns)
        depth = patch.depth.astype(np.float32)
        z = np.float32(eye.z) - self._y[rows, None] * depth[None, :]
        below = z < 0
        z = np.abs(z)
        shows = (z <= patch.top) & (z >= patch.bottom) & (depth < self._depth[area])
        height = (patch.top - z) * np.float32(patch.scale) - np.float32(0.5)
        along = np.broadcast_to((patch.along * patch.scale - 0.5).astype(np.float32), z.shape)
        texture = patch.texture
        colours = cv2.remap(texture, np.ascontiguousarray(along), height, cv2.INTER_LINEAR, borderMode=_EDGE)
        if texture.shape[2] == 4:
            shows &= colours[:, :, 3] > 127
            colours = colours[:, :, :3]
        if patch.gain != 1.0:
            colours = cv2.convertScaleAbs(colours, alpha=patch.gain)
        np.copyto(self._picture[area], colours, where=shows[:, :, None])
        np.copyto(self._depth[area], depth, where=shows)
        np.copyto(self._below[area], below, where=shows)


_SAMPLE = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
_EDGE = cv2.BORDER_REPLICATE


def _runs(values: Array) -> list[tuple[int, int]]:
    cuts = np.flatnonzero(np.diff(values)) + 1
    return list(zip([0, *cuts.tolist()], [*cuts.tolist(), len(values)], strict=True))
