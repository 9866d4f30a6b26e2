"""One whole run on the shipped arena: planned, driven, judged, recorded."""

import json
import os
import signal
import subprocess
import sys
import time

import mujoco
import numpy as np
import pytest

from mobius import mission
from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.bridge.read_run import open_run
from mobius.errors import InvalidInput
from mobius.geometry import heading_yaw
from mobius.model import JOINTS
from mobius.model.passive import PASSIVE
from mobius.model.poses import stance_keyframe
from mobius.model.robot import addresses, keyframe, load_model
from mobius.modes import ModeMachine
from mobius.modes.follow import CRAWLING
from mobius.results import staged
from mobius.robot import TICK
from mobius.robot.sim import SimRobot
from mobius.stack import Judge, Stack
from mobius.train.presets import WIDE
from mobius.types import JointCommand, Mode, ModeCommand

KEYS = {
    "goal_reached",
    "final_distance_m",
    "falls",
    "collisions",
    "sim_time_s",
    "wall_time_s",
    "real_time_factor",
    "path_length_m",
    "energy_J",
    "energy_per_cell_J",
    "cells_visited",
    "plan",
    "estimator",
    "seed",
    "versions",
}


@pytest.fixture(scope="module")
def outcome(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "arena"
    return mission.run("arena", out, seed=3, video=False)


def test_the_robot_reaches_its_goal(outcome):
    s = outcome.summary
    assert s["goal_reached"] and s["falls"] == 0 and s["collisions"] == 0
    assert s["final_distance_m"] <= mission.ARRIVE_WITHIN
    assert s["plan"]["status"] == "optimal"


def test_summary_holds_what_it_must(outcome):
    written = json.loads(outcome.files["summary.json"].read_text())
    assert set(written) >= KEYS
    assert set(written["plan"]) == {"objective", "bound", "status", "solve_ms", "modes"}
    assert set(written["estimator"]) == {
        "position_rmse_m",
        "yaw_rmse_rad",
        "velocity_rmse_mps",
    }


def test_judged_by_the_truth_not_by_the_belief(outcome):
    record, goal = outcome.record, outcome.record.plan.xy_M[-1]
    end = np.linalg.norm(record.true_p[-1, :2] - goal)
    assert outcome.summary["final_distance_m"] == pytest.approx(end)
    assert np.abs(record.belief_p - record.true_p).max() > 1e-3  # the belief does err


def test_loops_stay_closed_while_crawling(outcome):
    assert outcome.summary["loop_residual_mm"] < 1.0


def test_energy_is_the_integral_of_power(outcome):
    record = outcome.record
    assert record.power[1:].sum() / 60 == pytest.approx(outcome.summary["energy_J"], rel=0.02)


def test_log_decodes_and_names_the_joints(outcome):
    from mcap_ros2.reader import read_ros2_messages

    path = str(outcome.files["run.mcap"])
    first = next(iter(read_ros2_messages(path, topics=["/joint_states"]))).ros_msg
    assert tuple(first.name) == (*JOINTS, *PASSIVE)
    topics = {m.channel.topic for m in read_ros2_messages(path)}
    known = {"/odom", "/cmd_vel", "/imu/data", "/plan", "/map", "/tf", "/tf_static"}
    assert known | {"/robot_description"} <= topics


def test_the_run_comes_back_from_its_log_as_it_was(outcome):
    """Joints within 1e-6 rad of the recorded ones; the picture is the simulator's own."""
    run, record = open_run(outcome.files["run.mcap"].parent), outcome.record
    model = run.model()
    qpos = run.qpos(model)
    assert np.abs(qpos[:, addresses(model).qpos] - record.q).max() <= 1e-6
    np.testing.assert_allclose(run.true.p_M[::2], record.true_p[::2], atol=1e-9)
    np.testing.assert_allclose(run.believed.twist_H, record.belief_twist_H, atol=1e-9)
    assert run.modes == tuple(record.modes)
    frames = np.arange(len(record.frame_qpos))
    apart = np.abs(qpos[2 * frames] - record.frame_qpos)
    assert apart[:, :3].max() < 2e-3  # a frame is a tick later
    assert apart[:, 7:].max() < 0.05  # encoder noise and soft loops
    assert (run.about.map, run.about.seed) == ("arena", 3)
    assert run.summary["falls"] == 0
    assert run.complete
    assert not run.notes


def test_report_is_self_contained(outcome):
    text = outcome.files["report.html"].read_text()
    assert "<script src" not in text and 'href="http' not in text and 'src="http' not in text
    assert len(text) < 3_000_000


def test_same_seed_same_run(tmp_path):
    world = mission.open_world("arena")
    plan = mission.plan_mission(world, [Mode.CRAWL])
    ends = [mission.drive(world, plan, seed=5)[0].true_p[-1] for _ in range(2)]
    np.testing.assert_array_equal(ends[0], ends[1])


RUN_ARENA = "import sys; from mobius.cli import main; sys.exit(main(sys.argv[1:]))"


def test_a_kill_leaves_whole_files_or_none(tmp_path):
    """Killed while files are being written: no folder of that name, and no half file."""
    from mcap_ros2.reader import read_ros2_messages

    out = tmp_path / "killed"
    args = ["run", "arena", "--no-video", "--out", str(out)]
    quiet = subprocess.DEVNULL
    child = subprocess.Popen([sys.executable, "-c", RUN_ARENA, *args], stdout=quiet, stderr=quiet)
    stage = tmp_path / f".killed.{child.pid}.partial"
    while child.poll() is None and not (stage / "plan.json").exists():
        time.sleep(0.005)
    os.kill(child.pid, signal.SIGKILL)
    child.wait()
    assert not out.exists()  # the folder gets its name when all is there
    json.loads((stage / "plan.json").read_text())
    if (stage / "run.mcap").exists():
        assert list(read_ros2_messages(str(stage / "run.mcap"), topics=["/odom"]))


def test_only_an_older_run_is_replaced(tmp_path):
    out = tmp_path / "demo"
    out.mkdir()
    (out / "summary.json").write_text("{}")
    with staged(out, replace=True) as stage:
        (stage / "summary.json").write_text('{"new": 1}')
        assert json.loads((out / "summary.json").read_text()) == {}  # until the very end
    assert json.loads((out / "summary.json").read_text()) == {"new": 1}
    with pytest.raises(InvalidInput, match="not empty"), staged(out):
        pass
    (out / "thesis.tex").write_text("years of work")
    with pytest.raises(InvalidInput, match="not empty"), staged(out, replace=True):
        pass
    assert sorted(p.name for p in tmp_path.iterdir()) == ["demo"]


def test_a_failure_leaves_no_folder(tmp_path):
    out = tmp_path / "broken"
    with pytest.raises(RuntimeError), staged(out) as stage:
        (stage / "plan.json").write_text("{}")
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_plan_file_holds_the_plan_that_was_proven(outcome):
    world = mission.open_world("arena")
    plan = mission.plan_mission(world, [Mode.CRAWL])
    written = json.loads(outcome.files["plan.json"].read_text())
    assert len(written["steps"]) == len(plan.cells)
    np.testing.assert_allclose([[s["x"], s["y"]] for s in written["steps"]], plan.xy_M)
    assert written["objective"] == plan.objective == outcome.summary["plan"]["objective"]


class Perfect:
    """Senses and estimator that know the truth."""

    def __init__(self, robot=None):
        self.robot = robot

    def corrupt(self, frame):
        return frame

    def take(self, frame):
        pass

    def belief(self):
        return self.robot.truth()


class Hold:
    """Keeps the joints where they are."""

    def reset(self):
        pass

    def act(self, command, belief, frame):
        return JointCommand(frame.q, frame.stamp)


@pytest.mark.parametrize(
    ("pose", "fallen"), [("crawl", False), ("prone", True), ("supine", True), ("on_head", True)]
)
def test_lying_is_judged_as_fallen(pose, fallen):
    robot = SimRobot(load_model("full"), keyframe=pose)
    stack = Stack(
        robot,
        senses=Perfect(),
        estimator=Perfect(robot),
        machine=ModeMachine(frozenset({Mode.CRAWL})),
        controllers={Mode.CRAWL: Hold()},
    )
    judge = Judge(robot)
    sample = stack.turn(lambda b: ModeCommand(Mode.CRAWL, np.zeros(3), b.stamp))
    assert sample is not None
    judge.see(sample)
    assert judge.fallen is fallen


def test_without_opengl_the_run_goes_on_without_video(tmp_path):
    """MUJOCO_GL names a back end that is not there: one line, all files but the video."""
    out = tmp_path / "run"
    done = subprocess.run(
        [sys.executable, "-c", RUN_ARENA, "run", "arena", "--out", str(out)],
        env={**os.environ, "MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "osmesa"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in done.stderr
    if (out / "video.mp4").exists():
        pytest.skip("OSMesa works here")
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert len(lines) == 1 and lines[0].startswith("no video: ") and "unset MUJOCO_GL" in lines[0]
    assert (out / "summary.json").exists() and (out / "report.html").exists()


def reach_of(model, data):
    """Corners (n, 2) [m] of the boxes around the robot's collision geometry, from its trunk."""
    signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
    corners = []
    for i in range(model.ngeom):
        if model.geom_contype[i] and model.geom(i).name != "floor":
            box = signs * model.geom_aabb[i, 3:] + model.geom_aabb[i, :3]
            corners.append(box @ data.geom_xmat[i].reshape(3, 3).T + data.geom_xpos[i])
    return np.concatenate(corners)[:, :2] - data.body("base_link").xpos[:2]


@pytest.mark.parametrize(
    ("stance", "footprint"),
    [
        (keyframe("crawl")[0], mission.NARROW),
        (keyframe("crawl")[0], mission.WIDE),
        (stance_keyframe(WIDE)[0], mission.WIDE),
    ],
)
def test_the_footprint_holds_the_stance(stance, footprint):
    """In every heading by the disc, heading along the grid by the lane with 2 cm to stray."""
    model = load_model("full")
    data = mujoco.MjData(model)
    data.qpos[:] = stance
    mujoco.mj_kinematics(model, data)
    xy = reach_of(model, data)
    assert np.linalg.norm(xy, axis=1).max() <= footprint.radius
    assert np.abs(xy).max() + 0.02 <= footprint.lane


@pytest.mark.parametrize("policy", ["flat", "rough"])
def test_the_lane_holds_the_crawl_and_the_disc_its_turn_on_the_spot(policy):
    """A crawl whose hands swing further out than they stand touched door frames."""
    footprint = mission.footprint_of(policy)
    assert footprint == {"flat": mission.WIDE, "rough": mission.NARROW}[policy]
    stack, robot = build_sim_stack(flat_model(), Start(randomised=False), policy=policy)
    half = radius = 0.0
    while stack.tick * TICK < 5.0:
        ahead = stack.tick * TICK < 2.5
        twist = [CRAWLING.speed, 0.0, 0.0] if ahead else [0.0, 0.0, 0.8]
        stack.turn(lambda b, t=twist: ModeCommand(Mode.CRAWL, t, b.stamp))
        if stack.tick % 20 == 0:
            xy = reach_of(robot.model, robot.data)
            if ahead:
                yaw = float(heading_yaw("crawl", robot.truth().q_OB))
                half = max(half, float(np.abs(xy @ [-np.sin(yaw), np.cos(yaw)]).max()))
            radius = max(radius, float(np.linalg.norm(xy, axis=1).max()))
    assert half <= footprint.lane
    assert radius <= footprint.radius + footprint.margin
