"""Motions as files: what is shipped loads, and a mistake names file and field."""

import json

import numpy as np
import pytest

from mobius.errors import InvalidInput, UnknownName
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import load_motion, motion_names, read_motion

CRAWL = keyframe_joints("crawl")[0].tolist()
STAGE = {"q": CRAWL, "seconds": 0.5}


def write(folder, **changes):
    document = {"name": "sit", "start": "crawling", "end": "prone", "stages": [STAGE]}
    path = folder / "sit.json"
    path.write_text(json.dumps({**document, **changes}))
    return path


@pytest.mark.parametrize("name", motion_names())
def test_every_shipped_motion_loads_under_its_name(name):
    motion = load_motion(name)
    assert motion.name == name and motion.seconds > 0.0


def test_push_ups_and_the_way_up_from_prone_are_shipped():
    assert {"push_ups", "prone_to_crawl"} <= set(motion_names())


def test_everything_a_stage_may_say_is_read(tmp_path):
    stage = {
        **STAGE,
        "hold": 0.2,
        "until": {"angle": "pitch_B", "below": -1.2},
        "timeout": 0.4,
        "feedback": [["left_ankle_pitch", 0.5, 0.05, -1.57]],
        "window": {"pitch": -1.0, "within": 0.6, "lean": 0.4},
        "note": "free text",
    }
    motion = read_motion(
        write(tmp_path, stages=[stage], guard={"error": 0.9, "seconds": 0.3}, note="x", repeat=3)
    )
    assert len(motion.stages) == 3 and motion.guard.error == 0.9
    read = motion.stages[0]
    np.testing.assert_array_equal(read.q, CRAWL)
    assert (read.hold, read.timeout, read.until.below) == (0.2, 0.4, -1.2)
    assert (read.feedback[0].joint, read.feedback[0].pitch) == ("left_ankle_pitch", -1.57)
    assert (read.window.pitch, read.window.within, read.window.lean) == (-1.0, 0.6, 0.4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "stand"}, "name: expected 'sit' as the file is called"),
        ({"speed": 2}, "unknown 'speed'"),
        ({"stages": []}, "at least one stage"),
        ({"stages": {}}, "stages: expected a list"),
        ({"repeat": 0}, "repeat: expected a whole number from 1"),
        ({"start": "asleep"}, "unknown posture 'asleep'"),
        ({"guard": {"error": -1}}, "Guard.error: expected a finite number"),
        ({"stages": [{"seconds": 1}]}, r"stages\[0\]: the stage: expected 'q', which is missing"),
        ({"stages": [STAGE, {**STAGE, "q": CRAWL[:3]}]}, r"stages\[1\]: Stage.q: expected shape"),
        ({"stages": [{**STAGE, "q": ["a"] * 22}]}, r"q: expected 22 numbers"),
        ({"stages": [{**STAGE, "q": [9.0] * 22}]}, "q of left_shoulder_yaw: expected -1.8326"),
        ({"stages": [{**STAGE, "until": {"above": 1}}]}, "until: expected 'angle'"),
        ({"stages": [{**STAGE, "feedback": [["left_hip_yaw", 1]]}]}, "feedback: expected a list"),
        ({"stages": [{**STAGE, "window": {"roll": 1}}]}, "window: unknown 'roll'"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_with_its_name(tmp_path, changes, message):
    with pytest.raises(InvalidInput, match=message) as caught:
        read_motion(write(tmp_path, **changes))
    assert str(caught.value).startswith("sit.json: ") and "\n" not in str(caught.value)


def test_what_is_no_json_or_not_there_is_said(tmp_path):
    (tmp_path / "sit.json").write_text("{")
    with pytest.raises(InvalidInput, match="not JSON"):
        read_motion(tmp_path / "sit.json")
    with pytest.raises(InvalidInput, match="cannot be read"):
        read_motion(tmp_path / "stand.json")


def test_an_unknown_name_gets_the_closest():
    with pytest.raises(UnknownName, match="Did you mean 'push_ups'"):
        load_motion("push_up")
