"""Who reads the URDF sees the robot that MuJoCo simulates."""

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest

from mobius.geometry import exp_so3, quat_to_mat, rpy_to_quat
from mobius.model import JOINTS
from mobius.model.passive import PASSIVE, passive_joints
from mobius.model.robot import configuration, joint_limits, load_model
from mobius.model.urdf import TRUNK, build_urdf, fixed_frames


def numbers(text: str):
    return np.array([float(v) for v in text.split()])


def pose(origin) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = quat_to_mat(rpy_to_quat(*numbers(origin.get("rpy"))))
    T[:3, 3] = numbers(origin.get("xyz"))
    return T


class Reader:
    """Forward kinematics from the text alone, by the rules of URDF."""

    def __init__(self, text: str) -> None:
        self.root = ET.fromstring(text)
        self.joints = {j.get("name"): j for j in self.root.iter("joint")}

    def links(self, angles: dict[str, float]) -> dict[str, np.ndarray]:
        found, left = {"base_link": np.eye(4)}, list(self.joints.values())
        while left:
            joint = next(j for j in left if j.find("parent").get("link") in found)
            left.remove(joint)
            T = found[joint.find("parent").get("link")] @ pose(joint.find("origin"))
            if joint.get("type") != "fixed":
                turn = np.eye(4)
                axis = numbers(joint.find("axis").get("xyz"))
                turn[:3, :3] = exp_so3(axis * self.angle(joint, angles))
                T = T @ turn
            found[joint.find("child").get("link")] = T
        return found

    def angle(self, joint, angles) -> float:
        mimic = joint.find("mimic")
        if mimic is None:
            return angles[joint.get("name")]
        scale, offset = float(mimic.get("multiplier")), float(mimic.get("offset"))
        return scale * angles[mimic.get("joint")] + offset


@pytest.fixture(scope="module")
def reader():
    return Reader(build_urdf())


@pytest.fixture(scope="module")
def model():
    return load_model("full", floor=False)


def random_joints(count: int):
    low, high = joint_limits()
    rng, found = np.random.default_rng(5), []
    a = np.array([j.endswith("motor_a") for j in JOINTS])
    b = np.array([j.endswith("motor_b") for j in JOINTS])
    while len(found) < count:
        q = rng.uniform(low, high)
        if (q[b] - q[a] >= 0.7).all():
            found.append(q)
    return found


def test_links_stand_where_mujoco_puts_them(reader, model):
    data = mujoco.MjData(model)
    bodies = [model.body(i).name for i in range(1, model.nbody)]
    for q in random_joints(40):
        data.qpos[:] = configuration(model, q)
        mujoco.mj_kinematics(model, data)
        joints, passive = zip(JOINTS, q, strict=True), zip(PASSIVE, passive_joints(q), strict=True)
        links = reader.links({**dict(joints), **dict(passive)})
        for name in bodies:
            T = links[TRUNK if name == "base_link" else name]
            np.testing.assert_allclose(T[:3, 3], data.body(name).xpos, atol=1e-6, err_msg=name)
            R = data.body(name).xmat.reshape(3, 3)
            np.testing.assert_allclose(T[:3, :3], R, atol=5e-6, err_msg=name)


def test_fixed_frames_stand_where_the_sites_and_cameras_are(reader, model):
    data, q = mujoco.MjData(model), random_joints(1)[0]
    data.qpos[:] = configuration(model, q)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_camlight(model, data)
    joints, passive = zip(JOINTS, q, strict=True), zip(PASSIVE, passive_joints(q), strict=True)
    links = reader.links({**dict(joints), **dict(passive)})
    sites = {
        "imu": "imu", "gaze": "gaze", "l_wrist_ft": "left_wrist_ft", "r_wrist_ft": "right_wrist_ft",
        "l_gripper": "left_arm_tip", "r_gripper": "right_arm_tip",
        "l_sole": "left_sole", "r_sole": "right_sole",
    }  # fmt: skip
    for frame, site in sites.items():
        np.testing.assert_allclose(links[frame][:3, 3], data.site(site).xpos, atol=1e-6)
    for frame, camera in (("camera_color_optical_frame", "head"), ("vio_optical_frame", "vio")):
        # a MuJoCo camera looks along -z with y up, an optical frame along +z with y down
        R = data.cam(camera).xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
        np.testing.assert_allclose(links[frame][:3, :3], R, atol=1e-6)
        np.testing.assert_allclose(links[frame][:3, 3], data.cam(camera).xpos, atol=1e-6)
    names = {frame.name for frame in fixed_frames()}
    assert names == {*sites, TRUNK, "camera_color_optical_frame", "vio_optical_frame"}


def test_gaze_points_x_forward_and_down(reader):
    x = reader.links(dict.fromkeys([*JOINTS, *PASSIVE], 0.0))["gaze"][:3, 0]
    np.testing.assert_allclose(x, [np.cos(np.radians(40)), 0, -np.sin(np.radians(40))], atol=1e-9)


def test_masses_and_inertias_are_those_of_the_model(reader, model):
    total = 0.0
    for link in reader.root.iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        name = link.get("name")
        i = model.body("base_link" if name == TRUNK else name).id
        mass = float(inertial.find("mass").get("value"))
        total += mass
        assert mass == pytest.approx(model.body_mass[i], rel=1e-5)
        np.testing.assert_allclose(
            numbers(inertial.find("origin").get("xyz")), model.body_ipos[i], atol=1e-6
        )
        e = inertial.find("inertia").attrib
        rows = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
        inertia = [[float(e[k]) for k in row] for row in rows]
        R = quat_to_mat(model.body_iquat[i])
        expected = R @ np.diag(model.body_inertia[i]) @ R.T
        np.testing.assert_allclose(inertia, expected, rtol=1e-5, atol=1e-9)
    assert total == pytest.approx(10.3, abs=1e-6)


def test_joints_are_the_22_the_passive_ones_and_two_mimics_with_the_models_limits(reader, model):
    moving = {n: j for n, j in reader.joints.items() if j.get("type") != "fixed"}
    mimics = {n for n, j in moving.items() if j.find("mimic") is not None}
    assert mimics == {"left_finger_b", "right_finger_b"}
    assert set(moving) - mimics == {*JOINTS, *PASSIVE}
    for name in JOINTS:
        limit = moving[name].find("limit")
        low, high = model.joint(name).range
        assert float(limit.get("lower")) == pytest.approx(low, abs=1e-5)
        assert float(limit.get("upper")) == pytest.approx(high, abs=1e-5)
        assert float(limit.get("effort")) == pytest.approx(
            model.actuator(name).forcerange[1], rel=1e-5
        )
        slope = model.dof_damping[model.joint(name).dofadr[0]]
        assert float(limit.get("velocity")) == pytest.approx(
            float(limit.get("effort")) / slope, rel=1e-4
        )


def test_it_is_one_tree_that_refers_to_no_file(reader):
    links = {link.get("name") for link in reader.root.iter("link")}
    children = [j.find("child").get("link") for j in reader.joints.values()]
    assert len(children) == len(set(children)) == len(links) - 1
    assert links - set(children) == {"base_link"}
    assert not list(reader.root.iter("mesh"))
    assert not list(reader.root.iter("texture"))


def test_volumes_are_those_of_the_visible_geoms(reader, model):
    """Every visual of the MJCF is there once; a capsule as a rod with two balls."""
    import collections

    kinds = collections.Counter(
        mujoco.mjtGeom(int(t)).name for t in model.geom_type[model.geom_group == 2]
    )
    seen = collections.Counter(
        shape.tag for visual in reader.root.iter("visual") for shape in visual.find("geometry")
    )
    capsules = kinds["mjGEOM_CAPSULE"]
    assert seen == {
        "box": kinds["mjGEOM_BOX"],
        "cylinder": kinds["mjGEOM_CYLINDER"] + capsules,
        "sphere": kinds["mjGEOM_SPHERE"] + 2 * capsules,
    }


def test_mujoco_reads_it_and_finds_the_same_tree(reader):
    """A reader that shares no code with the writer."""
    model = mujoco.MjModel.from_xml_string(
        build_urdf().replace(
            '<robot name="mobius">',
            '<robot name="mobius"><mujoco><compiler fusestatic="false" discardvisual="false"/>'
            "</mujoco>",
        )
    )
    assert {model.joint(i).name for i in range(model.njnt)} >= {*JOINTS, *PASSIVE}
    assert model.body_mass.sum() == pytest.approx(10.3, abs=1e-6)
