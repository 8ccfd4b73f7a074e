"""A robot's URDF: where its links sit, and what they look like. Joints are taken as they stand at zero.

Of the format only links, joints and visuals are read, by the standard library: a file from outside with entities, a
cycle or a mesh outside its folder ends in a sentence.
"""

import math
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from core.errors import BadInput
from core.files import text_of
from core.geometry import Pose, Transform, rotation_of_rpy
from core.message import Array, message

MAX_URDF_BYTES = 5_000_000  # bytes of a URDF
LARGEST_MESH = 20_000_000  # bytes
MAX_ANGLE_RAD = 6.3  # of rpy: more is degrees
MOST_LINKS = 2000
MOST_SHAPES = 300
MOST_TRIANGLES = 200_000  # of all meshes together
BASES = ("base_footprint", "base_link", "base")
GREY_RGB = (150, 154, 162)
STL_HEAD, STL_TRIANGLE = 84, 50  # bytes


@message
class BodyShape:
    """A part of a robot's body, in the robot's frame: a mesh of triangles."""

    vertices: Array  # (N, 3) float32 [m]
    faces: Array  # (M, 3) int32
    colour: tuple[int, int, int] = GREY_RGB


@message
class Body:
    """The robot's links in its own frame, and its looks."""

    links: dict[str, Transform]  # robot_from_link
    shapes: tuple[BodyShape, ...] = ()
    notices: tuple[str, ...] = ()  # sentences about what is not shown

    def mounting(self, link: str) -> Transform:
        """robot_from_link. Raises BadInput for a link that there is not."""
        if link not in self.links:
            some = ", ".join(sorted(self.links)[:12])
            raise BadInput(f"The URDF has no link {link[:60]!r}; it has {some}.")
        return self.links[link]


def load_body(path: Path) -> Body:
    """Read a URDF, with the meshes beside it. Raises BadInput with a sentence."""
    try:
        if path.stat().st_size > MAX_URDF_BYTES:
            raise _too_large(path.name)
        text = text_of(path.read_bytes(), path.name)
    except (OSError, ValueError):
        raise BadInput(f"The URDF {path.name} cannot be read.") from None
    return parse_body(text, path.name, path.parent)


def parse_body(text: str, name: str, folder: Path | None = None) -> Body:
    """The text of a URDF → the body. Without a folder no meshes are looked for.

    Raises BadInput with a sentence that begins with `name`.
    """
    if len(text) > MAX_URDF_BYTES:
        raise _too_large(name)
    root = _parsed(text, name)
    links = _placed([str(link.get("name")) for link in root.findall("link")], _joints(root, name), name)
    looks = _Looks(folder, links)
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            looks.add(links.get(str(link.get("name"))), visual)
    return Body(links=links, shapes=tuple(looks.shapes), notices=looks.notices)


def _too_large(name: str) -> BadInput:
    return BadInput(f"{name} is too large for a URDF.")


def _parsed(text: str, name: str) -> Element:
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput(f"{name} declares entities, which no URDF needs; it is not read.")
    if "xmlns:xacro" in text and "<xacro:" in text:
        raise BadInput(f"{name} is xacro; make a URDF of it: xacro {name} > robot.urdf")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, RecursionError):
        raise BadInput(f"{name} is no XML.") from None
    if root.tag != "robot" or len(root.findall("link")) > MOST_LINKS:
        raise BadInput(f"{name} is no URDF with up to {MOST_LINKS} links.")
    return root


def _joints(root: Element, name: str) -> dict[str, tuple[str, Transform]]:
    """Child link → its parent, and parent_from_child with the joint at zero."""
    joints: dict[str, tuple[str, Transform]] = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            raise BadInput(f"{name}: the joint {str(joint.get('name'))[:60]!r} has no parent or no child.")
        link = str(child.get("link"))
        if link in joints:
            raise BadInput(f"{name}: the link {link[:60]!r} hangs on two joints.")
        joints[link] = str(parent.get("link")), _origin(joint.find("origin"))
    return joints


def _placed(links: list[str], joints: dict[str, tuple[str, Transform]], name: str) -> dict[str, Transform]:
    """The links in the robot's frame: base_footprint, base_link, or else the root."""
    unit = Transform.of_pose(Pose())
    from_root: dict[str, Transform] = {}
    for link in links:
        chain = [link]
        while chain[-1] in joints and chain[-1] not in from_root:
            chain.append(joints[chain[-1]][0])
            if len(chain) > len(links) + 1:
                raise BadInput(f"{name}: the joints above the link {link[:60]!r} go round in a circle.")
        for one in reversed(chain):
            if one not in from_root:
                parent = joints.get(one)
                from_root[one] = unit if parent is None else from_root[parent[0]] @ parent[1]
    base = next((known for known in BASES if known in from_root), None)
    moved = unit if base is None else from_root[base].inverse()
    return {link: moved @ found for link, found in from_root.items()}


class _Absent(Exception):
    """A mesh that is not on this computer."""


class _Looks:
    """Shapes of a body, as far as they can be shown."""

    def __init__(self, folder: Path | None, links: dict[str, Transform]) -> None:
        self.shapes: list[BodyShape] = []
        self._notices: list[str] = []
        self._absent: list[str] = []  # meshes that are not on this computer
        self._folder, self._links = folder, links
        self._triangles = 0

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences about what is left out; one for all meshes that are not there."""
        if not self._absent:
            return tuple(self._notices)
        first = f"The mesh {self._absent[0][:80]} is not on this computer; that part of the body is not shown."
        several = (
            f"{len(self._absent)} meshes of the robot's body, such as {self._absent[0][:80]}, are not on this "
            "computer; those parts are not shown."
        )
        return (*self._notices, first if len(self._absent) == 1 else several)

    def add(self, robot_from_link: Transform | None, visual: Element) -> None:
        """Take one visual, or say why it is left out."""
        if robot_from_link is None:
            return
        try:
            vertices, faces = self._geometry(visual.find("geometry"))
            placed = robot_from_link @ _origin(visual.find("origin"))
            self._triangles += len(faces)
            if self._triangles > MOST_TRIANGLES or len(self.shapes) >= MOST_SHAPES:
                raise BadInput("Parts of the robot's body are not shown: there are too many.")
        except _Absent as mesh:
            self._absent += [str(mesh)] if str(mesh) not in self._absent else []
            return
        except BadInput as why:
            self._notices += [str(why)] if str(why) not in self._notices else []
            return
        self.shapes.append(
            BodyShape(vertices=placed.apply(vertices).astype(np.float32), faces=faces, colour=_colour(visual))
        )

    def _geometry(self, geometry: Element | None) -> tuple[Array, Array]:
        if geometry is None or len(geometry) != 1:
            raise BadInput("A part of the robot's body has no shape; it is not shown.")
        shape = geometry[0]
        match shape.tag:
            case "box":
                return _box(_numbers(shape, "size", 3))
            case "cylinder":
                return _turned(_numbers(shape, "radius", 1)[0], _numbers(shape, "length", 1)[0])
            case "sphere":
                return _ball(_numbers(shape, "radius", 1)[0])
            case "mesh":
                vertices, faces = self._mesh(str(shape.get("filename", "")))
                scale = _numbers(shape, "scale", 3) if shape.get("scale") else np.ones(3)
                return vertices * scale, faces
            case _:
                raise BadInput(f"A part of the robot's body is a {shape.tag[:30]}, which is not shown.")

    def _mesh(self, name: str) -> tuple[Array, Array]:
        """A binary STL beside the URDF; of `package://NAME/…` the part behind the name, or all of it."""
        if self._folder is None:
            raise _Absent(name)
        folder = self._folder.resolve()
        inside = name.removeprefix("file://").removeprefix("package://")
        candidates = [inside] if not name.startswith("package://") else [inside.partition("/")[2], inside]
        for candidate in candidates:
            file = (folder / candidate).resolve()
            if not file.is_relative_to(folder):
                raise BadInput(f"The mesh {name[:80]} is outside the folder of the URDF; it is not read.")
            if file.is_file():
                return read_stl(file)
        raise _Absent(name)


def read_stl(file: Path) -> tuple[Array, Array]:
    """A binary STL → vertices (N, 3) [as in the file], faces (M, 3). Raises BadInput for anything else."""
    if file.suffix.lower() != ".stl":
        raise BadInput(f"The mesh {file.name} is not shown: only binary STL is read.")
    try:
        if file.stat().st_size > LARGEST_MESH:
            raise BadInput(f"The mesh {file.name} is too large; that part of the body is not shown.")
        raw = file.read_bytes()
    except OSError:
        raise BadInput(f"The mesh {file.name} cannot be read; that part of the body is not shown.") from None
    count = int.from_bytes(raw[80:STL_HEAD], "little")
    if len(raw) < STL_HEAD or len(raw) != STL_HEAD + STL_TRIANGLE * count:
        raise BadInput(f"The mesh {file.name} is no binary STL; that part of the body is not shown.")
    rows = np.frombuffer(raw[STL_HEAD:], np.uint8).reshape(count, STL_TRIANGLE)[:, 12:48]
    corners = np.ascontiguousarray(rows).view("<f4").reshape(-1, 3).astype(float)
    if not np.isfinite(corners).all():
        raise BadInput(f"The mesh {file.name} is not finite; that part of the body is not shown.")
    return corners, np.arange(len(corners), dtype=np.int32).reshape(-1, 3)


def _origin(origin: Element | None) -> Transform:
    """xyz [m] and rpy [rad] of an element `origin`."""
    if origin is None:
        return Transform.of_pose(Pose())
    angles = _numbers(origin, "rpy", 3, "0 0 0").tolist()
    if max(map(abs, angles)) > MAX_ANGLE_RAD:
        raise BadInput(f"The URDF turns by {max(angles, key=abs):g} rad, more than once around: rpy is in radians.")
    return Transform(rotation=rotation_of_rpy(*angles), translation=_numbers(origin, "xyz", 3, "0 0 0"))


def _numbers(element: Element, name: str, count: int, otherwise: str = "") -> Array:
    try:
        numbers = np.array([float(word) for word in str(element.get(name, otherwise)).split()])
    except ValueError:
        numbers = np.zeros(0)
    if len(numbers) != count or not np.isfinite(numbers).all() or np.abs(numbers).max() > 1000:
        raise BadInput(f"The URDF's {element.tag[:30]} has no {name} of {count} numbers.")
    return numbers


def _colour(visual: Element) -> tuple[int, int, int]:
    colour = visual.find("material/color")
    if colour is None:
        return GREY_RGB
    try:
        red, green, blue, _ = np.clip(_numbers(colour, "rgba", 4) * 255, 0, 255).astype(int).tolist()
    except BadInput:
        return GREY_RGB
    return red, green, blue


def _box(size: Array) -> tuple[Array, Array]:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return corners, np.array(faces, np.int32)


def _turned(radius: float, length: float, around: int = 32) -> tuple[Array, Array]:
    """A cylinder about z."""
    angles = np.arange(around) * math.tau / around
    ring = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    low = np.column_stack([ring, np.full(around, -length / 2)])
    high = np.column_stack([ring, np.full(around, length / 2)])
    vertices = np.concatenate([low, high, [[0, 0, -length / 2], [0, 0, length / 2]]])
    faces: list[tuple[int, int, int]] = []
    for here in range(around):
        after = (here + 1) % around
        faces += [(here, after, around + after), (here, around + after, around + here)]
        faces += [(after, here, 2 * around), (around + here, around + after, 2 * around + 1)]
    return vertices, np.array(faces, np.int32)


def _ball(radius: float, around: int = 24, rings: int = 12) -> tuple[Array, Array]:
    up, side = np.meshgrid(np.linspace(0, math.pi, rings + 1), np.arange(around) * math.tau / around, indexing="ij")
    points = np.stack([np.sin(up) * np.cos(side), np.sin(up) * np.sin(side), np.cos(up)], axis=-1).reshape(-1, 3)
    faces: list[tuple[int, int, int]] = []
    for ring in range(rings):
        for here in range(around):
            a, b = ring * around + here, ring * around + (here + 1) % around
            faces += [(a, a + around, b + around), (a, b + around, b)]
    return points * radius, np.array(faces, np.int32)
