"""The log holds what was said, for two independent readers, and is whole or absent."""

import os
import signal
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from mobius.bridge.messages import TOPICS
from mobius.bridge.record import McapRecorder
from mobius.errors import InvalidInput, UnknownName
from mobius.model.joints import JOINTS
from mobius.model.passive import PASSIVE

LOGGED = {name: row for name, row in TOPICS.items() if row.where != "live"}
PERIODIC = ("frame", "belief", "command", "target", "truth")


def record_one_second(nouns, **options):
    recorder = McapRecorder(**options)
    recorder.once(**{row.noun: nouns[row.noun] for row in LOGGED.values() if row.latched})
    for tick in range(600):
        recorder.step(tick, **{name: nouns[name] for name in PERIODIC})
    return recorder


@pytest.fixture
def log(tmp_path, nouns):
    record_one_second(nouns).save(tmp_path / "run.mcap")
    return tmp_path / "run.mcap"


def test_one_second_holds_every_topic_as_often_as_the_table_says(log):
    with AnyReader([log]) as reader:
        counts = Counter(c.topic for c, _, _ in reader.messages())
    assert counts == {name: row.rate or 1 for name, row in LOGGED.items()}


def test_rosbags_reads_joint_names_and_values(log, nouns):
    with AnyReader([log]) as reader:
        wanted = [c for c in reader.connections if c.topic == "/joint_states"]
        messages = [reader.deserialize(d, c.msgtype) for c, _, d in reader.messages(wanted)]
    for message in messages:
        assert tuple(message.name) == (*JOINTS, *PASSIVE)
        np.testing.assert_array_equal(message.position[:22], nouns["frame"].q)


def test_mcap_ros2_reads_joint_names_and_values_too(log, nouns):
    """A reader that shares no code with the writer."""
    reader = pytest.importorskip("mcap.reader")
    decoder = pytest.importorskip("mcap_ros2.decoder")
    seen = Counter()
    with open(log, "rb") as file:
        source = reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        for _, channel, _, message in source.iter_decoded_messages():
            seen[channel.topic] += 1
            if channel.topic == "/joint_states":
                assert tuple(message.name) == (*JOINTS, *PASSIVE)
                assert list(message.effort[:22]) == nouns["frame"].torque.tolist()
            elif channel.topic == "/odom":
                assert message.pose.pose.position.y == 0.2
                assert message.pose.pose.orientation.w == np.sqrt(0.5)
            elif channel.topic == "/map":
                assert list(message.data) == [0, 0, 100, 0, 0, 0]
    assert set(seen) == set(LOGGED)


def test_log_times_are_those_of_the_ticks(log):
    with AnyReader([log]) as reader:
        wanted = [c for c in reader.connections if c.topic == "/joint_states"]
        times = [t for _, t, _ in reader.messages(wanted)]
    # 60 Hz: every tenth tick of 1/600 s
    assert times == [round(k / 60 * 1e9) for k in range(60)]


def test_map_plan_and_static_frames_are_offered_to_late_listeners(log):
    with AnyReader([log]) as reader:
        durability = {
            c.topic: c.ext.offered_qos_profiles[0].durability.name for c in reader.connections
        }
    latched = {name for name, kind in durability.items() if kind == "TRANSIENT_LOCAL"}
    assert latched == {name for name, row in LOGGED.items() if row.latched}
    assert latched >= {"/map", "/plan", "/tf_static", "/robot_description", "/mobius/obstacles"}


def test_a_noun_left_out_is_not_recorded(nouns, tmp_path):
    recorder = McapRecorder()
    recorder.step(0, belief=nouns["belief"])
    recorder.save(tmp_path / "run.mcap")
    with AnyReader([tmp_path / "run.mcap"]) as reader:
        assert {c.topic for c in reader.connections} == {
            "/clock",
            "/mobius/contacts",
            "/odom",
            "/tf",
        }


def test_only_the_topics_asked_for_are_recorded(nouns, tmp_path):
    record_one_second(nouns, topics=("/odom", "/map")).save(tmp_path / "run.mcap")
    with AnyReader([tmp_path / "run.mcap"]) as reader:
        assert {c.topic for c in reader.connections} == {"/odom", "/map"}


def test_a_topic_that_does_not_exist_is_refused():
    with pytest.raises(UnknownName, match="Did you mean '/odom'"):
        McapRecorder(topics=("/odo",))


def test_the_log_is_the_only_file_left(log):
    assert os.listdir(log.parent) == ["run.mcap"]


def test_the_same_run_gives_the_same_bytes(nouns, tmp_path):
    for name in ("a.mcap", "b.mcap"):
        record_one_second(nouns).save(tmp_path / name)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_an_empty_log_or_another_ending_is_refused_and_leaves_nothing(nouns, tmp_path):
    with pytest.raises(InvalidInput, match="nothing was recorded"):
        McapRecorder().save(tmp_path / "run.mcap")
    with pytest.raises(InvalidInput, match=r"run\.bag: expected a file name ending in \.mcap"):
        record_one_second(nouns).save(tmp_path / "run.bag")
    assert os.listdir(tmp_path) == []


def test_a_kill_while_saving_leaves_no_log(tmp_path):
    """The writer dies at its hundredth message; what it had made was in memory only."""
    code = """
import os, signal, sys
from mcap.writer import Writer
from mobius.bridge.record import McapRecorder
calls = 0
write = Writer.add_message
def dying(self, *args):
    global calls
    calls += 1
    if calls == 100:
        os.kill(os.getpid(), signal.SIGKILL)
    write(self, *args)
Writer.add_message = dying
recorder = McapRecorder()
for tick in range(60 * 600):
    recorder.step(tick)
recorder.save(sys.argv[1] + "/run.mcap")
"""
    env = {**os.environ, "TMPDIR": str(tmp_path)}
    out = tmp_path / "out"
    out.mkdir()
    done = subprocess.run([sys.executable, "-c", code, str(out)], env=env, check=False)
    assert done.returncode == -signal.SIGKILL
    assert os.listdir(out) == []
