"""URDFs: mountings and looks of sound ones, and a sentence for those that are broken or meant to harm."""

import math
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import OPTICAL
from core.robots.device import Base, Equipment
from core.robots.robot_file import load_robot_file, profile_of
from core.robots.urdf import load_body
from core.sensors import Camera
from tests.emulators.ros_messages import PROFILE


def link(name: str, shape: str) -> str:
    return f'<link name="{name}"><visual><geometry><{shape}/></geometry></visual></link>'


def joint(kind: str, parent: str, child: str, origin: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{child}" type="{kind}">{ends}<origin {origin}/></joint>'


GOOD = "".join(
    (
        '<robot name="toy">',
        link("base_link", 'box size="0.2 0.1 0.05"'),
        link("laser", 'cylinder radius="0.03" length="0.04"'),
        link("mast", 'sphere radius="0.02"'),
        link("camera", 'mesh filename="package://toy/meshes/c.stl" scale="2 2 2"'),
        joint("fixed", "base_link", "laser", 'xyz="0.1 0 0.2" rpy="0 0 1.5"'),
        joint("revolute", "base_link", "mast", 'xyz="0 0.1 0.3" rpy="0 0 1.5708"'),
        joint("fixed", "mast", "camera", 'xyz="0.05 0 0"'),
        "</robot>",
    )
)
LASER = PROFILE.lasers[0]
CAMERA = Camera(model=PROFILE.cameras[0].model, name="camera")
ARRAY = replace(PROFILE.arrays[0], name="ears")


def written(folder: Path, text: str) -> Path:
    file = folder / "robot.urdf"
    file.write_text(text, encoding="utf-8")
    return file


def stl(folder: Path) -> None:
    (folder / "meshes").mkdir()
    triangle = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    (folder / "meshes" / "c.stl").write_bytes(bytes(80) + struct.pack("<I", 1) + triangle)


def test_links_and_shapes_are_in_the_robot_s_frame(tmp_path: Path) -> None:
    stl(tmp_path)
    body = load_body(written(tmp_path, GOOD))
    assert np.allclose(body.mounting("camera").translation, [0.0, 0.15, 0.3], atol=1e-5)
    assert len(body.shapes) == 4 and body.notices == ()
    box, cylinder, ball, mesh = body.shapes
    assert np.allclose(np.ptp(box.vertices, axis=0), [0.2, 0.1, 0.05])
    assert np.allclose(np.ptp(cylinder.vertices, axis=0), [0.06, 0.06, 0.04], atol=1e-3)
    assert np.allclose(ball.vertices.mean(axis=0), [0.0, 0.1, 0.3], atol=0.003)
    assert np.allclose(mesh.vertices[1], [0.0, 2.15, 0.3], atol=1e-4)  # 2 m ahead of a link that looks left


def test_sensors_are_mounted_by_link_and_the_body_is_in_the_profile(tmp_path: Path) -> None:
    stl(tmp_path)
    written(tmp_path, GOOD)
    lines = 'urdf="robot.urdf"\n[lasers.laser]\nlink="laser"\n[cameras.camera]\nlink="camera"\n'
    (tmp_path / "robot.toml").write_text(lines + '[microphones.ears]\nlink="mast"\n', encoding="utf-8")
    file = load_robot_file(tmp_path / "robot.toml")
    whole = Equipment(name="x", base=Base(), lasers=(LASER,), cameras=(CAMERA,), microphones=(ARRAY,))
    profile = profile_of((whole,), file, "x:", tmp_path)
    at = profile.lasers[0].mounting
    assert (at.x, at.y, at.heading) == pytest.approx((0.1, 0.0, 1.5)) and profile.lasers[0].height == 0.2
    ahead = profile.cameras[0].mounting.rotation[:, 2]
    assert np.allclose(ahead, [0.0, 1.0, 0.0], atol=1e-5) and OPTICAL[0, 2] == 1.0
    assert profile.arrays[0].height == 0.3 and profile.arrays[0].mounting.heading == pytest.approx(
        math.pi / 2, abs=1e-4
    )
    assert len(profile.shapes) == 4
    written(tmp_path, GOOD.replace('xyz="0.1 0 0.2"', 'xyz="100 0 200"'))
    with pytest.raises(BadInput, match=r"puts laser 100 m .* in metres"):
        profile_of((whole,), _with(tmp_path, 'urdf="robot.urdf"\n[lasers.laser]\nlink="laser"\n'), "x:", tmp_path)
    with pytest.raises(BadInput, match="no link 'nose'"):
        profile_of((whole,), _with(tmp_path, 'urdf="robot.urdf"\n[lasers.laser]\nlink="nose"\n'), "x:", tmp_path)
    with pytest.raises(BadInput, match="but no urdf"):
        profile_of((whole,), _with(tmp_path, '[lasers.laser]\nlink="laser"\n'), "x:", tmp_path)


def _with(folder: Path, text: str):
    (folder / "other.toml").write_text(text, encoding="utf-8")
    return load_robot_file(folder / "other.toml")


JOINT = '<joint name="{0}"><parent link="{1}"/><child link="{2}"/></joint>'
BOMB = '<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;">]><robot name="x"><link name="&b;"/></robot>'
RING = f'<robot><link name="a"/><link name="b"/>{JOINT.format("j", "a", "b")}{JOINT.format("k", "b", "a")}</robot>'
NOT_FINITE = "<robot>" + joint("fixed", "a", "b", 'xyz="1 nan 0"') + "</robot>"
TWICE = f'<robot><link name="a"/><link name="b"/>{JOINT.format("j", "a", "b")}{JOINT.format("k", "a", "b")}</robot>'


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (BOMB, "declares entities"),
        (RING, "round in a circle"),
        (TWICE, "two joints"),
        ("<robot><link", "no XML"),
        ("<sdf/>", "no URDF"),
        ("<robot>" + '<link name="a"/>' * 2001 + "</robot>", "2000 links"),
        (" " * 5_000_001, "too large"),
        ('<robot><link name="a"/><joint><child link="a"/></joint></robot>', "no parent"),
        (NOT_FINITE, "no xyz"),
        ("<robot>" + joint("fixed", "a", "b", 'rpy="0 0 90"') + "</robot>", "by 90 rad.*radians"),
        ('<robot xmlns:xacro="x"><xacro:include filename="a"/></robot>', "is xacro"),
    ],
)
def test_a_urdf_that_is_none_is_refused_with_a_sentence(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(BadInput, match=why):
        load_body(written(tmp_path, text))


@pytest.mark.parametrize(
    ("mesh", "why"),
    [
        ("../../../etc/passwd", "outside the folder"),
        ("file:///etc/passwd", "outside the folder"),
        ("package://toy/../../x.stl", "outside the folder"),
        ("package://toy/meshes/absent.stl", "is not on this computer"),
        ("text.stl", "no binary STL"),
        ("arm.dae", "only binary STL"),
    ],
)
def test_a_mesh_that_cannot_be_shown_is_left_out_with_a_sentence(tmp_path: Path, mesh: str, why: str) -> None:
    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "text.stl").write_text("solid x\nendsolid\n" * 20)
    (folder / "arm.dae").write_text("<COLLADA/>")
    visual = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    body = load_body(written(folder, f'<robot><link name="base_link">{visual}{visual}</link></robot>'))
    assert body.shapes == () and len(body.notices) == 1 and why in body.notices[0]


def test_a_long_chain_of_links_takes_no_time(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{number}"/>' for number in range(2000))
    joints = "".join(JOINT.format(number, f"l{number}", f"l{number + 1}") for number in range(1999))
    assert len(load_body(written(tmp_path, f"<robot>{links}{joints}</robot>")).links) == 2000
