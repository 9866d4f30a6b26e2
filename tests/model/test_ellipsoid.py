"""The leg's design claim: a limb's velocity ellipsoid, and MOBIUS against SCALER."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model.dimensions import limb_geometry
from mobius.model.ellipsoid import (
    Ellipsoid,
    design_claims,
    limb_ellipsoid,
    limb_jacobian,
)
from mobius.model.fivebar import LEG_FIVEBAR
from mobius.paper import LEG_DESIGN

LEG_X_OFF = limb_geometry("right_leg").x_off


def foot(q: np.ndarray) -> np.ndarray:
    """Position (3,) of the ankle, written out once more: outward, sideways, up."""
    down, out = LEG_FIVEBAR.fk(q[1], q[2])
    rho = LEG_X_OFF + out
    return np.array([rho * np.cos(q[0]), rho * np.sin(q[0]), -down])


@pytest.mark.parametrize("q", [(0.0, 0.4, 1.23), (0.7, -0.3, 1.5), (-1.2, 0.1, 2.0)])
def test_the_jacobian_is_the_derivative_of_the_foot_position(q):
    q, h = np.array(q), 1e-6
    columns = [(foot(q + h * e) - foot(q - h * e)) / (2 * h) for e in np.eye(3)]
    J = limb_jacobian(LEG_FIVEBAR, q, x_off=LEG_X_OFF)
    np.testing.assert_allclose(J, np.stack(columns, axis=-1), atol=1e-9)


def test_the_jacobian_is_vectorised_over_a_batch():
    q = np.array([[0.0, 0.4, 1.23], [0.5, -0.2, 1.4]])
    J = limb_jacobian(LEG_FIVEBAR, q, x_off=LEG_X_OFF)
    assert J.shape == (2, 3, 3)
    one = limb_jacobian(LEG_FIVEBAR, q[1], x_off=LEG_X_OFF)
    np.testing.assert_allclose(J[1], one, rtol=1e-13, atol=1e-15)  # rounded otherwise in vectors


def test_yaw_turns_the_ellipsoid_and_does_not_change_it():
    at_0 = limb_ellipsoid(LEG_FIVEBAR, (0.0, 0.4, 1.23), x_off=LEG_X_OFF)
    at_1 = limb_ellipsoid(LEG_FIVEBAR, (1.0, 0.4, 1.23), x_off=LEG_X_OFF)
    assert at_1.axes == pytest.approx(at_0.axes)


def test_condition_volume_and_product_by_hand():
    # axes 8, 4, 2: condition 4, product 64, volume sqrt(64) = 8
    ellipsoid = Ellipsoid((8.0, 4.0, 2.0))
    assert (ellipsoid.condition, ellipsoid.product, ellipsoid.volume) == (4.0, 64.0, 8.0)


def test_the_leg_makes_the_velocity_ellipsoid_19_percent_larger():
    claims = design_claims()
    assert claims.volume_change == pytest.approx(0.191, abs=5e-4)
    assert round(claims.volume_change, 2) == LEG_DESIGN.ellipsoid_volume


def test_the_leg_makes_the_condition_number_24_percent_smaller():
    claims = design_claims()
    assert claims.scaler.condition == pytest.approx(7.016, abs=1e-3)
    assert claims.mobius.condition == pytest.approx(5.357, abs=1e-3)
    assert claims.condition_change == pytest.approx(-0.236, abs=5e-4)
    assert round(claims.condition_change, 2) == LEG_DESIGN.condition_number


def test_the_geometric_volume_grows_more_than_the_printed_measure():
    claims = design_claims()
    assert claims.product_change == pytest.approx((1 + claims.volume_change) ** 2 - 1)
    assert claims.product_change == pytest.approx(0.418, abs=5e-4)


def test_wider_leg_servos_cost_part_of_the_gain():
    wide = design_claims(w=LEG_FIVEBAR.w)
    assert wide.mobius.condition == pytest.approx(5.778, abs=1e-3)
    assert -0.24 < wide.condition_change < -0.17
    assert 0.15 < wide.volume_change < 0.19


def test_a_pose_that_cannot_be_closed_is_refused():
    # cranks apart by 130 + 28.5 + 130 = 288.5 mm, coupler and distal link reach 278.4 mm
    with pytest.raises(InvalidInput, match="cannot be closed at q = "):
        design_claims((0.0, np.pi, 0.0))


def test_a_pose_of_the_wrong_length_is_refused():
    with pytest.raises(InvalidInput, match=r"expected shape \(..., 3\), got \(2,\)"):
        limb_jacobian(LEG_FIVEBAR, (0.4, 1.23), x_off=0.0)
