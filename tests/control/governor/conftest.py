import numpy as np
import pytest

from mobius.control.governor import Axis, LinearSystem, axis_set

COARSE = Axis(dt=0.02, environment=(0.0, 300.0))
"""Our axis at 50 Hz: the same laws, a sixth of the rows' steps."""


@pytest.fixture(scope="session")
def axis():
    return COARSE


@pytest.fixture(scope="session")
def axis_rows():
    return axis_set(COARSE, tolerance=0.02)


@pytest.fixture(scope="session")
def loop():
    """A mass on a spring, damped by half, at 20 Hz; outputs position and speed."""
    dt, w = 0.05, 3.0
    A = np.array([[1.0, dt], [-dt * w**2, 1.0 - dt * w]])
    return LinearSystem(A, [[0.0], [dt * w**2]], np.eye(2), E=[[0.0], [dt]], F=np.zeros((2, 1)))
