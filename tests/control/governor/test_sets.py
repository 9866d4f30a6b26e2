import numpy as np
import pytest

from mobius.control.governor import (
    AdmissibleSet,
    Axis,
    Constraints,
    Disturbance,
    EmptySet,
    LinearSystem,
    axis_set,
    axis_system,
    exact_set,
    family_set,
)
from mobius.control.governor.redundancy import Bound, Pruner, support, symmetric_half
from mobius.errors import InvalidInput, MobiusError

UNIT = Constraints.box([-1.0, -1.0], [1.0, 1.0])


def test_a_row_outside_the_hull_of_the_others_is_kept_and_one_inside_is_not():
    square = np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]])
    pruner = Pruner(np.ones(2), 0.0)
    # x + y <= 2 touches a corner only and x / 2 <= 1 nothing at all
    taken = pruner.add(np.vstack([square, [[0.5, 0.5], [0.5, 0.0]]]))
    assert sorted(taken) == [0, 1, 2, 3]
    assert pruner.implies(np.array([0.5, 0.5]))
    assert not pruner.implies(np.array([0.6, 0.6]))


def test_certificates_agree_with_the_linear_program():
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(40, 4)) * [1, 10, 0.1, 1]
    pruner = Pruner(np.abs(rows).max(axis=0), 0.0)
    pruner.add(rows)
    for row in rng.normal(size=(40, 4)) * [0.6, 6, 0.06, 0.6]:
        assert pruner.implies(row) == (support(rows, row) <= 1 + 1e-9)
    bound = Bound(pruner.rows)
    assert bound.finite
    assert all(bound(c) >= support(rows, c) - 1e-9 for c in rng.normal(size=(10, 4)))


def test_what_is_pruned_is_implied_up_to_the_tolerance():
    angles = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    pruner = Pruner(np.ones(2), 0.02)
    pruner.add(circle)
    assert len(pruner.rows) < 40
    assert max(support(pruner.rows, c) for c in circle) <= 1.02 + 1e-9
    half = Pruner(np.ones(2), 0.02, symmetric=True)
    half.add(circle[:100])
    assert max(support(half.rows, c) for c in circle) <= 1.02 + 1e-9


def test_pairs_of_rows_are_found():
    assert list(symmetric_half(UNIT.H, UNIT.h)) == [0, 1]
    assert symmetric_half(UNIT.H, np.array([1.0, 1, 2, 1])) is None


def test_the_set_of_a_first_order_lag_by_hand():
    """x+ = (x + v) / 2, |x| <= 1: every later x is between x and v, so |x| <= 1, |v| <= 0.98."""
    lag = LinearSystem([[0.5]], [[0.5]], [[1.0]])
    rows = exact_set(lag, Constraints.box([-1], [1]), tolerance=0.0)
    assert rows.contains([[1.0], [1.0], [-1.0]], [[0.98], [-0.98], [0.98]]).all()
    assert not rows.contains([[1.001], [0.0]], [[0.0], [0.981]]).any()
    assert (rows.sizes[0], rows.loss) == (4, 0.0)
    assert rows.steady_range([1.0]) == pytest.approx(0.98)


def test_a_bounded_disturbance_takes_its_share_by_hand():
    """x+ = (x + v) / 2 + w, |w| <= 0.1: w may add up to 0.1 / (1 - 0.5) = 0.2."""
    lag = LinearSystem([[0.5]], [[0.5]], [[1.0]], E=[[1.0]])
    unit = Constraints.box([-1], [1])
    rows = exact_set(lag, unit, disturbance=Disturbance.box([0.1]), tolerance=0.0)
    assert rows.steady_range([1.0]) == pytest.approx(0.98 * 0.8, rel=1e-6)
    with pytest.raises(EmptySet, match=r"disturbance alone breaks limit 0"):
        exact_set(lag, unit, disturbance=Disturbance.box([0.6]))


@pytest.mark.parametrize("tolerance", [0.0, 0.01])
def test_the_set_is_exactly_what_rolls_out_within_limits(loop, tolerance):
    limits = Constraints.box([-1.0, -2.0], [1.0, 2.0])
    rows = exact_set(loop, limits, tolerance=tolerance, epsilon=1e-3)
    rng = np.random.default_rng(0)
    x, v = rng.uniform(-1, 1, (2000, 2)) * [1.2, 2.4], rng.uniform(-1.1, 1.1, (2000, 1))
    good, at = np.abs(v[:, 0]) <= 1.0, x
    for _ in range(300):
        y = loop.output(at, v)
        good &= (np.abs(y) <= [1.0, 2.0]).all(axis=1)
        at = loop.step(at, v)
    inside = rows.contains(x, v)
    assert good[inside].all()
    # no smaller than declared: what rolls out well is in the set blown up by its loss
    blown = 1.0 + rows.loss + 2e-3
    assert rows.contains(x[good] / blown, v[good] / blown).all()
    assert 0.1 < inside.mean() < 0.9


def test_the_set_is_not_left_while_the_reference_is_held(loop):
    box, dist = Constraints.box([-1, -2], [1, 2]), Disturbance.box([0.5])
    rows = exact_set(loop, box, disturbance=dist, tolerance=0.0)
    rng = np.random.default_rng(0)
    x, v = rng.uniform(-1, 1, (3000, 2)) * [1, 2], rng.uniform(-1, 1, (3000, 1))
    inside = rows.contains(x, v)
    assert inside.any()
    after = loop.step(x, v, rng.choice([-0.5, 0.5], (3000, 1)))[inside]
    assert rows.slack(after, v[inside]).min() > -1e-9


def test_jumping_stiffness_never_leads_out_of_the_limits(axis, axis_rows):
    """From states of the set with the reference held, worst of random jumps and forces."""
    rng = np.random.default_rng(3)
    reach = [axis.position_max, axis.velocity_max, 80.0, axis.position_max]
    x, v = rng.uniform(-1, 1, (60_000, 4)) * reach, rng.uniform(-1, 1, (60_000, 2)) * [0.1, 20.0]
    inside = axis_rows.contains(x, v)
    x, v = x[inside], v[inside]
    assert len(x) > 100
    ends = [axis_system(axis, k) for k in (0.0, 150.0, 300.0)]
    limits = np.array([axis.position_max, axis.velocity_max, axis.wrench_max])
    which = rng.integers(0, 3, len(x))
    for t in range(150):
        if t % 25 == 0:
            which = np.where(rng.random(len(x)) < 0.5, rng.integers(0, 3, len(x)), which)
        w = axis.disturbance * np.where(x[:, 3:] >= 0, 1.0, -1.0)
        y = np.choose(which[:, None], [s.output(x, v, w)[:, :3] for s in ends])
        assert (np.abs(y) <= limits + 1e-9).all()
        x = np.choose(which[:, None], [s.step(x, v, w) for s in ends])


def test_the_common_set_of_constant_stiffnesses_is_left_but_not_that_of_the_family(axis, axis_rows):
    """Why a family is not the intersection of its members: z wound up in the air breaks limits in
    contact. States in both sets of one stiffness each can leave one of them under the other."""
    dist = Disturbance.box([axis.disturbance])
    from mobius.control.governor.plant import constraints_of

    low, high = (axis_system(axis, k) for k in axis.environment)
    sets = [exact_set(s, constraints_of(axis), disturbance=dist) for s in (low, high)]
    rng = np.random.default_rng(4)
    reach = [axis.position_max, axis.velocity_max, 80.0, axis.position_max]
    x, v = rng.uniform(-1, 1, (60_000, 4)) * reach, rng.uniform(-1, 1, (60_000, 2)) * [0.1, 20.0]
    common = sets[0].contains(x, v) & sets[1].contains(x, v)
    after = low.step(x[common], v[common])
    assert sets[1].slack(after, v[common]).min() < -sets[1].loss - 1e-3
    ours = axis_rows.contains(x, v)
    assert axis_rows.slack(low.step(x[ours], v[ours]), v[ours]).min() > -axis_rows.loss


def test_a_family_of_one_is_refused_and_a_fixed_stiffness_is_an_exact_set(axis):
    def family(k):
        return axis_system(axis, k)

    with pytest.raises(InvalidInput, match="low < high"):
        family_set(family, (1.0, 1.0), UNIT)
    with pytest.raises(InvalidInput, match="columns"):
        family_set(family, (0.0, 1.0), UNIT)
    assert axis_set(Axis(dt=0.02, environment=(50.0, 50.0))).loss < 0.02


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"epsilon": 0.0}, "epsilon"),
        ({"tolerance": -0.1}, "tolerance"),
        ({"disturbance": Disturbance.box([0.1, 0.1])}, "disturbance"),
    ],
)
def test_numbers_out_of_range_are_refused(loop, change, said):
    with pytest.raises(InvalidInput, match=said):
        exact_set(loop, UNIT, **change)


def test_limits_that_miss_a_direction_are_refused_not_taken_for_safe():
    """Two lags, only one of them limited: the other may be anywhere."""
    two = LinearSystem(np.diag([0.5, 0.6]), np.eye(2), [[1.0, 0.0]])
    with pytest.raises(InvalidInput, match="unbounded"):
        exact_set(two, Constraints.box([-1], [1]))


def test_a_set_that_is_not_determined_in_time_says_what_to_change(loop):
    with pytest.raises(MobiusError, match=r"not determined after 10 steps; raise epsilon"):
        exact_set(loop, UNIT, max_steps=10, epsilon=1e-6)


def test_infeasible_limits_of_an_axis_are_named():
    with pytest.raises(EmptySet, match="disturbance"):
        axis_set(Axis(dt=0.02, wrench_max=1.0, disturbance=2.0))


def test_a_set_survives_a_file(tmp_path, axis_rows):
    axis_rows.save(tmp_path / "a.npz")
    again = AdmissibleSet.load(tmp_path / "a.npz")
    assert (again.G_x == axis_rows.G_x).all()
    assert again.as_json() == axis_rows.as_json()
    np.save(tmp_path / "array.npy", np.zeros(3))
    for k, broken in enumerate((b"no", b"", b"PK\x03\x04 half a file")):
        (tmp_path / f"{k}.npz").write_bytes(broken)
    for name in ("0.npz", "1.npz", "2.npz", "array.npy"):
        with pytest.raises(InvalidInput, match="saved admissible set"):
            AdmissibleSet.load(tmp_path / name)
