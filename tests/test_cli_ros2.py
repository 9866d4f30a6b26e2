"""``mobius ros2`` and ``mobius model``: mistakes in one line, files whole or absent."""

import os
import signal
import time
import xml.etree.ElementTree as ET

import mujoco
import pytest

from mobius.cli import main
from mobius.cli.ros2 import advice, ends_between_ticks


def run(capsys, *argv: str) -> tuple[int, str, str]:
    try:
        code = main(list(argv))
    except SystemExit as stop:  # the parser's own errors
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (("--map", "dmeo"), "Did you mean 'demo'"),
        (("--start", "1", "1"), "--start: expected a --map"),
        (("--seconds", "0"), "--seconds: expected seconds > 0"),
        (("--seconds", "nan"), "--seconds"),
        (("--domain", "233"), "--domain: expected a whole number from 0 to 232, got '233'"),
        (("--domain", "-1"), "--domain"),
        (("--speed", "2"), "speed: expected a share in (0, 1], got 2"),
        (("--deadman", "-1"), "--deadman"),
        (("--record", "log.bag"), "--record: expected a file that ends in .mcap"),
        (("--modes", ""), "--modes: expected at least crawl or biped, got none"),
        (("--modes", "crwl"), "Did you mean 'crawl'"),
        (("--listen", "bla", "--seconds", "1"), "expected free addresses such as"),
        (("--policy", "nowhere.onnx"), "nowhere.onnx"),
    ],
)
def test_a_mistake_is_told_in_one_line(argv, says, capsys):
    code, out, err = run(capsys, "ros2", *argv)
    assert code == 2
    assert says in err
    assert err.count("\n") == 1
    assert not out


def test_the_domain_comes_from_the_environment_and_a_bad_one_is_told(capsys, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    code, _, err = run(capsys, "ros2", "--seconds", "1")
    assert code == 2
    assert "ROS_DOMAIN_ID: expected a whole number from 0 to 232, got 'many'" in err


def test_the_advice_names_domain_router_and_a_goal_only_with_a_map():
    text = advice(7, ("tcp/127.0.0.1:7447",), with_map=True)
    assert "ROS_DOMAIN_ID=7" in text and "rmw_zenohd" in text and "/goal_pose" in text
    assert "/goal_pose" not in advice(7, ("tcp/127.0.0.1:7447",), with_map=False)


def test_a_short_run_says_how_well_it_kept_time_and_leaves_a_log(capsys, tmp_path):
    log = tmp_path / "run.mcap"
    code, out, _ = run(
        capsys, "ros2", "--seconds", "0.3", "--modes", "crawl", "--record", str(log),
        "--connect", "tcp/127.0.0.1:1",
    )  # fmt: skip
    assert code == 0
    assert "x real time" in out and "mobius is a node of ROS domain 0" in out
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]


def test_the_model_is_written_as_urdf_and_as_mjcf(capsys, tmp_path):
    urdf, mjcf = tmp_path / "a.urdf", tmp_path / "a.xml"
    assert run(capsys, "model", "--out", str(urdf))[0] == 0
    assert run(capsys, "model", "--to", "mjcf", "--out", str(mjcf))[0] == 0
    assert ET.parse(urdf).getroot().tag == "robot"
    assert mujoco.MjModel.from_xml_path(str(mjcf)).nu == 22


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        (("--out", "robot.xml"), "--out: expected a file that ends in .urdf"),
        (("--to", "mjcf", "--out", "robot.urdf"), "--out: expected a file that ends in .xml"),
    ],
)
def test_a_wrong_ending_is_refused(argv, says, capsys):
    code, _, err = run(capsys, "model", *argv)
    assert code == 2 and says in err


def test_what_fails_before_the_robot_turns_leaves_no_log(capsys, tmp_path):
    log = tmp_path / "run.mcap"
    code, _, err = run(
        capsys, "ros2", "--modes", "crawl", "--record", str(log), "--listen", "bla",
    )  # fmt: skip
    assert (code, err.count("\n")) == (2, 1)
    assert not log.exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_noted_and_a_second_one_ends_the_program(number):
    before = signal.getsignal(number)
    with ends_between_ticks() as ended:
        os.kill(os.getpid(), number)
        assert ended.wait(5)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), number)
            time.sleep(5)
    assert signal.getsignal(number) is before
