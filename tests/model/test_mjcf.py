"""The MJCF: what the robot weighs, how it is closed, what it touches, what it may do."""

import mujoco
import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.model import JOINTS
from mobius.model import robot as load
from mobius.model.build import ROBOT_XML, build_robot
from mobius.model.poses import build_keyframes
from mobius.types import LIMBS


@pytest.fixture(scope="module")
def model():
    return load.load_model("full")


def subtree(model, name):
    return model.body_subtreemass[model.body(name).id]


def test_committed_file_is_what_the_code_builds():
    """`python -m mobius.model.poses` rewrites it; settled targets may differ in the last digit."""
    committed = mujoco.MjModel.from_xml_path(str(ROBOT_XML))
    built = mujoco.MjModel.from_xml_string(build_robot(build_keyframes()))
    assert (committed.nq, committed.nu, committed.ngeom) == (built.nq, built.nu, built.ngeom)
    for name in ("body_mass", "body_pos", "geom_size", "geom_pos", "jnt_range", "actuator_gainprm"):
        np.testing.assert_allclose(getattr(committed, name), getattr(built, name), atol=1e-6)
    np.testing.assert_allclose(committed.key_qpos, built.key_qpos, atol=1e-4)
    np.testing.assert_allclose(committed.key_ctrl, built.key_ctrl, atol=2e-3)


def test_masses(model):
    total = subtree(model, "base_link")
    assert 10.0 <= total <= 10.3 + 1e-9
    arms = subtree(model, "left_arm_shoulder") + subtree(model, "right_arm_shoulder")
    legs = subtree(model, "left_leg_hip") + subtree(model, "right_leg_hip")
    assert arms / legs == pytest.approx(1.55, abs=0.02)


def test_jacobian_is_dense(model):
    """mujoco 4.0.0 builds a wrong Newton Hessian from a sparse one (mujoco issue 3767)."""
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    assert not mujoco.mj_isSparse(model)
    assert not mujoco.mj_isSparse(load.load_model("feet"))


def test_joint_names_and_order(model):
    assert len(JOINTS) == 22 == model.nu
    assert tuple(model.actuator(i).name for i in range(model.nu)) == JOINTS
    for joint in JOINTS:
        assert model.joint(joint).id >= 0


def test_published_ranges(model):
    def span(name):
        low, high = model.joint(name).range
        return np.degrees(high - low)

    for side in ("left", "right"):
        assert span(f"{side}_shoulder_yaw") == pytest.approx(210.0, abs=1e-3)
        assert span(f"{side}_hip_yaw") == pytest.approx(210.0, abs=1e-3)
        assert span(f"{side}_ankle_pitch") == pytest.approx(105.0, abs=1e-3)


def test_robot_file_holds_only_the_robot():
    bare = mujoco.MjModel.from_xml_path(str(ROBOT_XML))
    assert all(bare.geom_bodyid != 0)  # nothing is fixed to the world
    assert mujoco.MjModel.from_xml_path(str(load.SCENE_PATH)).geom("floor").id >= 0


def test_home_touches_the_floor_with_soles_only(model):
    data = mujoco.MjData(model)
    qpos, ctrl = load.keyframe("crawl")
    data.qpos[:], data.ctrl[:] = qpos, ctrl
    data.qpos[2] -= 1e-4
    mujoco.mj_forward(model, data)
    assert data.ncon >= 4
    for pair in data.contact.geom:
        names = {model.geom(i).name for i in pair}
        assert "floor" in names
        assert all(n == "floor" or "_sole" in n for n in names)


@pytest.mark.parametrize("name", ["crawl", "home", "stand", "prone", "supine", "on_head", "hang"])
def test_keyframes_are_closed_and_above_the_floor(model, name):
    data = mujoco.MjData(model)
    data.qpos[:] = load.keyframe(name)[0]
    mujoco.mj_forward(model, data)
    for limb in LIMBS:
        gap = data.site(f"{limb}_loop_coupler").xpos - data.site(f"{limb}_loop_distal").xpos
        assert np.abs(gap).max() < 1e-4
    assert all(c.dist > -1e-3 for c in data.contact)


def test_home_stands_still_for_three_seconds(model):
    data = mujoco.MjData(model)
    qpos, ctrl = load.keyframe("crawl")
    data.qpos[:], data.ctrl[:] = qpos, ctrl
    mujoco.mj_step(model, data, 1800)
    assert abs(data.qpos[2] - qpos[2]) < 0.01
    assert np.abs(data.qvel).max() < 0.02


def test_stand_stands_on_two_feet_without_control(model):
    """Static targets alone hold it for two seconds; the centre of mass is over the feet."""
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = load.keyframe("stand")
    height = data.qpos[2]
    mujoco.mj_step(model, data, 1200)
    assert abs(data.qpos[2] - height) < 0.005
    ahead = data.subtree_com[1][0] - data.site("left_sole").xpos[0]
    assert -0.055 < ahead < 0.085  # between heel and toe


def test_loops_stay_closed_under_load(model):
    """Random targets of +-0.3 rad and twice the weight: the loops open by less than 1 mm."""
    data = mujoco.MjData(model)
    data.qpos[:], ctrl = load.keyframe("crawl")
    rng, worst = np.random.default_rng(0), 0.0
    data.xfrc_applied[model.body("base_link").id, 2] = -100.0
    for _ in range(60):
        data.ctrl[:] = ctrl + rng.uniform(-0.3, 0.3, 22)
        data.ctrl[20:] = 0
        mujoco.mj_step(model, data, 10)
        for limb in LIMBS:
            gap = data.site(f"{limb}_loop_coupler").xpos - data.site(f"{limb}_loop_distal").xpos
            worst = max(worst, float(np.linalg.norm(gap)))
    assert worst < 1e-3


def test_training_model_is_the_same_robot(model):
    feet = load.load_model("feet")
    assert subtree(feet, "base_link") == pytest.approx(subtree(model, "base_link"))
    assert feet.nv == model.nv - 4  # the fingers are welded
    q = load.keyframe_joints("crawl")[0]
    a, b = mujoco.MjData(model), mujoco.MjData(feet)
    a.qpos[:], b.qpos[:] = load.configuration(model, q), load.configuration(feet, q)
    for m, d in ((model, a), (feet, b)):
        mujoco.mj_kinematics(m, d)
    for limb in LIMBS:
        np.testing.assert_allclose(
            a.site(f"{limb}_tip").xpos, b.site(f"{limb}_tip").xpos, atol=1e-9
        )


def test_errors_name_what_exists():
    with pytest.raises(UnknownName, match="Did you mean 'stand'"):
        load.keyframe("stnd")
    with pytest.raises(UnknownName, match="full"):
        load.load_spec("ful")
    q = load.keyframe_joints("crawl")[0].copy()
    q[1], q[2] = 1.444, 1.697  # the crank pins meet
    with pytest.raises(InvalidInput, match="left_arm"):
        load.configuration(load.load_model("full"), q)
