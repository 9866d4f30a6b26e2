"""A pinch on a bar in physics: holds inside its limit surface, slips and breaks outside, and
never gives energy.
"""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.model.gripper import finger_tips, pinch_angle
from mobius.model.hand import load_hand
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.model.limit_surface import LimitSurface
from mobius.model.robot import (
    configuration,
    joint_limits,
    keyframe,
    keyframe_joints,
    load_model,
    load_spec,
    passive_angles,
)
from mobius.robot.grasp import DAMPING_TIME, HOOK, STIFFNESS, PinchGrasp
from mobius.robot.pull_rig import PullRig
from mobius.robot.sim import SimRobot
from mobius.types import JointCommand
from mobius.world.bar import Bar, add_bar, build_bar_scene

WIDTH = Bar().width


@pytest.fixture(scope="module")
def rig() -> PullRig:
    """A pulling machine with the left hand on a bar along x."""
    spec = load_hand("left")
    add_bar(spec, Bar(height=0.1, yaw=-np.pi / 2, length=0.3))
    return PullRig(spec.compile())


def hanging(
    *, surface: LimitSurface | None = None, closed: bool = True
) -> tuple[SimRobot, np.ndarray]:
    """The robot with straight arms below a bar, both hands on it; and its servo targets."""
    q = keyframe_joints("hang")[0].copy()
    for side, sign in (("left", 1), ("right", -1)):
        q[JOINTS.index(f"{side}_wrist_yaw")] = sign * np.pi / 2
        q[JOINTS.index(f"{side}_gripper")] = pinch_angle(WIDTH)
    base = keyframe("hang")[0][:7].copy()
    base[2] += 0.3
    model = load_model()
    data = mujoco.MjData(model)
    data.qpos[:] = configuration(model, q, p=base[:3], quat=base[3:])
    mujoco.mj_kinematics(model, data)
    hand = model.body("left_arm_gripper_base").id
    tips = finger_tips(pinch_angle(WIDTH)).mean(axis=0)
    middle = data.xpos[hand] + data.xmat[hand].reshape(3, 3) @ tips
    scene = build_bar_scene(load_spec(), Bar(height=middle[2], xy=(middle[0], 0.0))).compile()
    robot = SimRobot(scene, qpos=configuration(scene, q, p=base[:3], quat=base[3:]))
    for side in ("left", "right"):
        robot.grasps.append(PinchGrasp(scene, robot.data, hand=side, surface=surface))
        if closed:
            assert robot.grasps[-1].close() == "held"
    targets = q.copy()
    targets[20:] = 0.0
    robot.write(JointCommand(stamp=0.0, q=targets))
    return robot, targets


def test_a_dead_hang_holds_the_weight_across_the_groove_within_a_millimetre():
    robot, _ = hanging()
    start = [g.centre() for g in robot.grasps]
    for _ in range(900):
        robot.wait()
    mass = robot.model.body_subtreemass[robot.model.body("base_link").id]
    down = sum(-g.force[2] for g in robot.grasps)
    assert down == pytest.approx(9.81 * mass, rel=0.05)
    for grasp, before in zip(robot.grasps, start, strict=True):
        assert grasp.state == "held" and grasp.slip == 0.0
        assert np.linalg.norm(grasp.centre() - before) < 1.2e-3


def test_a_hang_that_its_surface_cannot_hold_slips_breaks_and_falls():
    robot, _ = hanging(surface=LimitSurface(40.0, 20.0, 2.0))
    seen = set()
    for _ in range(240):
        robot.wait()
        seen.add(robot.grasps[0].state)
    assert {"slipping", "broken"} <= seen
    assert robot.data.qvel[2] < -0.5 and not robot.grasps[0].force.any()


def test_opening_the_hand_lets_go():
    robot, targets = hanging()
    for _ in range(30):
        robot.wait()
    targets[20:] = 0.8
    robot.write(JointCommand(stamp=0.0, q=targets))
    for _ in range(120):
        robot.wait()
    assert [g.state for g in robot.grasps] == ["open", "open"]
    assert not robot.data.xfrc_applied.any()


def test_a_bar_out_of_reach_is_not_taken(rig):
    mujoco.mj_resetData(rig.model, rig.data)
    rig.grasp.reset()
    rig.data.joint("pull_z").qpos[0] = -0.2
    away, turned = rig.grasp.offset()
    assert away > 0.1 and turned < 1e-6
    assert rig.grasp.close() == "open" and not rig.grasp.holds
    with pytest.raises(InvalidInput, match="mm from the fingers"):
        rig.pull(LimitSurface(), "z", offset=(0.02, 0.0))


@pytest.mark.parametrize(("axis", "limit"), [("x", 23.6), ("z", 124.2)])
def test_the_wrist_sensor_reads_the_limit_at_which_the_grasp_gives(rig, axis, limit):
    """The hand's inertia adds, in proportion to the speed: slower, the reading nears the limit."""
    over = []
    for speed in (0.008, 0.004):
        pull = rig.pull(LimitSurface(), axis, speed=speed)
        assert pull.end == ("slipping" if axis == "x" else "broken") and pull.slip >= HOOK
        over.append(pull.peak - limit)
    assert 0 < over[1] < 0.6 * over[0] < 0.01 * limit


def test_a_slanted_pull_gives_on_the_ellipsoid(rig):
    """F_a = 100, F_l = 50, t = 0.5 rad. Machine and grasp in series have 33 kN/m along z and
    22 kN/m along x, so the force first meets the surface at atan(tan t * 22/33) = 0.349 rad with
    1 / |(cos/100, sin/50)| = 86 N, of which 86 cos(0.5 - 0.349) = 85 N lie along the pull. It then
    slides on the surface, whose farthest point along the pull is |(100 cos t, 50 sin t)| = 91 N.
    """
    pull = rig.pull(LimitSurface(100.0, 50.0, 4.0), "z", speed=0.004, tilt=0.5)
    assert 85.0 < pull.peak < 91.5


def test_wrench_at_the_wrist_is_what_the_sensor_reads_with_the_hands_weight(rig):
    data, model, grasp = rig.data, rig.model, rig.grasp
    rig.place((0.0, 0.0))
    grasp.close(LimitSurface(1e3, 1e3, 1e3))
    data.ctrl[1:4] += [0.001, 0.0, -0.003]
    for _ in range(600):
        grasp.step()
        mujoco.mj_step(model, data)
    mass = model.body_subtreemass[model.body("left_arm_gripper_base").id]
    R = data.site("left_wrist_ft").xmat.reshape(3, 3)
    sensor, bar = R @ data.sensor("left_wrist_force").data, R @ grasp.wrench_S[:3]
    assert bar[2] > 80 and bar[0] < -15
    expected = -bar - [0, 0, -9.81 * mass]  # along y the fingers' contact comes on top
    np.testing.assert_allclose(sensor[[0, 2]], expected[[0, 2]], atol=0.05)
    moment = R @ (data.sensor("left_wrist_torque").data + grasp.wrench_S[3:])
    assert abs(moment[1]) < 0.02 < abs((R @ grasp.wrench_S[3:])[1])


def test_a_shaken_grasp_never_gives_back_more_than_it_took(rig):
    """Work of the grasp on the hand, from rest to any later time, stays below zero: springs lend,
    dampers and slip only take. Shaken hard enough to slip all the time. The slides do not turn
    the hand: its axes are the grasp's.
    """
    model, data, grasp = rig.model, rig.data, rig.grasp
    rig.pull(LimitSurface(), "x", speed=0.02)
    rig.place((0.0, 0.0))
    grasp.close(LimitSurface(1e3, 5.0, 1.0))
    rng, work, slipped = np.random.default_rng(0), 0.0, 0.0
    home = data.ctrl.copy()
    for k in range(1500):
        if k % 20 == 0:
            data.ctrl[1:4] = home[1:4] + rng.normal(0, 5e-4, 3)
        before = grasp.centre()
        grasp.step()
        force = data.body("left_arm_gripper_base").xmat.reshape(3, 3) @ grasp.force[:3]
        mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        work += float(force @ (grasp.centre() - before))
        slipped = max(slipped, grasp.slip)
        assert work < 5e-4
    assert slipped > 1e-3 and work < -0.01 and grasp.holds


def test_the_hold_is_stable_in_any_pose_of_the_arm():
    """Spring and damper at step dt: (dt^2 + 2 dt t_d) lambda < 4, lambda the greatest eigenvalue of
    stiffness times the grasp's mobility; loops left open, which only adds mobility.
    """
    model = load_model()
    data, rng, dt = mujoco.MjData(model), np.random.default_rng(0), model.opt.timestep
    hand, arm = model.body("left_arm_gripper_base").id, LIMB_JOINTS["left_arm"]
    low, high = joint_limits()
    q = keyframe_joints("hang")[0].copy()
    tips, worst, poses = finger_tips(pinch_angle(WIDTH)).mean(axis=0), 0.0, 0
    while poses < 150:
        q[arm] = rng.uniform(low[arm], high[arm])
        a, b = q[arm][1:3]
        if not (b - a > 0.7 and np.isfinite(passive_angles(q)[0]).all()):
            continue
        poses += 1
        data.qpos[:] = configuration(model, q, p=(0, 0, 2))
        mujoco.mj_forward(model, data)
        R = data.xmat[hand].reshape(3, 3)
        move, turn, back = np.zeros((3, model.nv)), np.zeros((3, model.nv)), np.zeros((6, model.nv))
        mujoco.mj_jac(model, data, move, turn, data.xpos[hand] + R @ tips, hand)
        J = np.vstack([R.T @ move, R.T @ turn])
        mujoco.mj_solveM(model, data, back, J)
        stiff = np.linalg.eigvals(STIFFNESS[:, None] * (J @ back.T)).real.max()
        worst = max(worst, float(stiff) * (dt * dt + 2 * dt * DAMPING_TIME))
    assert 0.5 < worst < 2.0


def test_a_loose_bar_feels_the_hand():
    """Momentum of hand and bar together stays: the grasp is an internal force."""
    spec = load_hand("left")
    add_bar(spec, Bar(height=0.1, yaw=-np.pi / 2, length=0.3))
    spec.body("bar").add_freejoint()
    spec.option.gravity = [0, 0, 0]
    for post in ("bar_post_0", "bar_post_1"):
        spec.delete(spec.geom(post))
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0
    spec.geom("bar").density = 500.0
    for name in ("pull_x", "pull_y", "pull_z"):
        spec.delete(spec.actuator(name))
    model = spec.compile()
    data = mujoco.MjData(model)
    q = pinch_angle(WIDTH)
    data.joint("left_gripper").qpos[0] = data.joint("left_finger_b").qpos[0] = q
    data.ctrl[:] = q
    data.joint("pull_z").qpos[0] = 0.1 + finger_tips(q)[0, 2]
    grasp = PinchGrasp(model, data)
    assert grasp.close() == "held"
    data.joint("pull_z").qvel[0] = -0.02

    def momentum() -> np.ndarray:
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        bodies = [model.body(b).id for b in ("crosshead", "bar")]
        mass = model.body_subtreemass[bodies]
        return np.asarray(mass @ data.subtree_linvel[bodies])

    before = momentum()
    for _ in range(120):
        grasp.step()
        mujoco.mj_step(model, data)
    assert abs(data.body("bar").cvel[5]) > 1e-3 and grasp.state == "held"
    np.testing.assert_allclose(momentum(), before, atol=1e-6)


def test_unknown_names_are_refused(rig):
    with pytest.raises(UnknownName, match=r"unknown hand 'lefft'\. Did you mean 'left'"):
        PinchGrasp(rig.model, rig.data, hand="lefft")
    with pytest.raises(UnknownName, match="unknown geom to grasp 'baar'"):
        PinchGrasp(rig.model, rig.data, bar="baar")
    with pytest.raises(UnknownName, match="unknown pull axis"):
        rig.pull(LimitSurface(), "y")
    with pytest.raises(InvalidInput, match="speed > 0"):
        rig.pull(LimitSurface(), "z", speed=0.0)
