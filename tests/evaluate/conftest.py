"""Readings made by hand: 300 looks a second at two feet and 20 joints."""

import numpy as np
import pytest

from mobius.evaluate.gauge import Readings


def build_readings(contact: np.ndarray, **changes) -> Readings:
    """Readings (n, f) of contacts given as 0 and 1; the rest still and at stance height."""
    n, f = contact.shape
    columns = dict(
        tick=2 * np.arange(n),
        force=50.0 * contact,
        slide=np.zeros((n, f)),
        dq=np.zeros((n, 20)),
        torque=np.zeros((n, 20)),
        p=np.zeros((n, 3)),
        height=np.full(n, 0.3),
        stance=0.3,
        stall=np.full(20, 10.0),
        slope=np.full(20, 2.0),
    )
    return Readings(**{**columns, **changes})


@pytest.fixture
def readings():
    return build_readings
