"""Nouns go out as ROS 2 messages and come back as they were."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest

from mobius.bridge.messages import CLOCK_HZ, TOPICS, decode, encode, topic
from mobius.bridge.to_ros import STORE
from mobius.errors import InvalidInput, UnknownName
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE, passive_joints
from mobius.model.urdf import build_urdf, fixed_frames
from mobius.types import ALL_MODES_BITS, Mode

YAW_90 = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


def sent(name, nouns):
    """The ROS message a peer would decode."""
    row = TOPICS[name]
    return STORE.deserialize_cdr(encode(name, nouns[row.noun]), row.type)


@pytest.mark.parametrize("name", TOPICS)
def test_every_topic_speaks_cdr_of_its_own_type(name, nouns):
    data = encode(name, nouns[TOPICS[name].noun])
    assert bytes(data[:4]) == b"\x00\x01\x00\x00"
    assert type(sent(name, nouns)).__name__ == TOPICS[name].type.replace("/", "__")


@pytest.mark.parametrize("row", TOPICS.values(), ids=TOPICS)
def test_every_rate_divides_the_base_clock(row):
    assert row.latched or CLOCK_HZ % row.rate == 0


def test_joint_states_round_trip_under_the_models_names(nouns):
    frame, message = nouns["frame"], sent("/joint_states", nouns)
    assert tuple(message.name) == (*JOINTS, *PASSIVE)
    assert len(message.position) == len(message.velocity) == len(message.effort) == 30
    q, dq, torque = decode("/joint_states", encode("/joint_states", frame))
    np.testing.assert_array_equal(q, frame.q)
    np.testing.assert_array_equal(dq, frame.dq)
    np.testing.assert_array_equal(torque, frame.torque)


def test_joints_listed_in_another_order_are_sorted_into_ours(nouns):
    message = TOPICS["/mobius/joint_targets"].to_ros(nouns["target"])
    message.name = message.name[::-1]
    message.position = message.position[::-1].copy()
    back = TOPICS["/mobius/joint_targets"].from_ros(message)
    np.testing.assert_array_equal(back.q, nouns["target"].q)
    assert back.stamp == 1.5


def test_a_joint_the_model_does_not_have_is_refused_by_name(nouns):
    message = TOPICS["/joint_states"].to_ros(nouns["frame"])
    message.name = ["left_elbow", *JOINTS[1:]]
    with pytest.raises(InvalidInput, match=r"at odds: left_elbow, left_shoulder_yaw"):
        TOPICS["/joint_states"].from_ros(message)


def test_joint_states_carry_the_passive_joints_behind_the_driven_ones(nouns):
    message = sent("/joint_states", nouns)
    np.testing.assert_array_equal(message.position[22:], passive_joints(nouns["frame"].q))
    assert message.effort[22:].tolist() == [0.0] * 8


def test_the_static_frames_are_map_to_odom_and_the_fixed_joints_of_the_urdf(nouns):
    message = sent("/tf_static", nouns)
    said = [(t.header.frame_id, t.child_frame_id) for t in message.transforms]
    assert said == [("map", "odom"), *((f.parent, f.name) for f in fixed_frames())]


def test_the_description_travels_whole(nouns):
    urdf = build_urdf()
    assert decode("/robot_description", encode("/robot_description", urdf)) == urdf


def test_a_picture_keeps_its_pixels_and_its_lens(nouns):
    picture = nouns["picture"]
    name = "/camera/color/image_raw"
    np.testing.assert_array_equal(decode(name, encode(name, picture)), picture.pixels)
    message = sent("/camera/color/camera_info", nouns)
    # 6 x 4 pixels, focal length 5: the middle lies between columns 2 and 3, rows 1 and 2
    assert message.k.tolist() == [5.0, 0.0, 2.5, 0.0, 5.0, 1.5, 0.0, 0.0, 1.0]
    assert (message.width, message.height) == (6, 4)
    assert message.header.frame_id in {f.name for f in fixed_frames()}


@pytest.mark.parametrize("kind", ["Twist", "TwistStamped"])
def test_a_velocity_that_is_not_finite_is_refused(kind, nouns):
    stamped = sent("/cmd_vel", nouns)
    message = stamped if kind == "TwistStamped" else stamped.twist
    getattr(message, "twist", message).linear.y = np.nan
    with pytest.raises(InvalidInput, match="expected finite numbers"):
        TOPICS["/cmd_vel"].from_ros(message)


def test_a_goal_in_a_frame_we_do_not_know_is_refused():
    from mobius.bridge.from_ros import goal

    types = STORE.types
    message = sent_pose(types, "base_link")
    with pytest.raises(InvalidInput, match="got frame 'base_link'"):
        goal(message)
    np.testing.assert_array_equal(goal(sent_pose(types, "map")), [1.0, 2.0])


def sent_pose(types, frame):
    """A PoseStamped at (1, 2, 3)."""
    from mobius.bridge.to_ros import header

    return types["geometry_msgs/msg/PoseStamped"](
        header=header(1.0, frame),
        pose=types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](x=1.0, y=2.0, z=3.0),
            orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        ),
    )


def test_the_bytes_of_a_clock_are_the_ones_computed_by_hand():
    # 1.5 s: header 00 01 00 00, sec 1 as int32, nanosec 500,000,000 as uint32
    assert bytes(encode("/clock", 1.5)) == struct.pack("<4BiI", 0, 1, 0, 0, 1, 500_000_000)
    assert decode("/clock", encode("/clock", 1.5)) == 1.5


def test_a_stamp_that_rounds_up_to_a_whole_second_carries_over(nouns):
    data = encode("/clock", 1.9999999999)
    assert bytes(data[4:]) == struct.pack("<iI", 2, 0)


def test_quaternions_travel_as_xyzw(nouns):
    s = np.sqrt(0.5)
    for name in ("/odom", "/mobius/ground_truth"):
        q = sent(name, nouns).pose.pose.orientation
        assert (q.x, q.y, q.z, q.w) == (0.0, 0.0, s, s)
    q = sent("/tf", nouns).transforms[0].transform.rotation
    assert (q.x, q.y, q.z, q.w) == (0.0, 0.0, s, s)
    np.testing.assert_array_equal(
        decode("/mobius/vio", encode("/mobius/vio", nouns["frame"])).q, YAW_90
    )


def test_frames_follow_rep_105(nouns):
    odom, truth = sent("/odom", nouns), sent("/mobius/ground_truth", nouns)
    assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base_link")
    tf, static = sent("/tf", nouns).transforms[0], sent("/tf_static", nouns).transforms[0]
    assert (tf.header.frame_id, tf.child_frame_id) == ("odom", "base_link")
    assert (static.header.frame_id, static.child_frame_id) == ("map", "odom")
    assert sent("/cmd_vel", nouns).header.frame_id == "base_footprint"


@pytest.mark.parametrize("name", ["/odom", "/mobius/ground_truth"])
def test_odometry_round_trips_pose_and_twist(name, nouns):
    state = nouns[TOPICS[name].noun]
    back = decode(name, encode(name, state))
    for field in ("stamp", "p_OB", "q_OB", "v_B", "w_B"):
        np.testing.assert_array_equal(getattr(back, field), getattr(state, field))


def test_covariance_is_reordered_to_position_first_and_back(nouns):
    """Ours: rotation, position, angular, linear. ROS: position, rotation; linear, angular."""
    belief = nouns["belief"]
    odom = sent("/odom", nouns)
    pose = np.reshape(odom.pose.covariance, (6, 6))
    twist = np.reshape(odom.twist.covariance, (6, 6))
    assert pose[0, 0] == belief.cov[3, 3]  # x
    assert pose[5, 1] == belief.cov[2, 4]  # yaw with y
    assert twist[0, 2] == belief.cov[9, 11]  # vx with vz
    assert twist[3, 0] == belief.cov[6, 9]  # wx with vx
    back = decode("/odom", encode("/odom", belief))
    np.testing.assert_array_equal(back.cov[:6, :6], belief.cov[:6, :6])
    np.testing.assert_array_equal(back.cov[6:, 6:], belief.cov[6:, 6:])


def test_wrenches_are_left_and_right(nouns):
    frame = nouns["frame"]
    for row, side in enumerate(("left", "right")):
        name = f"/{side}_gripper/wrench"
        np.testing.assert_array_equal(decode(name, encode(name, frame)), frame.wrench_S[row])
        assert sent(name, nouns).header.frame_id == f"{side[0]}_wrist_ft"


def test_the_imu_says_that_it_gives_no_orientation(nouns):
    assert sent("/imu/data", nouns).orientation_covariance[0] == -1.0
    gyro, accel = decode("/imu/data", encode("/imu/data", nouns["frame"]))
    np.testing.assert_array_equal(gyro, nouns["frame"].gyro_I)
    np.testing.assert_array_equal(accel, nouns["frame"].accel_I)


def test_a_camera_that_did_not_tick_says_nothing(nouns):
    assert encode("/mobius/vio", replace(nouns["frame"], vio=None)) is None


def test_cmd_vel_is_understood_as_twist_and_as_twist_stamped(nouns):
    stamped = sent("/cmd_vel", nouns)
    from_ros = TOPICS["/cmd_vel"].from_ros
    np.testing.assert_array_equal(from_ros(stamped), [0.3, -0.1, 0.2])
    np.testing.assert_array_equal(from_ros(stamped.twist), [0.3, -0.1, 0.2])


def test_a_mode_round_trips_and_an_unknown_one_is_refused(nouns):
    assert decode("/mobius/mode", encode("/mobius/mode", nouns["command"])) is Mode.CRAWL
    message = TOPICS["/mobius/mode"].to_ros(nouns["command"])
    message.data = "fly"
    with pytest.raises(InvalidInput, match=r"expected one of biped, crawl.*got 'fly'"):
        TOPICS["/mobius/mode"].from_ros(message)


def test_the_map_lists_cells_row_by_row_from_the_lower_left(nouns):
    # 3 cells along x, 2 along y, (2, 0) blocked: y = 0 is 0 0 100, y = 1 is 0 0 0
    message = sent("/map", nouns)
    assert (message.info.width, message.info.height) == (3, 2)
    assert message.data.tolist() == [0, 0, 100, 0, 0, 0]


def test_the_map_round_trips(nouns):
    grid, back = nouns["grid"], decode("/map", encode("/map", nouns["grid"]))
    np.testing.assert_array_equal(back.blocked, grid.blocked)
    np.testing.assert_allclose(back.origin_M, grid.origin_M, atol=1e-12)
    assert back.cell == grid.cell
    assert (back.allowed == ALL_MODES_BITS).all()


def test_unknown_cells_of_a_foreign_map_count_as_blocked(nouns):
    message = TOPICS["/map"].to_ros(nouns["grid"])
    message.data = np.array([-1, 0, 100, 65, 66, 0], dtype=np.int8)
    # (i, j): y = 0 holds -1 0 100, y = 1 holds 65 66 0
    expected = [[True, False], [False, True], [True, False]]
    assert TOPICS["/map"].from_ros(message).blocked.tolist() == expected


def test_the_plan_round_trips_and_its_poses_face_the_next_cell(nouns):
    plan = nouns["plan"]
    np.testing.assert_array_equal(decode("/plan", encode("/plan", plan)), plan.xy_M)
    # the first step runs along the grid's x axis, turned by the origin's 0.25 rad
    q = sent("/plan", nouns).poses[0].pose.orientation
    np.testing.assert_allclose([q.z, q.w], [np.sin(0.125), np.cos(0.125)], atol=1e-12)


def test_plan_modes_are_json_that_says_what_is_proven(nouns):
    plan = nouns["plan"]
    said = json.loads(sent("/mobius/plan_modes", nouns).data)
    assert said["status"] == "optimal"
    assert said["modes"] == ["crawl", "biped"]
    assert decode("/mobius/plan_modes", encode("/mobius/plan_modes", plan)) == plan.modes


def test_an_unknown_topic_is_answered_with_the_closest():
    with pytest.raises(UnknownName, match="Did you mean '/joint_states'"):
        topic("/joint_state")


def test_contacts_name_their_limbs_and_come_back(nouns):
    belief = replace(nouns["belief"], contact=np.array([0.1, 0.2, 0.3, 0.4]))
    message = TOPICS["/mobius/contacts"].to_ros(belief)
    assert message.layout.dim[0].label == "left_arm,right_arm,left_leg,right_leg"
    np.testing.assert_array_equal(
        decode("/mobius/contacts", encode("/mobius/contacts", belief)), belief.contact
    )


def test_contacts_of_three_limbs_are_refused(nouns):
    message = TOPICS["/mobius/contacts"].to_ros(nouns["belief"])
    message.data = message.data[:3]
    with pytest.raises(InvalidInput, match="expected 4 numbers, got 3"):
        TOPICS["/mobius/contacts"].from_ros(message)


def test_obstacles_round_trip_even_where_there_are_none(nouns):
    for poses in (nouns["obstacles"], np.zeros((0, 7))):
        back = decode("/mobius/obstacles", encode("/mobius/obstacles", poses))
        np.testing.assert_array_equal(back, poses)
