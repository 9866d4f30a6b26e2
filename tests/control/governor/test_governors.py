import subprocess
import sys

import numpy as np
import pytest

from mobius.control.governor import (
    CommandGovernor,
    Constraints,
    LinearSystem,
    NearestGovernor,
    ScalarGovernor,
    algorithm_3,
    axis_system,
    exact_set,
)
from mobius.control.governor.sampled_loop import algorithm_3_loop
from mobius.control.governor.sampled_set import TIGHTEN, grid_of
from mobius.errors import InvalidInput

LAG = LinearSystem([[0.5]], [[0.5]], [[1.0]])


@pytest.fixture(params=["scalar", "command"])
def make(request):
    if request.param == "command":
        pytest.importorskip("daqp")
    return {"scalar": ScalarGovernor, "command": CommandGovernor}[request.param]


def bang(axis, rows, make, *, k_env=100.0, seconds=6.0):
    """Largest output over its limit while the reference jumps beyond every limit."""
    governor, s, x, worst = make(rows), axis_system(axis, k_env), np.zeros(4), 0.0
    limits = np.array([axis.position_max, axis.velocity_max, axis.wrench_max])
    for k in range(round(seconds / axis.dt)):
        r = [1.4 * axis.position_max * (1 if (k // 25) % 2 else -1), 0.2 * axis.wrench_max]
        v = governor.step(x, r)
        assert governor.verdict.ok
        worst = max(worst, float((np.abs(s.output(x, v)[:3]) / limits).max()))
        x = s.step(x, v)
    return worst


def test_a_governed_axis_uses_its_limits_and_keeps_them(axis, axis_rows, make):
    assert 0.6 < bang(axis, axis_rows, make) <= 1.0


def test_without_a_governor_the_same_reference_breaks_them(axis, axis_rows):
    class Nothing:
        verdict = type("", (), {"ok": True})

        def __init__(self, rows):
            pass

        def step(self, x, r):
            return np.array(r)

    assert bang(axis, axis_rows, Nothing) > 1.5


def test_kappa_by_hand():
    """|v| <= 0.98 is the only row that a step from 0 to 2 approaches: kappa = 0.49."""
    governor = ScalarGovernor(exact_set(LAG, Constraints.box([-1], [1]), tolerance=0.0))
    assert governor.step([0.0], [2.0]) == pytest.approx([0.98])
    assert governor.verdict.kappa == pytest.approx([0.49])


def test_kappa_is_the_largest_that_stays_inside(axis_rows):
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, (200, 4)) * [0.03, 0.1, 5.0, 0.03]
    v = np.zeros((200, 2))
    r = rng.uniform(-1, 1, (200, 2)) * [0.2, 40.0]
    inside = axis_rows.contains(x, v)
    kappa = axis_rows.fraction(x, v, r)
    on = axis_rows.contains(x, v + (kappa[:, None] - 1e-9) * r)
    beyond = axis_rows.contains(x, v + (kappa[:, None] + 1e-6) * r)
    assert inside.any()
    assert on[inside].all()
    assert not beyond[inside & (kappa < 1)].any()
    assert (kappa[~inside] == 0).all()


def test_an_admissible_wish_passes_to_the_last_bit(axis_rows, make):
    governor = make(axis_rows)
    wish = np.array([0.0123456789, 0.3])
    assert (governor.step(np.zeros(4), wish) == wish).all()


def test_constant_wishes_are_reached_if_they_are_admissible(axis, axis_rows, make):
    governor, s, x = make(axis_rows), axis_system(axis, 100.0), np.zeros(4)
    wish = np.array([0.9 * axis_rows.steady_range([1.0, 0.0]), 0.0])
    for _ in range(600):
        v = governor.step(x, wish)
        x = s.step(x, v)
    assert (v == wish).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_holds_the_last_reference(axis_rows, make, bad):
    governor = make(axis_rows)
    last = governor.step(np.zeros(4), [0.01, 0.0])
    assert (governor.step([0.0, bad, 0.0, 0.0], [0.02, 0.0]) == last).all()
    assert governor.verdict.invalid
    assert (governor.step(np.zeros(4), [bad, 0.0]) == last).all()
    assert not governor.verdict.ok
    assert governor.step(np.zeros(4), [0.02, 0.0])[0] == 0.02
    assert governor.verdict.ok


def test_a_state_that_nobody_assumed_holds_and_says_so(axis, axis_rows, make):
    governor = make(axis_rows)
    last = governor.step(np.zeros(4), [0.01, 0.0])
    x = np.array([0.0, 2.0 * axis.velocity_max, 0.0, 0.0])
    assert (governor.step(x, [0.02, 0.0]) == last).all()
    assert list(governor.verdict.outside) == [True]
    assert not governor.verdict.invalid


def test_several_axes_are_governed_as_each_alone(axis_rows, make):
    lone = [make(axis_rows) for _ in range(3)]
    together = make([axis_rows] * 3)
    rng = np.random.default_rng(0)
    for _ in range(5):
        x, r = rng.uniform(-1, 1, (3, 4)) * [0.02, 0.05, 1, 0.02], rng.uniform(-0.2, 0.2, (3, 2))
        each = np.stack([g.step(a, b) for g, a, b in zip(lone, x, r, strict=True)])
        assert together.step(x, r) == pytest.approx(each, abs=1e-9)


def test_arrays_of_the_wrong_size_are_refused(axis_rows, make):
    with pytest.raises(InvalidInput, match=r"x: expected shape \(4,\), got \(3,\)"):
        make(axis_rows).step(np.zeros(3), np.zeros(2))
    with pytest.raises(InvalidInput, match=r"r: expected shape \(2, 2\)"):
        make([axis_rows] * 2).step(np.zeros((2, 4)), np.zeros(2))
    with pytest.raises(InvalidInput, match="at least one set"):
        make([])


def test_begin_where_the_loop_is(axis_rows, make):
    governor = make(axis_rows)
    x = np.array([0.03, 0.0, 0.0, 0.03])
    assert axis_rows.contains(x, governor.reset(x))
    with pytest.raises(InvalidInput, match="not admissible from the state"):
        governor.reset(x, [-0.3, 0.0])
    with pytest.raises(InvalidInput, match="no reference is admissible"):
        governor.reset([1.0, 0.0, 0.0, 1.0])


def test_the_command_governor_gives_up_no_more_than_the_scalar_one():
    """Two lags side by side: a wish that only one cannot follow costs the other nothing."""
    pytest.importorskip("daqp")
    two = LinearSystem(0.5 * np.eye(2), 0.5 * np.eye(2), np.eye(2))
    rows = exact_set(two, Constraints.box([-1, -1], [1, 1]), tolerance=0.0)
    assert ScalarGovernor(rows).step([0, 0], [2.0, 0.5]) == pytest.approx([0.98, 0.245])
    command = CommandGovernor(rows, weights=[1.0, 1.0])
    assert command.step([0, 0], [2.0, 0.5]) == pytest.approx([0.98, 0.5])
    with pytest.raises(InvalidInput, match="weights"):
        CommandGovernor(rows, weights=[1.0, -1.0])


def test_all_samples_at_once_are_the_loop_as_printed(axis):
    grid = grid_of(axis, (5, 3, 5, 3, 3))
    loop = algorithm_3_loop(axis, grid.points())
    fast = algorithm_3(axis, grid)
    assert 0 < len(loop) < len(grid.points())
    assert fast.points == pytest.approx(loop, abs=1e-15)


def test_in_print_the_propagated_state_is_stored_and_repaired_the_sample(axis):
    grid = grid_of(axis, (9, 5, 9, 3, 3))
    samples = {tuple(p) for p in grid.points()}
    assert not any(tuple(p) in samples for p in algorithm_3(axis, grid).points[::7])
    kept = algorithm_3(axis, grid, repaired=True)
    assert all(tuple(p) in samples for p in kept.points[::7])
    limit = (1 - TIGHTEN) * np.array([axis.position_max, axis.wrench_max])
    assert (np.abs(kept.points[:, [0, 3]]) <= limit).all()


def test_sampling_gives_back_an_admissible_wish_and_holds_where_there_is_no_sample(axis):
    governor = NearestGovernor(algorithm_3(axis, grid_of(axis, (9, 5, 9, 3, 3)), repaired=True))
    assert (governor.step(np.zeros(3), [0.01, 0.1]) == [0.01, 0.1]).all()
    assert 0.0 < governor.step(np.zeros(3), [9.0, 0.0])[0] < axis.position_max
    last = governor.v
    assert (governor.step([9.0, 0.0, 0.0], [0.0, 0.0]) == last).all()
    assert governor.verdict.outside.all()


def test_the_printed_look_up_moves_even_an_admissible_wish(axis):
    governor = NearestGovernor(algorithm_3(axis, grid_of(axis, (9, 5, 9, 3, 3))))
    given = governor.step(np.zeros(3), [0.0123, 0.0])
    assert given[0] != 0.0123
    assert np.isfinite(given).all()


def test_a_grid_without_an_admissible_sample_is_refused(axis):
    with pytest.raises(InvalidInput, match="none of 1 samples"):
        from dataclasses import replace

        grid = replace(grid_of(axis, (1, 1, 1, 1, 1)), x_ref=np.array([5.0]))
        algorithm_3(axis, grid)
    with pytest.raises(InvalidInput, match="counts"):
        grid_of(axis, (1, 2))


def test_the_room_alone_loads_numpy_and_scipy_only():
    code = (
        "import sys, mobius.control.governor;"
        "print({m.split('.')[0] for m in sys.modules} & {'mujoco', 'onnxruntime', 'torch', 'daqp'})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
