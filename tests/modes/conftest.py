"""Beliefs, frames and small motions made by hand."""

import numpy as np
import pytest

from mobius.geometry import rpy_to_quat
from mobius.model.robot import keyframe, keyframe_joints
from mobius.modes.motions import Motion, Stage
from mobius.types import SensorFrame, StateEstimate

PRONE = keyframe_joints("prone")[0]
CRAWL = keyframe_joints("crawl")[0]


@pytest.fixture
def belief_of():
    """A belief at a pitch and roll [rad], or of a keyframe."""

    def build(t=0.0, *, pitch=0.0, roll=0.0, pose=None, w=(0, 0, 0), v=(0, 0, 0)):
        q = rpy_to_quat(roll, pitch, 0.0) if pose is None else keyframe(pose)[0][3:7]
        return StateEstimate(t, [0, 0, 0.2], q, v, w, np.ones(4))

    return build


@pytest.fixture
def frame_of():
    """A sensor frame with joint angles and rates."""

    def build(t=0.0, q=CRAWL, dq=None):
        zero = np.zeros(22)
        dq = zero if dq is None else dq
        return SensorFrame(t, q, dq, zero, np.zeros((2, 6)), np.zeros(3), [0, 0, 9.81])

    return build


@pytest.fixture
def motion_of():
    """A motion of given stages, crude on purpose."""

    def build(*stages, name="prone_to_crawl", start="prone", end="crawling", **more):
        stages = stages or (Stage(PRONE, 0.1), Stage(CRAWL, 0.1))
        return Motion(name, start, end, tuple(stages), **more)

    return build
