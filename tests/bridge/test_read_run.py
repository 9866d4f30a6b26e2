"""A run comes back from its log as it was recorded, with everything that looking at it needs."""

import mujoco
import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import StoragePlugin, Writer

from mobius.bridge.describe import describe
from mobius.bridge.messages import TOPICS, encode
from mobius.bridge.read_log import find_log, read_log
from mobius.bridge.read_run import open_run
from mobius.bridge.record import McapRecorder
from mobius.bridge.series import between, held, latest, turned_between
from mobius.bridge.to_ros import STORE
from mobius.control.bodies import BODIES
from mobius.control.observation import heading_twist
from mobius.errors import InvalidInput
from mobius.geometry import rotate, rpy_to_quat
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE
from mobius.model.robot import addresses, configuration
from mobius.types import LIMBS, Mode, ModeCommand, Plan, Pose, StateEstimate


@pytest.fixture
def run(run_file):
    return open_run(run_file)


def test_joints_shown_are_those_recorded(run, drive):
    """To the last bit; the bar is 1e-6 rad."""
    recorded = np.stack([s.frame.q for s in drive.samples])
    model = run.model()
    shown = run.qpos(model)[:, addresses(model).qpos]
    assert shown.shape == (120, 22)
    np.testing.assert_array_equal(shown, recorded)
    np.testing.assert_array_equal(run.q, recorded)


def test_the_five_bars_are_closed_in_every_picture(run):
    model = run.model()
    data, worst = mujoco.MjData(model), 0.0
    for row in run.qpos(model):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        for limb in LIMBS:
            a, b = (data.site(f"{limb}_loop_{end}").xpos for end in ("coupler", "distal"))
            worst = max(worst, float(np.linalg.norm(a - b)))
    assert worst < 1e-6


def test_a_configuration_is_the_one_of_the_model_room(run):
    model = run.model()
    for of, track in (("true", run.true), ("believed", run.believed)):
        row = run.qpos(model, of)[77]
        expected = configuration(model, run.q[77], p=track.p_M[77], quat=track.q_M[77])
        np.testing.assert_array_equal(row, expected)


def test_the_scene_comes_from_the_log_and_is_the_one_driven(run, drive):
    """No map file is asked for; the geoms are the same ones at the same places."""
    model, drawn = run.model(), mujoco.MjModel.from_xml_string(drive.scene)
    names = [model.geom(i).name for i in range(model.ngeom)]
    assert names == [drawn.geom(i).name for i in range(drawn.ngeom)]
    assert any(name.startswith("wall_") for name in names)
    np.testing.assert_array_equal(model.geom_pos, drawn.geom_pos)
    assert run.about.map == "demo"
    assert run.about.seed == 3
    assert run.about.variation == {**drive.about.variation, "trunk_com": list(_com(drive))}
    assert run.about.versions == {"a": "1"}


def _com(drive):
    return drive.about.variation["trunk_com"]


def test_a_log_without_a_scene_says_so_and_gives_an_empty_floor(nouns, tmp_path):
    recorder = McapRecorder()
    recorder.step(0, frame=nouns["frame"], belief=nouns["belief"])
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    assert "holds no scene" in run.notes[0]
    assert run.model().geom("floor").name == "floor"


def test_truth_and_belief_stand_beside_each_joint_row(run, drive):
    every = slice(0, None, 2)  # the truth is recorded at 30 Hz, the belief at 60
    true = np.stack([x.p_OB for x in drive.truths])
    np.testing.assert_allclose(run.true.p_M[every], true[every], atol=1e-12)
    np.testing.assert_allclose(run.true.p_M[1:-1], true[1:-1], atol=2e-3)
    believed = np.stack([s.belief.p_OB for s in drive.samples])
    np.testing.assert_allclose(run.believed.p_M, believed, atol=1e-12)
    q, v, w = (np.stack([getattr(s.belief, k) for s in drive.samples]) for k in _STATE)
    v_H, w_H = heading_twist(BODIES["crawl"], q, v, w)
    np.testing.assert_allclose(run.believed.twist_H[:, :2], v_H[:, :2], atol=1e-9)
    np.testing.assert_allclose(run.believed.twist_H[:, 2], w_H[:, 2], atol=1e-9)


_STATE = ("q_OB", "v_B", "w_B")


def test_commands_modes_contacts_and_wrenches_are_held_between_their_messages(run, drive):
    np.testing.assert_array_equal(run.cmd_twist_H, np.tile([0.4, 0.0, 0.3], (120, 1)))
    assert set(run.modes) == {"crawl"}
    even = slice(0, None, 2)
    contact = np.stack([s.belief.contact for s in drive.samples])
    wrench = np.stack([s.frame.wrench_S for s in drive.samples])
    target = np.stack([s.sent.q for s in drive.samples])
    for got, want in (
        (run.contact, contact),
        (run.wrench_S, wrench),
        (run.q_target, target),
    ):
        np.testing.assert_array_equal(got[even], want[even])
        np.testing.assert_array_equal(got[1::2], want[even])
    power = [np.abs(s.frame.torque) @ np.abs(s.frame.dq) for s in drive.samples]
    np.testing.assert_allclose(run.power, power)


def test_nobody_can_write_into_a_run(run):
    for array in (run.t, run.q, run.true.p_M, run.true.q_M, run.contact, run.cmd_twist_H):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_belief_is_put_into_the_map_by_the_pose_of_odom(nouns, tmp_path):
    """By hand: odom at (5, 6) turned by 90 deg; (0.1, 0.2) in it is (4.8, 6.1) in the map."""
    recorder = McapRecorder()
    recorder.once(pose_MO=nouns["pose_MO"])
    recorder.step(0, frame=nouns["frame"], belief=nouns["belief"])
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    np.testing.assert_allclose(run.believed.p_M[0], [4.8, 6.1, 0.3], atol=1e-12)
    # 90 deg and 90 deg more: half a turn about z
    np.testing.assert_allclose(np.abs(run.believed.q_M[0]), [0, 0, 0, 1], atol=1e-12)


def test_plans_and_obstacles_are_those_in_force(nouns, tmp_path):
    grid, first = nouns["grid"], nouns["plan"]
    cells = np.array([[1, 1], [0, 1]])
    later = Plan(cells, (Mode.CRAWL,), grid.center_of(cells), "feasible", 1.0, 2.0, 0.5)
    recorder = McapRecorder()
    recorder.once(grid=grid, plan=first, obstacles=nouns["obstacles"])
    recorder.once(stamp=0.5, plan=first)  # the last one said at a moment counts
    recorder.once(stamp=0.5, plan=later, obstacles=nouns["obstacles"][::-1])
    for tick in range(0, 600, 10):
        recorder.step(tick, frame=nouns["frame"], truth=nouns["truth"])
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    assert [t for t, _ in run.plans] == [0.0, 0.5]
    assert run.plan_at(0.49).modes == first.modes
    now = run.plan_at(0.5)
    assert (now.modes, now.status, now.gap, now.solve_s) == ((Mode.CRAWL,), "feasible", 1.0, 0.5)
    np.testing.assert_array_equal(now.cells, cells)
    np.testing.assert_allclose(now.xy_M, later.xy_M)
    np.testing.assert_array_equal(run.mocap_at(0.2), nouns["obstacles"])
    np.testing.assert_array_equal(run.mocap_at(0.9), nouns["obstacles"][::-1])
    np.testing.assert_array_equal(run.grid.blocked, grid.blocked)
    assert (run.at(-1.0), run.at(0.5), run.at(99.0)) == (0, 30, 59)


def test_other_joints_than_the_robots_are_refused_by_name(nouns, tmp_path, monkeypatch):
    monkeypatch.setattr("mobius.bridge.to_ros._ALL_NAMES", ["left_elbow", *JOINTS[1:], *PASSIVE])
    recorder = McapRecorder()
    recorder.step(0, frame=nouns["frame"])
    recorder.save(tmp_path / "run.mcap")
    with pytest.raises(
        InvalidInput, match=r"run\.mcap: /joint_states: .*at odds: left_elbow, left_sh"
    ):
        open_run(tmp_path / "run.mcap")


def test_another_type_under_a_known_name_is_refused(nouns, tmp_path, monkeypatch):
    monkeypatch.setattr("mobius.bridge.log_file.topic", lambda name: TOPICS["/clock"])
    recorder = McapRecorder()
    recorder.write("/joint_states", nouns["frame"], stamp=0.0)
    recorder.save(tmp_path / "run.mcap")
    with pytest.raises(InvalidInput, match=r"expected sensor_msgs/msg/JointState in cdr, got rosg"):
        open_run(tmp_path / "run.mcap")


def test_a_log_without_joints_or_trunk_says_what_it_lacks(nouns, tmp_path):
    recorder = McapRecorder()
    recorder.step(0, belief=nouns["belief"])
    recorder.save(tmp_path / "run.mcap")
    with pytest.raises(InvalidInput, match=r"expected /joint_states, got /clock, /mobius/contacts"):
        open_run(tmp_path / "run.mcap")
    recorder = McapRecorder()
    recorder.step(0, frame=nouns["frame"])
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    assert run.true is None
    assert run.contact is None
    assert run.modes == ("",)
    with pytest.raises(InvalidInput, match="holds no trunk pose; it has neither /odom"):
        run.qpos(run.model())


def test_a_folder_means_the_log_in_it(run_file, tmp_path):
    assert find_log(run_file.parent) == run_file
    with pytest.raises(InvalidInput, match=r"no such run folder or log. Did you mean 'run\.mcap'"):
        find_log(tmp_path / "run.mcp")
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InvalidInput, match=r"with run\.mcap in it"):
        find_log(empty)
    for name in "ab":
        (empty / f"{name}.mcap").write_bytes(b"")
    with pytest.raises(InvalidInput, match=r"several logs; name one of a\.mcap, b\.mcap"):
        find_log(empty)


def test_foxglove_finds_the_encodings_it_knows(run_file):
    """Schema ``package/msg/Name`` as ros2msg, messages as cdr, the profile ros2, an index."""
    with open(run_file, "rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        channels = summary.channels.values()
        assert {c.message_encoding for c in channels} == {"cdr"}
        assert {s.encoding for s in summary.schemas.values()} == {"ros2msg"}
        for channel in channels:
            assert summary.schemas[channel.schema_id].name == TOPICS[channel.topic].type
            assert channel.metadata["topic_type_hash"].startswith("RIHS01_")
        assert summary.statistics.message_count == sum(read_log(run_file).counts.values())
        (scene,) = reader.iter_attachments()
        assert scene.name == "scene.xml.gz"


def test_the_summary_tells_time_modes_way_and_topics(run, drive):
    text = "\n".join(describe(run))
    assert "map      demo, seed 3, a 1" in text
    assert "time     0.00 to 1.98 s, 120 samples, complete" in text
    assert "modes    crawl 2.0 s" in text
    assert "falls    not known" in text
    assert "/joint_states                 120  sensor_msgs/msg/JointState" in text
    way = np.diff(np.stack([x.p_OB[:2] for x in drive.truths[::2]]), axis=0)
    assert run.distance == pytest.approx(np.linalg.norm(way, axis=1).sum(), rel=0.02)


def test_the_twist_of_a_biped_is_along_its_own_forward(tmp_path, nouns):
    """Upright, the trunk's -z is ahead: -1 m/s along z_B is 1 m/s forward."""
    upright = StateEstimate(
        stamp=0.0,
        p_OB=np.zeros(3),
        q_OB=rpy_to_quat(0.0, -np.pi / 2, 0.0),
        v_B=np.array([0.0, 0.0, -1.0]),
        w_B=np.zeros(3),
        contact=np.zeros(4),
    )
    recorder = McapRecorder()
    command = ModeCommand(Mode.BIPED, np.zeros(3), 0.0)
    recorder.step(0, frame=nouns["frame"], truth=upright, command=command)
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    assert run.modes == ("biped",)
    np.testing.assert_allclose(run.true.twist_H[0], [1.0, 0.0, 0.0], atol=1e-12)


def test_held_values_are_the_last_ones_said():
    assert latest([0.0, 1.0], [-1.0, 0.0, 0.9, 1.0, 5.0]).tolist() == [0, 0, 0, 1, 1]
    assert held([], [], np.zeros(3)) is None
    np.testing.assert_array_equal(held([0.0, 1.0], [[1], [2]], np.array([0.5, 1.0])), [[1], [2]])


def test_poses_between_two_go_the_shorter_way():
    np.testing.assert_allclose(
        between([0.0, 1.0], [[0, 10], [4, 20]], np.array([0.25])), [[1, 12.5]]
    )
    a, b = rpy_to_quat(0, 0, 0.0), -rpy_to_quat(0, 0, 0.2)  # the same rotation, other sign
    half = turned_between([0.0, 1.0], [a, b], np.array([0.5]))[0]
    np.testing.assert_allclose(half, rpy_to_quat(0, 0, 0.1), atol=1e-12)


def test_a_pose_of_odom_that_stays_out_leaves_the_belief_as_it_is(nouns, tmp_path):
    recorder = McapRecorder()
    recorder.once(pose_MO=Pose(p=np.zeros(3), q=np.array([1.0, 0, 0, 0])))
    recorder.step(0, frame=nouns["frame"], belief=nouns["belief"])
    recorder.save(tmp_path / "run.mcap")
    run = open_run(tmp_path / "run.mcap")
    np.testing.assert_allclose(run.believed.p_M[0], nouns["belief"].p_OB, atol=1e-15)


def test_a_bag_of_another_recorder_reads_as_well(nouns, tmp_path):
    """Written by rosbags, without compression, with a topic that is not ours."""
    bag = Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
    with bag:
        for name, topic in (("/joint_states", "/joint_states"), ("/battery", "/clock")):
            connection = bag.add_connection(name, TOPICS[topic].type, typestore=STORE)
            bag.write(connection, 5_000_000_000, encode(topic, nouns[TOPICS[topic].noun]))
    run = open_run(tmp_path / "bag")
    assert run.t.tolist() == [5.0]
    np.testing.assert_array_equal(run.q[0], nouns["frame"].q)
    assert run.counts == {"/battery": 1, "/joint_states": 1}
    assert "/battery                        1  not read by mobius" in describe(run)


def test_a_bag_of_the_live_topics_reads_though_others_speak_in_it(nouns, tmp_path):
    """As ros2 bag record -a leaves it: a teleop's Twist, and robot_state_publisher's frames."""
    ours = TOPICS["/tf_static"].to_ros(nouns["pose_MO"])
    others = STORE.types["tf2_msgs/msg/TFMessage"](transforms=ours.transforms[1:])
    stamped = TOPICS["/mobius/command"].to_ros(nouns["command"])
    bag = Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
    with bag:
        for name, *messages in (
            ("/tf_static", others, ours),
            ("/cmd_vel", stamped.twist),
            ("/mobius/command", stamped),
            ("/joint_states", TOPICS["/joint_states"].to_ros(nouns["frame"])),
            ("/odom", TOPICS["/odom"].to_ros(nouns["belief"])),
        ):
            kind = messages[0].__msgtype__
            connection = bag.add_connection(name, kind, typestore=STORE)
            for message in messages:
                bag.write(connection, 5_000_000_000, STORE.serialize_cdr(message, kind))
    run = open_run(tmp_path / "bag")
    np.testing.assert_array_equal(run.cmd_twist_H[0], nouns["command"].twist_H)
    pose, belief = nouns["pose_MO"], nouns["belief"]
    np.testing.assert_allclose(run.believed.p_M[0], pose.p + rotate(pose.q, belief.p_OB))
