"""Rays against upright surfaces, all rays and all surfaces at once."""

import numpy as np

from core.message import Array, message

ORIGIN_MARGIN_M = 0.1  # how far the origins of one cast may lie apart and still share the choice of surfaces


@message
class Surfaces:
    """The surfaces at one height: straight faces and round posts."""

    faces: Array  # (F, 4): x0 y0 x1 y1 [m], the open side on the left
    posts: Array  # (P, 3): x y radius [m]


@message
class Hits:
    """The ends of rays."""

    distance: Array  # (N,) in lengths of the ray's direction; inf: nothing hit
    surface: Array  # (N,) int: face, or len(faces) + post; -1: nothing hit
    along: Array  # (N,) [m] along the face, or around the post from +x; NaN: nothing hit
    cosine: Array  # (N,) of the angle of incidence, 1 = head on; NaN: nothing hit


def cast(origins: Array, directions: Array, surfaces: Surfaces, reach: float = np.inf) -> Hits:
    """Rays from `origins` ((2,) or (N, 2) [m], at most MARGIN apart) along `directions` (N, 2) → where they end.

    Surfaces farther than `reach` [m] may be left out. Faces are seen only from their open side.
    """
    count = len(directions)
    origins = np.broadcast_to(origins, (count, 2))
    here = origins[count // 2]
    faces = _facing(surfaces.faces, here, reach)
    posts = np.flatnonzero(
        np.hypot(*(surfaces.posts[:, :2] - here).T) - surfaces.posts[:, 2] < reach + ORIGIN_MARGIN_M
    )
    table = np.vstack(
        (
            np.full((1, count), np.inf),
            _face_distances(origins, directions, surfaces.faces[faces]),
            _post_distances(origins, directions, surfaces.posts[posts]),
        )
    )
    index = np.concatenate(([-1], faces, posts + len(surfaces.faces)))
    nearest = table.argmin(axis=0)
    distance = table[nearest, np.arange(count)]
    surface = index[nearest]
    along, cosine = _where_on(origins, directions, distance, surface, surfaces)
    return Hits(distance=distance, surface=surface, along=along, cosine=cosine)


def _facing(faces: Array, here: Array, reach: float) -> Array:
    """Indices of the faces that turn their open side to `here` and come within `reach`."""
    start, edge = faces[:, :2], faces[:, 2:] - faces[:, :2]
    length = np.hypot(edge[:, 0], edge[:, 1])
    to_here = here - start
    side = (edge[:, 0] * to_here[:, 1] - edge[:, 1] * to_here[:, 0]) / length
    facing = side > -ORIGIN_MARGIN_M
    if np.isfinite(reach):
        share = np.clip(np.einsum("ij,ij->i", to_here, edge) / length**2, 0.0, 1.0)
        gap = to_here - share[:, None] * edge
        facing &= np.hypot(gap[:, 0], gap[:, 1]) < reach + ORIGIN_MARGIN_M
    return np.flatnonzero(facing)


def _face_distances(origins: Array, directions: Array, faces: Array) -> Array:
    """(F, N): how far each ray goes to each face; inf where it misses."""
    edge = faces[:, 2:] - faces[:, :2]
    normal = np.column_stack((-edge[:, 1], edge[:, 0]))  # to the open side, as long as the face
    offset = np.einsum("ij,ij->i", normal, faces[:, :2])
    closing = normal @ directions.T  # negative: the ray runs against the open side
    turn = directions[:, 0] * origins[:, 1] - directions[:, 1] * origins[:, 0]
    share = faces[:, 1:2] * directions[:, 0] - faces[:, 0:1] * directions[:, 1] - turn
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (offset[:, None] - normal @ origins.T) / closing
    # The hit lies on the face where 0 <= share / closing <= 1; both are negative.
    distance[(closing >= 0) | (share > 0) | (share < closing) | (distance <= 0)] = np.inf
    return distance


def _post_distances(origins: Array, directions: Array, posts: Array) -> Array:
    """(P, N): how far each ray goes to each post; inf where it misses or starts inside."""
    gap_x = posts[:, 0:1] - origins[:, 0]
    gap_y = posts[:, 1:2] - origins[:, 1]
    square = np.einsum("ij,ij->i", directions, directions)
    middle = (gap_x * directions[:, 0] + gap_y * directions[:, 1]) / square
    outside = gap_x**2 + gap_y**2 - posts[:, 2:3] ** 2
    with np.errstate(invalid="ignore"):
        distance = middle - np.sqrt(middle**2 - outside / square)
    return np.where((distance > 0) & (outside > 0), distance, np.inf)


def _where_on(
    origins: Array, directions: Array, distance: Array, surface: Array, surfaces: Surfaces
) -> tuple[Array, Array]:
    """Place along the surface (N,) [m] and cosine of incidence (N,) for the hits."""
    along, cosine = np.full(len(distance), np.nan), np.full(len(distance), np.nan)
    length = np.hypot(directions[:, 0], directions[:, 1])
    on_face = (surface >= 0) & (surface < len(surfaces.faces))
    on_post = surface >= len(surfaces.faces)
    point = origins[on_face] + distance[on_face, None] * directions[on_face]
    face = surfaces.faces[surface[on_face]]
    edge = face[:, 2:] - face[:, :2]
    edge /= np.hypot(edge[:, 0], edge[:, 1])[:, None]
    along[on_face] = np.einsum("ij,ij->i", point - face[:, :2], edge)
    across = edge[:, 1] * directions[on_face, 0] - edge[:, 0] * directions[on_face, 1]
    cosine[on_face] = across / length[on_face]
    post = surfaces.posts[surface[on_post] - len(surfaces.faces)]
    normal = origins[on_post] + distance[on_post, None] * directions[on_post] - post[:, :2]
    along[on_post] = (np.arctan2(normal[:, 1], normal[:, 0]) % (2 * np.pi)) * post[:, 2]
    cosine[on_post] = -np.einsum("ij,ij->i", normal, directions[on_post]) / (post[:, 2] * length[on_post])
    return along, cosine


def distances(point: Array, surfaces: Surfaces) -> Array:
    """Point (2,) [m] → its distance (F + P,) [m] from every surface; negative inside a post."""
    start, edge = surfaces.faces[:, :2], surfaces.faces[:, 2:] - surfaces.faces[:, :2]
    to_point = point - start
    share = np.clip(np.einsum("ij,ij->i", to_point, edge) / np.einsum("ij,ij->i", edge, edge), 0.0, 1.0)
    gap = to_point - share[:, None] * edge
    to_post = surfaces.posts[:, :2] - point
    return np.concatenate(
        (np.hypot(gap[:, 0], gap[:, 1]), np.hypot(to_post[:, 0], to_post[:, 1]) - surfaces.posts[:, 2])
    )
