"""The planar five-bar: closed form against itself, against published poses, against differences."""

import numpy as np
import pytest

from mobius.model.fivebar import ARM_FIVEBAR, LEG_FIVEBAR, FiveBar

BARS = [ARM_FIVEBAR, LEG_FIVEBAR]


def assembled(bar: FiveBar, n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1.5, 1.5, 6 * n), rng.uniform(0.2, 3.1, 6 * n)
    ok = np.isfinite(bar.fk(a, b)).all(axis=1) & (b - a > 0.70)
    return a[ok][:n], b[ok][:n]


@pytest.mark.parametrize("bar", BARS)
def test_ik_undoes_fk_on_the_assembly_branch(bar):
    a, b = assembled(bar, 2000)
    T = bar.fk(a, b)
    a2, b2 = bar.ik(T[:, 0], T[:, 1])
    np.testing.assert_allclose(a2, a, atol=1e-9)
    np.testing.assert_allclose(b2, b, atol=1e-9)


@pytest.mark.parametrize("bar", BARS)
def test_every_link_keeps_its_length(bar):
    a, b = assembled(bar, 500)
    B, E, C, T = bar.points(a, b)
    for p, q, length in (
        (B, np.zeros(2), bar.L1),
        (E, bar.F, bar.L1),
        (B, C, bar.coupler),
        (E, C, bar.distal_joint),
        (E, T, bar.distal),
    ):
        np.testing.assert_allclose(np.linalg.norm(p - q, axis=1), length, atol=1e-12)


@pytest.mark.parametrize("bar", BARS)
def test_jacobian_matches_finite_differences(bar):
    a, b = assembled(bar, 300)
    e = 1e-6
    numeric = np.stack(
        [
            (bar.fk(a + e, b) - bar.fk(a - e, b)) / (2 * e),
            (bar.fk(a, b + e) - bar.fk(a, b - e)) / (2 * e),
        ],
        axis=-1,
    )
    J = bar.jacobian(a, b)
    np.testing.assert_allclose(J, numeric, atol=1e-6 * (1 + np.abs(J).max()))
    rate = np.stack(
        [
            (bar.distal_angle(a + e, b) - bar.distal_angle(a - e, b)) / (2 * e),
            (bar.distal_angle(a, b + e) - bar.distal_angle(a, b - e)) / (2 * e),
        ],
        axis=-1,
    )
    np.testing.assert_allclose(bar.distal_rate(a, b), rate, atol=1e-6 * (1 + np.abs(rate).max()))


def test_published_reference_poses():
    """q = [0, 0.4, 1.23]: arm 243.8/232.2 mm, leg 251.9/244.7, 256.6/241.4, 261.4/237.8 mm."""
    np.testing.assert_allclose(1e3 * ARM_FIVEBAR.fk(0.4, 1.23), [243.8, 232.2], atol=0.1)
    for w, want in ((28.5, [251.9, 244.7]), (31.0, [256.6, 241.4]), (33.5, [261.4, 237.8])):
        got = 1e3 * FiveBar(L1=0.130, w=1e-3 * w).fk(0.4, 1.23)
        np.testing.assert_allclose(got, want, atol=0.1)  # printed to 0.1 mm, some cut off


def test_out_of_reach_is_nan_not_a_pose():
    q11, q21 = ARM_FIVEBAR.ik(0.6, 0.6)
    assert np.isnan(q11) and np.isnan(q21)
    assert np.isnan(ARM_FIVEBAR.fk(1.444, 1.697)).all()  # the crank pins meet


def test_hand_computed_square():
    """Cranks level, w = 0: A = F and B = E, so C lies where two circles about one point meet.

    With q11 = q21 the two pins coincide and no assembly exists (distal and coupler differ).
    """
    bar = FiveBar(L1=0.1, w=0.0, coupler=0.1, distal_joint=0.1, distal=0.2, offset=0.0)
    # q11 = 0 (down), q21 = 90 deg (out): B = (.1, 0), E = (0, .1); C = (.1, .1) closes a square
    _B, _E, C, T = bar.points(0.0, np.pi / 2)
    np.testing.assert_allclose(C, [0.1, 0.1], atol=1e-12)
    np.testing.assert_allclose(T, [0.2, 0.1], atol=1e-12)  # twice as far along E-C
