"""The GOAT gripper's linkage: loops close, mirror, balance, and the singular closed hand."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.goat import STROKE, Goat

GOAT = Goat()


def test_the_example_pose_by_hand():
    """L = 105 mm, theta = 0, step by step in mm: |BD| = 38.83; C = B + 24.59 u(-0.101) = (140.5,
    34.8); G = C + 10 u(0.776) = (147.6, 41.8); |IG| = 49.2; H = I + 43.41 u(1.413) = (122.8,
    46.9); M = H + (25.31 + 17.75) u(-0.205) = (165.0, 38.1).
    """
    M, N = GOAT.tips(0.105)
    np.testing.assert_allclose(M, [0.1650, 0.0381], atol=2e-4)
    np.testing.assert_allclose(N, M * [1, -1], atol=1e-15)


def test_tilting_the_other_way_swaps_the_fingers():
    M, N = GOAT.tips(0.100, 0.05)
    M2, N2 = GOAT.tips(0.100, -0.05)
    np.testing.assert_allclose(M, N2 * [1, -1], atol=1e-15)
    np.testing.assert_allclose(N, M2 * [1, -1], atol=1e-15)
    assert M[1] > -N[1], "towards M the tilt opens M and closes N"


def test_opening_grows_over_the_stroke_and_length_inverts_it():
    lengths = np.linspace(*STROKE, 50)
    openings = [GOAT.opening(L) for L in lengths]
    assert (np.diff(openings) > 0).all()
    for opening in (0.0, 0.003, 0.03, 0.08, 0.13):
        assert GOAT.opening(GOAT.length(opening)) == pytest.approx(opening, abs=1e-4)


def test_forces_do_the_actuators_work_and_leave_the_tilt_in_balance():
    """For any virtual move (dL, dtheta): thrust dL = sum of n_k times the way finger k opens."""
    for L, theta in ((0.09, 0.0), (0.105, 0.04), (0.12, -0.08)):
        n = GOAT.finger_forces(60.0, L, theta)
        J = GOAT.jacobian(L, theta)
        np.testing.assert_allclose(n @ J, [60.0, 0.0], atol=1e-9)


def test_a_centred_object_is_pinched_equally():
    n = GOAT.finger_forces(60.0, GOAT.length(0.03))
    assert n[0] == pytest.approx(n[1]) and n[0] > 0


def test_closed_the_hand_is_singular_and_open_it_gives_way():
    """Sec. III-E: "reach singularity when fully closed", from the published lengths alone."""
    give = [abs(GOAT.jacobian(GOAT.length(w))[0, 1]) for w in (0.0022, 0.03, 0.08)]
    assert give[0] < 1e-3 and give[1] > 0.03 and give[2] > 0.1
    with pytest.raises(InvalidInput, match="singular"):
        GOAT.finger_forces(60.0, GOAT.length(0.0022))


def test_lengths_out_of_reach_are_refused():
    with pytest.raises(InvalidInput, match="cannot be assembled"):
        GOAT.tips(0.20)
    with pytest.raises(InvalidInput, match="0 to 136 mm"):
        GOAT.length(0.2)
