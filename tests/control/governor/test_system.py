import numpy as np
import pytest

from mobius.control.governor import Axis, Constraints, Disturbance, LinearSystem, axis_system
from mobius.control.governor.plant import SERVO_LAG, with_margin
from mobius.errors import InvalidInput


def test_the_steady_state_stays(loop):
    x = loop.steady_state @ [0.7]
    assert loop.step(x, np.array([0.7])) == pytest.approx(x)
    assert loop.output(x, np.array([0.7]))[0] == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"A": [[1.0]]}, "spectral radius 1"),
        ({"A": [[-1.2]]}, "spectral radius 1.2"),
        ({"A": [[0.5, 0.0]]}, "square"),
        ({"A": [[np.nan]]}, "finite"),
        ({"B": [[1.0], [1.0]]}, "LinearSystem.B: expected a matrix 1 x any"),
        ({"C": [[1.0, 0.0]]}, "LinearSystem.C: expected a matrix any x 1"),
        ({"D": [[1.0, 2.0]]}, "LinearSystem.D"),
        ({"E": [[1.0], [2.0]]}, "LinearSystem.E"),
        ({"B": "no"}, "numbers"),
    ],
)
def test_a_loop_that_cannot_be_governed_is_refused(change, said):
    good = {"A": [[0.5]], "B": [[0.5]], "C": [[1.0]]}
    with pytest.raises(InvalidInput, match=said):
        LinearSystem(**{**good, **change})


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        ([0.0], [1.0], "zero strictly inside"),
        ([1.0], [2.0], "zero strictly inside"),
        ([1.0], [-1.0], "low < high"),
        ([-1.0, -1.0], [1.0], "one length"),
        ([-1.0], [np.nan], "low < high"),
    ],
)
def test_limits_without_room_are_refused(low, high, said):
    with pytest.raises(InvalidInput, match=said):
        Constraints.box(low, high)


def test_an_infinite_limit_is_no_row():
    assert len(Constraints.box([-1.0, -np.inf], [1.0, 2.0]).h) == 3


def test_a_box_is_the_hull_of_its_corners():
    rows = np.random.default_rng(0).normal(size=(5, 2))
    corners = Disturbance(np.array([[a, b] for a in (-0.1, 0.1) for b in (-0.3, 0.3)]))
    assert Disturbance.box([0.1, 0.3]).support(rows) == pytest.approx(corners.support(rows))
    with pytest.raises(InvalidInput, match="half widths"):
        Disturbance.box([-0.1])


def test_an_axis_is_the_law_of_eq_22_step_by_step():
    """One step by hand, damping implicit, both integrals apart, the servo exact."""
    a, k_env = Axis(), 200.0
    x, v, z_x, z_f, x_s, x_ref, W_ref, d = 0.02, 0.1, 0.003, 0.4, 0.015, 0.05, 3.0, 1.5
    W = -k_env * x_s + d
    force = a.force_gain * (W - W_ref) + a.integral_force * z_f - a.stiffness * (x - x_ref)
    force -= a.integral_position * z_x
    v1 = (v + a.dt * force / a.mass) / (1.0 + a.dt * a.damping / a.mass)
    x1 = x + a.dt * v1
    z_x1, z_f1 = z_x + a.dt * (x - x_ref), z_f + a.dt * (W - W_ref)
    x_s1 = x1 + (x_s - x1) * np.exp(-a.dt / SERVO_LAG)
    z, z1 = (a.integral_force * f - a.integral_position * p for p, f in ((z_x, z_f), (z_x1, z_f1)))
    loop = axis_system(a, k_env)
    state, ref, push = np.array([x, v, z, x_s]), np.array([x_ref, W_ref]), np.array([d])
    assert loop.step(state, ref, push) == pytest.approx([x1, v1, z1, x_s1], rel=1e-12)
    assert loop.output(state, ref, push) == pytest.approx([x_s, v, W, x_ref, W_ref])


def test_at_rest_position_and_force_compromise():
    """K_Ix (x - x_ref) = K_If (W - W_ref), Sec. V-G4; 1000 (x - 0.03) = 1 (-200 x) by hand."""
    rest = axis_system(Axis(), 200.0).steady_state @ [0.03, 0.0]
    assert rest[[0, 3]] == pytest.approx([0.025, 0.025])


def test_gains_that_are_unstable_in_contact_are_refused_with_the_stiffness():
    with pytest.raises(InvalidInput, match=r"axis x at 50000 N/m: .* stable"):
        axis_system(Axis(), 50_000.0)


@pytest.mark.parametrize(
    "wrong", [{"mass": 0.0}, {"damping": -1.0}, {"dt": np.nan}, {"environment": (5.0, 1.0)}]
)
def test_an_axis_with_impossible_numbers_is_refused(wrong):
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        Axis(**wrong)


def test_a_margin_tightens_all_three_limits():
    tight = with_margin(Axis(), 0.1)
    assert (tight.position_max, tight.velocity_max, tight.wrench_max) == pytest.approx(
        (0.09, 0.36, 36.0)
    )
    each = with_margin(Axis(), (0.3, 0.5, 0.0))
    assert (each.position_max, each.velocity_max, each.wrench_max) == pytest.approx((0.07, 0.2, 40))
    for bad in (1.0, (0.1, 0.2), (0.1, 0.2, float("nan")), (0.1, -0.2, 0.3)):
        with pytest.raises(InvalidInput, match="margin"):
            with_margin(Axis(), bad)
