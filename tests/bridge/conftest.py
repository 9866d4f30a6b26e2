import numpy as np
import pytest

from mobius.types import (
    GridMap,
    JointCommand,
    Mode,
    ModeCommand,
    Plan,
    Pose,
    SensorFrame,
    StateEstimate,
)

YAW_90 = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


@pytest.fixture
def nouns():
    """One of every noun, no two numbers alike where a swap could hide."""
    rng = np.random.default_rng(3)
    blocked = np.zeros((3, 2), dtype=bool)
    blocked[2, 0] = True
    cells = np.array([[0, 0], [1, 0], [1, 1]])
    grid = GridMap(
        name="room",
        cell=0.5,
        origin_M=np.array([-1.0, 2.0, 0.25]),
        blocked=blocked,
        allowed=np.full((3, 2), 7, dtype=np.uint8),
    )
    cov = rng.normal(size=(12, 12))
    return {
        "clock": 1.5,
        "frame": SensorFrame(
            stamp=1.5,
            q=rng.normal(size=22),
            dq=rng.normal(size=22),
            torque=rng.normal(size=22),
            wrench_S=rng.normal(size=(2, 6)),
            gyro_I=rng.normal(size=3),
            accel_I=rng.normal(size=3),
            vio=Pose(p=np.array([1.0, 2.0, 3.0]), q=YAW_90),
        ),
        "belief": StateEstimate(
            stamp=1.5,
            p_OB=np.array([0.1, 0.2, 0.3]),
            q_OB=YAW_90,
            v_B=np.array([0.4, 0.5, 0.6]),
            w_B=np.array([0.7, 0.8, 0.9]),
            contact=np.zeros(4),
            cov=cov,
        ),
        "truth": StateEstimate(
            stamp=1.5,
            p_OB=np.array([1.1, 1.2, 1.3]),
            q_OB=YAW_90,
            v_B=np.array([1.4, 1.5, 1.6]),
            w_B=np.array([1.7, 1.8, 1.9]),
            contact=np.zeros(4),
        ),
        "command": ModeCommand(mode=Mode.CRAWL, twist_H=np.array([0.3, -0.1, 0.2]), stamp=1.5),
        "target": JointCommand(q=rng.normal(size=22), stamp=1.5),
        "grid": grid,
        "plan": Plan(
            cells=cells,
            modes=(Mode.CRAWL, Mode.BIPED),
            xy_M=grid.center_of(cells),
            status="optimal",
            objective=2.5,
            bound=2.5,
            solve_s=0.01,
        ),
        "pose_MO": Pose(p=np.array([5.0, 6.0, 0.0]), q=YAW_90),
    }
