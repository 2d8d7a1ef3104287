"""The closed loop against numpy and Pinocchio, docs/theory/allocation.md, section 1, mirror, rank monitor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from amble.control.motion_equations import SMALLEST_PIVOT
from amble.errors import InputError
from amble.hybrid import Stance
from amble.numerics.bezier import evaluate
from amble.types import Matrix, Vector
from tests.control.loops import Sample, expressions, loop, samples, solved_stances, weights
from tests.oracle import oracle
from tests.robots import robot

STATES = 200
STANCES = solved_stances()

# Accelerations reach 1e4 rad/s^2 at random states, and the condition of the decoupling matrix there is up to 1e4.
TOLERANCE = 1e-9


@pytest.fixture(params=STANCES, ids=[stance.name for stance in STANCES])
def stance(request: pytest.FixtureRequest) -> Stance:
    return request.param


def run(stance: Stance, law: str, sample: Sample, chosen: Matrix) -> tuple[Vector, ...]:
    """Acceleration, torques, forces, pivots, null torques."""
    return tuple(np.asarray(part).ravel() for part in loop(stance.feet, law)(*sample.arguments(chosen)))


def commanded(sample: Sample) -> Vector:
    """y_a'' of the output dynamics, written out."""
    value, rate, second = (part[0] for part in evaluate(sample.references, np.array([sample.t / sample.duration])))
    kp, kd = sample.gains
    rate, second = rate / sample.duration, second / sample.duration**2
    return second - kd * (sample.v[3:] - rate) - kp * (sample.q[3:] - value)


def affine_motion(feet: tuple[str, ...], sample: Sample) -> tuple[Vector, Matrix]:
    """f0 and G of q'' = f0 + G u."""
    free, inputs = affine_response(feet, sample)
    return free[: sample.q.size], inputs[: sample.q.size]


def affine_response(feet: tuple[str, ...], sample: Sample) -> tuple[Vector, Matrix]:
    """(q'', lambda) at zero torque and their slope in the torques, from Pinocchio's terms and one dense solve."""
    model, theirs = robot("astro"), oracle("astro")
    rows = [3 * model.foot_names.index(foot) + axis for foot in feet for axis in range(3)]
    mass, bias = theirs.mass_matrix(sample.q), theirs.bias(sample.q, sample.v)
    jacobian, contact_bias = theirs.jacobian(sample.q)[rows], theirs.jacobian_bias(sample.q, sample.v)[rows]
    system = np.block([[mass, -jacobian.T], [jacobian, np.zeros((len(rows), len(rows)))]])
    inputs = np.zeros((len(system), len(model.joints)))
    inputs[6 : model.size] = np.eye(len(model.joints))
    return np.linalg.solve(system, np.concatenate([-bias, -contact_bias])), np.linalg.solve(system, inputs)


def test_torques_are_those_of_numpys_pseudo_inverse(stance: Stance) -> None:
    chosen = weights(stance)
    for sample, mixed in samples(STATES, seed=1, mixed=True):
        for H in (chosen, mixed):
            assert H is not None
            free, inputs = affine_motion(stance.feet, sample)
            A, r = H @ inputs[3:], H @ (commanded(sample) - free[3:])
            expected = np.linalg.pinv(A) @ r
            acceleration, torques, *_ = run(stance, "pinv", sample, H)
            rounding = 1e-13 * np.linalg.cond(A)  # condition times the rounding of both sides
            np.testing.assert_allclose(torques, expected, atol=rounding * np.abs(expected).max())
            moved = free + inputs @ expected
            np.testing.assert_allclose(acceleration, moved, atol=rounding * np.abs(moved).max())


@pytest.mark.parametrize(
    ("feet", "outputs"),
    [((), 12), (("rl",), 12), (("fl", "rr"), 11), (("fl", "fr", "rl"), 9), (("fl", "fr", "rl", "rr"), 6)],
    ids=["flight", "one", "diagonal", "three", "four"],
)
def test_any_number_of_feet_moves_as_the_pseudo_inverse_does(feet: tuple[str, ...], outputs: int) -> None:
    """With as many outputs as actuated degrees of freedom; torques, motion and forces from Pinocchio and numpy."""
    function, random = loop(feet, "pinv", outputs), np.random.default_rng(outputs)
    for sample, _ in samples(50, seed=9):
        size = sample.q.size
        H = random.normal(size=(outputs, size - 3))
        free, inputs = affine_response(feet, sample)
        A, r = H @ inputs[3:size], H @ (commanded(sample) - free[3:size])
        expected = np.linalg.pinv(A, rcond=1e-12) @ r
        acceleration, torques, forces, *_ = (np.asarray(part).ravel() for part in function(*sample.arguments(H)))
        rounding = 1e-13 * np.linalg.cond(A)
        np.testing.assert_allclose(torques, expected, atol=rounding * np.abs(expected).max())
        moved = free + inputs @ expected
        for ours, theirs in ((acceleration, moved[:size]), (forces, moved[size:])):
            np.testing.assert_allclose(ours, theirs, atol=rounding * np.abs(theirs).max(initial=0.0))


@pytest.mark.parametrize("outputs", [10, 12])
def test_a_wrong_number_of_outputs_is_refused(stance: Stance, outputs: int) -> None:
    with pytest.raises(InputError, match=f"takes exactly 11 outputs, not {outputs}"):
        expressions(stance.feet, "pinv", outputs)


def test_the_output_dynamics_hold_and_so_do_the_equations_of_motion(stance: Stance) -> None:
    model, theirs, chosen = robot("astro"), oracle("astro"), weights(stance)
    rows = [3 * model.foot_names.index(foot) + axis for foot in stance.feet for axis in range(3)]
    for sample, _ in samples(STATES, seed=2):
        acceleration, torques, forces, _, _ = run(stance, "drop", sample, chosen)
        scale = np.abs(acceleration).max()
        np.testing.assert_allclose(chosen @ (acceleration[3:] - commanded(sample)), 0.0, atol=TOLERANCE * scale)
        jacobian = theirs.jacobian(sample.q)[rows]
        balance = theirs.inverse_dynamics(sample.q, sample.v, acceleration) - jacobian.T @ forces
        balance[6:] -= torques
        np.testing.assert_allclose(balance, 0.0, atol=TOLERANCE * np.abs(forces).max())
        contact = jacobian @ acceleration + theirs.jacobian_bias(sample.q, sample.v)[rows]
        np.testing.assert_allclose(contact, 0.0, atol=TOLERANCE * scale)


def test_laws_differ_in_torque_but_not_in_motion(stance: Stance) -> None:
    """docs/theory/allocation.md, eq. 6: with A of full row rank, all u with A u = r cause one acceleration."""
    model, chosen = robot("astro"), weights(stance)
    rear = next(foot for foot in stance.feet if foot.startswith("r"))
    dropped = model.joint_index(f"{rear}_hip_pitch")
    for sample, _ in samples(STATES, seed=3):
        acceleration, smallest, forces, _, null = run(stance, "pinv", sample, chosen)
        same, torques, other_forces, _, _ = run(stance, "drop", sample, chosen)
        np.testing.assert_allclose(same, acceleration, atol=TOLERANCE * np.abs(acceleration).max())
        assert abs(torques[dropped]) <= TOLERANCE * np.abs(torques).max()
        assert np.linalg.norm(smallest) <= np.linalg.norm(torques) * (1.0 + 1e-12)
        difference = torques - smallest
        along = null * (null @ difference) / (null @ null)
        np.testing.assert_allclose(difference, along, atol=TOLERANCE * np.abs(torques).max())
        # the force difference is a force_basis along the line between the feet: no net force
        net = (other_forces - forces).reshape(-1, 3).sum(axis=0)
        np.testing.assert_allclose(net, 0.0, atol=TOLERANCE * np.abs(other_forces).max())


def test_null_torques_cause_no_motion(stance: Stance) -> None:
    for sample, _ in samples(50, seed=4):
        _, inputs = affine_motion(stance.feet, sample)
        null = run(stance, "pinv", sample, weights(stance))[4]
        assert np.linalg.norm(null) > 1e-3
        np.testing.assert_allclose(inputs @ null, 0.0, atol=1e-11 * np.abs(inputs).max() * np.linalg.norm(null))
        assert np.linalg.matrix_rank(inputs, tol=1e-9 * np.abs(inputs).max()) == 11


def test_the_loop_is_symmetric_under_the_mirror(stance: Stance) -> None:
    """The mirrored stance at the mirrored state, with mirrored references, moves as the mirror image."""
    mirror = robot("astro").mirror
    twin = Stance("twin", tuple(foot for foot in robot("astro").foot_names if foot in _twins(stance)))
    swap = mirror.coordinates.matrix[3:, 3:]
    for sample, mixed in samples(50, seed=5, mixed=True):
        assert mixed is not None
        image = Sample(
            mirror.position(sample.q),
            mirror.position(sample.v),
            sample.t,
            sample.duration,
            sample.gains,
            swap @ sample.references,
        )
        ours, theirs = run(stance, "pinv", sample, mixed), run(twin, "pinv", image, mixed @ swap.T)
        scale = TOLERANCE * np.abs(ours[0]).max()
        np.testing.assert_allclose(theirs[0], mirror.position(ours[0]), atol=scale)
        np.testing.assert_allclose(theirs[1], mirror.torque(ours[1]), atol=scale)


def _twins(stance: Stance) -> set[str]:
    return {robot("astro").mirror.feet[foot] for foot in stance.feet}


def test_the_smallest_pivot_tells_a_lost_rank(stance: Stance) -> None:
    """Outputs that leave out a swing joint cannot be decoupled (docs/theory/virtual-constraints.md, eq. 8)."""
    model, sound = robot("astro"), weights(stance)
    swing = next(foot for foot in model.foot_names if foot not in stance.feet)
    coordinates = [j for j in range(len(model.joints)) if j != model.joint_index(f"{swing}_knee")]
    singular = np.eye(model.size - 3)[3:][coordinates]
    for sample, _ in samples(50, seed=6):
        healthy, lost = (run(stance, "pinv", sample, H)[3].min() for H in (sound, singular))
        assert healthy > 1e-3
        assert lost < 1e-9


def test_a_posture_without_rank_has_no_pivot(stance: Stance) -> None:
    """The rear stance leg, whose pitch no output holds, turned until numpy's determinant of the decoupling vanishes.

    There the leg's free joint moves its foot neither towards the other foot nor away, so nothing decides its angle.
    """
    model, H = robot("astro"), weights(stance)
    rear = next(foot for foot in stance.feet if foot.startswith("r"))
    place = 6 + model.joint_index(f"{rear}_hip_pitch")
    sample, _ = next(iter(samples(1, seed=8)))

    def turned(angle: float) -> Sample:
        q = np.array(sample.q)
        q[place] = angle
        return replace(sample, q=q)

    def determinant(angle: float) -> float:
        _, inputs = affine_motion(stance.feet, turned(angle))
        null = run(stance, "pinv", turned(angle), H)[4]
        return float(np.linalg.det(np.vstack([H @ inputs[3:], null])))

    def pivot(angle: float) -> float:
        return float(run(stance, "pinv", turned(angle), H)[3].min())

    angles = sample.q[place] + np.linspace(-np.pi / 2, np.pi / 2, 41)
    signs = np.sign([determinant(angle) for angle in angles])
    changes = np.flatnonzero(signs[1:] != signs[:-1])
    assert changes.size
    for change in changes:
        root = brentq(determinant, angles[change], angles[change + 1], xtol=1e-14)
        assert pivot(root) < SMALLEST_PIVOT
        assert min(pivot(root - 0.01), pivot(root + 0.01)) > 1e3 * SMALLEST_PIVOT


def test_the_smallest_pivot_falls_with_the_smallest_singular_value(stance: Stance) -> None:
    """On the way from some outputs to singular ones both vanish at the same rate."""
    model = robot("astro")
    swing = next(foot for foot in model.foot_names if foot not in stance.feet)
    coordinates = [j for j in range(len(model.joints)) if j != model.joint_index(f"{swing}_knee")]
    singular = np.eye(model.size - 3)[3:][coordinates]
    for sample, mixed in samples(20, seed=7, mixed=True):
        assert mixed is not None
        _, inputs = affine_motion(stance.feet, sample)
        found = []
        for share in (1e-5, 1e-6, 1e-7):
            H = singular + share * mixed
            *_, pivots, null = run(stance, "pinv", sample, H)
            found.append((pivots.min(), np.linalg.svd(np.vstack([H @ inputs[3:], null]), compute_uv=False)[-1]))
        ours, theirs = np.array(found).T
        for values in (ours, theirs):  # linear in the share up to its own size times a condition of 1e3
            np.testing.assert_allclose(values[1:] / values[:-1], 0.1, rtol=0.1)
