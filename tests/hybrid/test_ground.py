"""Ground: its frame and gap as laws, planes against closed forms, height fields against planes, symmetries, names."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.hybrid import FLAT, GROUNDS, Ground, HeightField, Plane

ROUNDING = 1e-14


def waves(x: ca.SX, y: ca.SX) -> ca.SX:
    return 0.1 * ca.sin(2.0 * x + 0.3) + 0.05 * ca.cos(3.0 * y) * x


GROUNDS_TO_TRY: dict[str, Ground] = {
    "flat": FLAT,
    "uphill": Plane(slope=0.2),
    "across": Plane(slope=0.3, heading=1.1),
    "waves": HeightField(function=waves),
}


@pytest.fixture(params=GROUNDS_TO_TRY)
def ground(request: pytest.FixtureRequest) -> Ground:
    return GROUNDS_TO_TRY[request.param]


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(0).uniform(-1.0, 1.0, (40, 3))


def test_the_frame_is_a_rotation_whose_first_tangent_lies_over_x(ground: Ground, points: np.ndarray) -> None:
    frames = ground.frame(points)
    np.testing.assert_allclose(np.swapaxes(frames, 1, 2) @ frames, np.tile(np.eye(3), (40, 1, 1)), atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=ROUNDING)
    np.testing.assert_allclose(frames[:, 1, 0], 0.0, atol=0.0)
    assert np.all(frames[:, 0, 0] > 0.0)


def test_the_normal_is_the_gradient_of_height_by_differences(ground: Ground, points: np.ndarray) -> None:
    x, y, step = points[:, 0], points[:, 1], 1e-6
    slopes = [
        (ground.height(x + step, y) - ground.height(x - step, y)) / (2.0 * step),
        (ground.height(x, y + step) - ground.height(x, y - step)) / (2.0 * step),
    ]
    expected = np.stack([-slopes[0], -slopes[1], np.ones_like(x)], axis=1)
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(ground.normal(points), expected, atol=1e-8)  # third derivatives of size 1 times step^2


def test_casadi_and_numpy_agree(ground: Ground, points: np.ndarray) -> None:
    p = ca.SX.sym("p", 3)
    parts = [ground.gap(p), ground.frame(p), ground.normal(p), ground.height(p[0], p[1])]
    function = ca.Function("ground", [p], parts)
    gaps, frames, normals = ground.gap(points), ground.frame(points), ground.normal(points)
    for k, point in enumerate(points):
        gap, frame, normal, height = (np.asarray(part.full()) for part in function(point))
        np.testing.assert_allclose(gap.ravel(), gaps[k], atol=ROUNDING)
        np.testing.assert_allclose(frame, frames[k], atol=ROUNDING)
        np.testing.assert_allclose(normal.ravel(), normals[k], atol=ROUNDING)
        np.testing.assert_allclose(height.ravel(), ground.height(point[0], point[1]), atol=ROUNDING)
        np.testing.assert_allclose(ground.frame(point), frames[k], atol=0.0)


def test_level_ground_leaves_expressions_as_they_are() -> None:
    p = ca.SX.sym("p", 3)
    for level in (FLAT, Plane(heading=1.0, friction=0.3)):
        assert level.level
        assert str(level.gap(p)) == "p_2"
        assert ca.is_equal(ca.SX(level.frame(p)).T @ p, p, 1)
        assert float(level.height(3.0, -2.0)) == 0.0


def test_the_gap_to_a_plane_is_its_distance(points: np.ndarray) -> None:
    """Against the plane spanned by the fall line and the level line, by a cross product."""
    slope, heading = 0.4, -0.7
    plane = Plane(slope=slope, heading=heading)
    rising = np.array([np.cos(slope) * np.cos(heading), np.cos(slope) * np.sin(heading), np.sin(slope)])
    across = np.array([-np.sin(heading), np.cos(heading), 0.0])
    np.testing.assert_allclose(plane.gap(points), points @ np.cross(rising, across), atol=ROUNDING)
    assert plane.gap(2.0 * rising + 3.0 * across + 0.25 * np.cross(rising, across)) == pytest.approx(0.25, abs=ROUNDING)


def test_a_height_field_that_is_a_plane_equals_the_plane(points: np.ndarray) -> None:
    plane = Plane(slope=0.25, heading=0.5)
    along_x, along_y = plane.gradient
    field = HeightField(function=lambda x, y: along_x * x + along_y * y)
    np.testing.assert_allclose(field.gap(points), plane.gap(points), atol=ROUNDING)
    np.testing.assert_allclose(field.frame(points), plane.frame(points), atol=ROUNDING)


@pytest.mark.parametrize("plane", [FLAT, Plane(slope=0.2), Plane(slope=0.3, heading=1.1)])
def test_translations_of_a_plane_keep_every_gap(plane: Plane, points: np.ndarray) -> None:
    assert list(plane.translations) == ["x", "y"]
    for place, along in enumerate(plane.translations.values()):
        assert along[place] == 1.0
        np.testing.assert_allclose(plane.gap(points + 0.7 * along), plane.gap(points), atol=ROUNDING)


def test_what_claims_the_mirror_is_mirrored(points: np.ndarray) -> None:
    image = points * [1.0, -1.0, 1.0]
    for plane in (FLAT, Plane(slope=0.2), Plane(slope=-0.2), Plane(slope=0.2, heading=np.pi)):
        assert plane.mirrored
        np.testing.assert_allclose(plane.gap(image), plane.gap(points), atol=ROUNDING)
    assert not Plane(slope=0.2, heading=0.1).mirrored
    assert not HeightField(function=waves).mirrored
    assert HeightField(function=waves, symmetric=True).mirrored


def test_grounds_are_values() -> None:
    assert Plane(slope=0.1) == Plane(slope=0.1)
    assert hash(Plane(slope=0.1)) == hash(Plane(slope=0.1))
    assert Plane(slope=0.1) != Plane(slope=0.1, friction=0.5)


@pytest.mark.parametrize(
    ("parameters", "says"),
    [
        ({"friction": 0.0}, "friction coefficient is 0"),
        ({"friction": float("nan")}, "friction coefficient is nan"),
        ({"friction": 1e308}, r"friction coefficient is 1e\+308; it goes up to"),
        ({"friction": "0.6"}, "friction coefficient is '0.6', not a number"),
        ({"slope": 1.6}, "below a right angle"),
        ({"heading": float("inf")}, "heading of the ground is inf"),
        ({"tilt": 0.1}, "unknown parameter of ground 'plane' 'tilt'"),
    ],
)
def test_impossible_ground_is_refused(parameters: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        GROUNDS.build("plane", parameters)


def test_ground_is_rebuilt_from_its_name() -> None:
    plane = Plane(slope=0.1, heading=0.2, friction=0.7)
    tree = GROUNDS.encode(plane, "file")
    units = {"friction": (0.7, "1"), "slope": (0.1, "rad"), "heading": (0.2, "rad")}
    written = {name: {"value": value, "unit": unit} for name, (value, unit) in units.items()}
    assert tree == {"name": "plane", "parameters": written}
    assert GROUNDS.decode(tree, "file") == plane
    with pytest.raises(UnknownNameError, match="unknown ground 'moon'; known: plane"):
        GROUNDS.build("moon", {})


def test_a_function_cannot_be_written() -> None:
    with pytest.raises(InputError, match="ground 'height field' cannot be written to a file: register a class"):
        GROUNDS.encode(HeightField(function=waves), "file")
    with pytest.raises(InputError, match="another ground of the name 'plane'"):
        GROUNDS.register("plane", HeightField)
