"""Both bodies keep one protocol; the simulated one does what its drawing says."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model import JOINTS, joint_index
from mobius.model.dimensions import MIN_CRANK_SPREAD
from mobius.model.robot import keyframe_joints, load_model
from mobius.robot import TICK, GhostRobot, Observable, Robot, limit_targets
from mobius.robot.sim import SimRobot
from mobius.robot.variation import Variation
from mobius.types import JointCommand

STANCE, HOLD = keyframe_joints("crawl")


def make(kind: str):
    if kind == "ghost":
        return GhostRobot(STANCE)
    return SimRobot(load_model("full"))


@pytest.fixture(params=["sim", "ghost"])
def robot(request):
    with make(request.param) as body:
        yield body


def run(body, seconds: float) -> np.ndarray:
    rng, rows = np.random.default_rng(0), []
    for k in range(round(seconds / TICK)):
        if k % 10 == 0:
            body.write(
                JointCommand(HOLD + rng.normal(0, 0.05, 22) * (np.arange(22) < 20), k * TICK)
            )
        body.wait()
        if k % 2 == 1:
            rows.append(body.read().q)
    return np.array(rows)


def test_protocol(robot):
    assert isinstance(robot, Robot) and isinstance(robot, Observable)


@pytest.mark.parametrize("kind", ["sim", "ghost"])
def test_two_runs_are_equal_bit_for_bit(kind):
    np.testing.assert_array_equal(run(make(kind), 1.0), run(make(kind), 1.0))


def test_write_returns_what_the_limits_let_through(robot):
    wild = np.full(22, 9.0)
    sent = robot.write(JointCommand(wild, 0.0)).q
    assert (sent < 9.0).all()
    again = robot.write(JointCommand(sent, 0.0)).q
    np.testing.assert_allclose(again, sent)


def test_limits_keep_the_five_bars_on_their_branch():
    a, b = joint_index("left_hip_motor_a", "left_hip_motor_b")
    q = HOLD.copy()
    q[a], q[b] = 1.0, 1.1
    sent = limit_targets(JointCommand(q, 0.0)).q
    assert sent[b] - sent[a] == pytest.approx(MIN_CRANK_SPREAD)
    assert sent[a] + sent[b] == pytest.approx(2.1)  # both give way by half


def test_vio_ticks_at_200_hz_and_is_none_between(robot):
    robot.read()
    seen = []
    for _ in range(600):
        robot.wait()
        seen.append(robot.read().vio is not None)
    assert sum(seen) == 200


def test_clock_of_frames(robot):
    for _ in range(12):
        robot.wait()
    assert robot.read().stamp == pytest.approx(12 / 600)


def test_standing_imu_feels_gravity():
    body = make("sim")
    for k in range(600):
        if k % 10 == 0:
            body.write(JointCommand(HOLD, k * TICK))
        body.wait()
    frame = body.read()
    np.testing.assert_allclose(frame.accel_I, [0, 0, 9.81], atol=0.15)
    assert body.contact_force().sum() == pytest.approx(10.3 * 9.81, rel=0.02)
    assert body.truth().contact.tolist() == [1, 1, 1, 1]


def test_start_pose():
    body = SimRobot(load_model("full"), xy=(1.5, -2.0), yaw=1.0)
    truth = body.truth()
    np.testing.assert_allclose(truth.p_OB[:2], [1.5, -2.0])
    from mobius.geometry import quat_to_rpy

    assert quat_to_rpy(truth.q_OB)[2] == pytest.approx(1.0)


def test_variation_reaches_the_physics():
    model = load_model("full")
    mass = model.body_subtreemass[1]
    SimRobot(model, variation=Variation(friction=0.5, trunk_mass=1.0, servo_gain=0.9))
    assert model.body_subtreemass[1] == pytest.approx(mass + 1.0)
    soles = [i for i in range(model.ngeom) if "_sole" in model.geom(i).name]
    assert len(soles) == 6
    np.testing.assert_allclose(model.geom_friction[soles, 0], 0.5)
    at = model.actuator("left_hip_yaw").id
    fresh = load_model("full")
    assert model.actuator_gainprm[at, 0] == pytest.approx(0.9 * fresh.actuator_gainprm[at, 0])


def test_delay_holds_targets_back():
    """With 6 ticks of delay the servo sees a new target 6 ticks later, not before."""
    body = SimRobot(load_model("full"), variation=Variation(delay_ticks=6))
    at = body.model.actuator("left_wrist_yaw").id
    q = HOLD.copy()
    q[JOINTS.index("left_wrist_yaw")] = 0.5
    body.write(JointCommand(q, 0.0))
    seen = []
    for _ in range(8):
        body.wait()
        seen.append(body.data.ctrl[at] > 0.4)
    assert seen == [False] * 6 + [True] * 2


def test_walls_are_felt():
    from mobius.model.robot import load_spec

    spec = load_spec("full")
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
    spec.worldbody.add_geom(
        name="wall_0", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 1, 0.3], pos=[0.26, 0, 0.3]
    )
    body = SimRobot(spec.compile())
    largest = 0.0
    for _ in range(60):
        body.wait()
        largest = max(largest, body.obstacle_force())
    assert largest > 5.0


def test_wrong_time_step_is_refused():
    model = load_model("full")
    model.opt.timestep = 0.005
    with pytest.raises(InvalidInput, match="1/600"):
        SimRobot(model)


def test_ghost_goes_where_it_is_driven():
    body = make("ghost")
    body.drive([0.3, 0.0, np.pi / 4])
    for _ in range(1200):
        body.wait()
    truth = body.truth()  # 2 s at 45 deg/s: a quarter circle of radius 0.3 / (pi/4)
    r = 0.3 / (np.pi / 4)
    np.testing.assert_allclose(truth.p_OB[:2], [r, r], atol=2e-3)
