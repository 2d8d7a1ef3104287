"""Looks of links: files are read alike whatever their format, primitives have their size, links their place."""

from __future__ import annotations

import logging
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Robot, load_robot
from amble.types import NodeValues
from amble.view import mesh_files, meshes
from amble.view.mesh_files import read_mesh
from amble.view.meshes import MOST, link_meshes

CORNERS = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
TETRAHEDRON = CORNERS[FACES]

COLLADA = """<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="0.001"/>
<up_axis>{axis}</up_axis></asset><library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">{points}</float_array></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<{kind} count="4"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#p" offset="1"/>
{counts}<p>{corners}</p></{kind}></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>0 0 1000</translate>
<node><matrix>1 0 0 0 0 1 0 0 0 0 1 -1000 0 0 0 1</matrix><instance_geometry url="#g"/></node></node></visual_scene>
</library_visual_scenes></COLLADA>"""


def numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.9g}" for value in np.ravel(values))


def collada(kind: str, axis: str = "Z_UP") -> str:
    corners = np.stack([FACES, np.zeros_like(FACES)], axis=-1)
    counts = "<vcount>3 3 3 3</vcount>" if kind == "polylist" else ""
    return COLLADA.format(axis=axis, points=numbers(1e3 * CORNERS), kind=kind, counts=counts, corners=numbers(corners))


def binary_stl() -> bytes:
    facets = [struct.pack("<12fH", 0, 0, 0, *facet.ravel(), 0) for facet in TETRAHEDRON]
    return b"solid, some writers say".ljust(80) + struct.pack("<I", 4) + b"".join(facets)


def text_stl() -> str:
    facets = [" ".join(f"vertex {numbers(corner)}" for corner in facet) for facet in TETRAHEDRON]
    return "solid t\n" + "\n".join(f"facet normal 0 0 1 outer loop {each} endloop endfacet" for each in facets)


def obj() -> str:
    lines = [f"v {numbers(corner)}" for corner in CORNERS]
    return "\n".join([*lines, *("f " + " ".join(f"{corner + 1}/1/1" for corner in face) for face in FACES)])


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", binary_stl()),
        ("b.STL", text_stl().encode()),
        ("c.obj", obj().encode()),
        ("d.dae", collada("triangles").encode()),
        ("e.dae", collada("polylist").encode()),
    ],
)
def test_every_format_holds_the_same_solid(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    np.testing.assert_allclose(read_mesh(tmp_path / name), TETRAHEDRON, atol=1e-7)


def test_collada_with_y_up_is_turned_about_x(tmp_path: Path) -> None:
    (tmp_path / "y.dae").write_text(collada("triangles", "Y_UP"), encoding="utf-8")
    x, y, z = np.moveaxis(TETRAHEDRON, -1, 0)
    # the scene's translations cancel along the file's own third axis, so only the turn is left
    np.testing.assert_allclose(read_mesh(tmp_path / "y.dae"), np.stack([x, -z, y], axis=-1), atol=1e-7)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", b"ply"),
        ("a.stl", b"solid nothing"),
        ("b.obj", b"f 1 2 3"),
        ("c.dae", b"<COLLADA"),
        ("d.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3"),
        ("e.stl", b"vertex 1 2 x"),
    ],
)
def test_what_is_no_mesh_is_refused(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match="mesh file '"):
        read_mesh(tmp_path / name)


TRIANGLE = (
    '<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>',
    '<vcount>{0} {0} {0} {1}</vcount><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>',
)
MESH = (
    '<geometry id="g"><mesh><source id="s"><float_array>0 0 0 1 0 0 0 1 0</float_array></source><vertices id="v">'
    '<input semantic="POSITION" source="#s"/></vertices>{}</mesh></geometry>'
)


def scene(nodes: str, parts: str = f"<triangles>{TRIANGLE[0]}</triangles>") -> str:
    """A Collada file of one mesh, its parts, and nodes, of which n0 is placed."""
    return (
        f"<COLLADA><library_geometries>{MESH.format(parts)}</library_geometries><library_nodes>{nodes}</library_nodes>"
        '<library_visual_scenes><visual_scene><instance_node url="#n0"/></visual_scene></library_visual_scenes>'
        "</COLLADA>"
    )


TWICE = '<node id="n{}"><instance_node url="#n{}"/><instance_node url="#n{}"/></node>'
BOMBS = {
    "nodes.dae": (scene("".join(TWICE.format(n, n + 1, n + 1) for n in range(40)) + '<node id="n40"/>'), "elements"),
    "itself.dae": (scene(TWICE.format(0, 0, 0)), "elements|nested more than"),
    "lists.dae": (scene('<node id="n0"/>', f"<triangles>{TRIANGLE[0]}</triangles>" * 51), "lists of corners"),
    "counts.dae": (scene("", f"<polylist>{TRIANGLE[1].format(2**62, 2**62 + 3)}</polylist>"), "do not add up"),
    "fan.obj": ("v 0 0 0\nf" + " 1" * 1_500_001, "more than 1500000 triangles"),
    "long.obj": ("#" * (16 * 2**20 + 1), "text of more than 16 MB"),
    "long.stl": ("#" * (16 * 2**20 + 1), "text of more than 16 MB"),
    "long.dae": ("#" * (16 * 2**20 + 1), "text of more than 16 MB"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_mesh_takes_no_more_work_than_it_may(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty nodes, each of which places the next one twice, were walked for ever."""
    monkeypatch.setattr(mesh_files, "MOST_PARTS", 50)
    text, says = BOMBS[name]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=says):
        read_mesh(tmp_path / name)


def test_looks_are_counted_over_all_links(loaded: tuple[Robot, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(meshes, "MOST_OF_ROBOT", 20)
    with pytest.raises(InputError, match="its looks have more than 20 triangles"):
        link_meshes(*loaded)


LINK = """<link name="{name}"><inertial><mass value="1"/><origin xyz="0 0 0"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>{visual}</link>"""
JOINT = """<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{at}" rpy="{turn}"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>"""


def visual(shape: str, at: str = "0 0 0", turn: str = "0 0 0") -> str:
    return f'<visual><origin xyz="{at}" rpy="{turn}"/><geometry>{shape}</geometry></visual>'


def hopper(folder: Path, hip: str = "0 0 -0.1") -> Path:
    """A base, a leg below a joint, and a cap on a fixed joint of the leg."""
    looks = {
        "body": visual('<box size="0.4 0.2 0.1"/>', "0.05 0 0") + visual('<mesh filename="package://mine/t.stl"/>'),
        "leg": visual('<cylinder radius="0.02" length="0.3"/>', "0 0 -0.15"),
        "cap": visual('<sphere radius="0.03"/>') + visual('<mesh filename="gone.stl"/>'),
    }
    joints = [
        JOINT.format(name="hip", kind="revolute", parent="body", child="leg", at=hip, turn="0 0 0"),
        JOINT.format(name="end", kind="fixed", parent="leg", child="cap", at="0 0 -0.3", turn="1.2 0.3 0"),
    ]
    links = [LINK.format(name=name, visual=look) for name, look in looks.items()]
    (folder / "mine" / "urdf").mkdir(parents=True, exist_ok=True)
    (folder / "mine" / "t.stl").write_bytes(binary_stl())
    path = folder / "mine" / "urdf" / "hopper.urdf"
    path.write_text(f"<robot name='hopper'>{''.join(links + joints)}</robot>", encoding="utf-8")
    return path


@pytest.fixture
def loaded(tmp_path: Path) -> tuple[Robot, Path]:
    path = hopper(tmp_path)
    return load_robot(path, feet={"foot": "cap"}), path


def test_links_look_as_their_file_says(loaded: tuple[Robot, Path], caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        body, leg = link_meshes(*loaded)
    assert "1 looks are left out: mesh file" in caplog.text
    assert (body.link, leg.link) == (0, 1)
    np.testing.assert_allclose(body.vertices.min(axis=0), [-0.15, -0.1, -0.05], atol=1e-3)
    np.testing.assert_allclose(body.vertices.max(axis=0), [0.3, 0.2, 0.1], atol=1e-3)
    # the cap's sphere, whatever its turn, ends 3 cm below the leg's end; 16 sides of the rings miss the radius by 2 %
    np.testing.assert_allclose(leg.vertices[:, 2].min(), -0.33, atol=1e-3)
    np.testing.assert_allclose(np.abs(leg.vertices[:, :2]).max(), 0.03, atol=1e-3)


@pytest.mark.parametrize("address", ["package://[mine/t.stl", f"package://mine/{'n' * 300}.stl", "http://[x/t.stl"])
def test_an_address_that_is_none_is_left_out(address: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = hopper(tmp_path)
    path.write_text(path.read_text().replace("package://mine/t.stl", address))
    with caplog.at_level(logging.WARNING):
        assert link_meshes(load_robot(path, feet={"foot": "cap"}), path)
    assert "2 looks are left out" in caplog.text


def test_another_robot_is_refused(loaded: tuple[Robot, Path], tmp_path: Path) -> None:
    robot, _ = loaded
    with pytest.raises(InputError, match=r"is not the file of robot 'hopper': joint 'hip' is elsewhere"):
        link_meshes(robot, hopper(tmp_path / "other", hip="0 0 -0.2"))
    named = replace(robot, links=(replace(robot.links[0], name="trunk"), *robot.links[1:]))
    with pytest.raises(InputError, match=r"there is no link 'trunk'"):
        link_meshes(named, hopper(tmp_path))


def test_a_fine_mesh_keeps_its_shape_with_few_faces(loaded: tuple[Robot, Path]) -> None:
    robot, path = loaded
    path.write_text(path.read_text(encoding="utf-8").replace("t.stl", "ball.obj"), encoding="utf-8")
    (path.parents[1] / "ball.obj").write_text(_ball(60), encoding="utf-8")
    body = link_meshes(robot, path)[0]
    assert 100 < len(body.faces) <= MOST
    assert body.faces.max() < len(body.vertices)
    reach = np.linalg.norm(body.vertices, axis=1).max()
    assert reach == pytest.approx(1.0, abs=0.15)


def _ball(count: int) -> str:
    up, around = np.meshgrid(np.linspace(-1.5, 1.5, count), np.linspace(0.0, 2.0 * np.pi, count), indexing="ij")
    points = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1).reshape(-1, 3)
    corners: NodeValues = np.arange(count * count).reshape(count, count)
    quads = np.stack([corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=-1).reshape(-1, 4)
    lines = [f"v {numbers(point)}" for point in points]
    return "\n".join([*lines, *("f " + " ".join(str(corner + 1) for corner in quad) for quad in quads)])
