"""What the joints let through of a command."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mobius.model import LIMB_JOINTS
from mobius.model.build import joint_ranges
from mobius.model.dimensions import MIN_CRANK_SPREAD
from mobius.model.joints import JOINTS
from mobius.types import JointCommand

Array = NDArray[np.float64]

_RANGES = joint_ranges()
LOW, HIGH = np.array([_RANGES[j] for j in JOINTS]).T
_A = np.array([s.start + 1 for s in LIMB_JOINTS.values()])
"""Top cranks; the bottom crank is the next joint."""


def limit_targets(command: JointCommand) -> JointCommand:
    """Clip targets to the joint ranges and keep the five-bars on their assembly branch.

    Where the bottom crank would come closer than 0.70 rad to the top crank, both give way
    by half.
    """
    q = np.clip(command.q, LOW, HIGH)
    lack = np.maximum(MIN_CRANK_SPREAD - (q[_A + 1] - q[_A]), 0.0)
    if lack.any():
        q[_A] -= 0.5 * lack
        q[_A + 1] += 0.5 * lack
        q = np.clip(q, LOW, HIGH)
    return JointCommand(q=q, stamp=command.stamp)
