"""Every motion can be shown, and a short show runs through the whole stack."""

import numpy as np
import pytest

from mobius.errors import UnknownName
from mobius.modes import load_motion, motion_names
from mobius.reel import SHOWS, Act, play
from mobius.reel.shows import REEL, Show, shortened, show_of
from mobius.reel.write import as_json, captions, motion_rows, reel_rows, stretches
from mobius.types import Mode


@pytest.fixture(scope="module")
def footage():
    """0.4 s of standing in crawl."""
    return play(Show("short", "", "crawl", (Act(Mode.CRAWL, 0.4),)), seed=3)


def test_every_shipped_motion_has_a_show_and_every_show_a_motion():
    assert set(SHOWS) == set(motion_names())


def test_the_reel_has_all_modes_and_a_fall():
    asked = {act.mode for act in REEL.acts}
    assert asked == {Mode.CRAWL, Mode.BIPED, Mode.ROLL, Mode.PUSH_UPS}
    assert sum(act.mode is Mode.ROLL for act in REEL.acts) == 2
    assert any(act.shove for act in REEL.acts)


def test_a_misspelt_show_is_refused_with_the_right_name():
    with pytest.raises(UnknownName, match="Did you mean 'roll'"):
        show_of("rol")


def test_a_motion_that_is_not_there_is_named():
    with pytest.raises(UnknownName, match="roll"):
        play(SHOWS["roll"], motions={"push_ups": load_motion("push_ups")})


def test_shortened_push_ups_are_the_first_of_them():
    whole, few = load_motion("push_ups"), shortened(load_motion("push_ups"), 3)
    assert len(few.stages) == 3 * 2  # down and up, three times
    assert len(whole.stages) >= 20 * 2
    assert few.stages == whole.stages[: len(few.stages)]
    once = load_motion("roll")
    assert shortened(once, 3).stages == once.stages


def test_a_show_is_recorded_at_30_hz_to_its_end(footage):
    assert not footage.failed
    np.testing.assert_allclose(np.diff(footage.t), 1 / 30)
    assert 0.35 <= footage.t[-1] <= 0.45
    n = len(footage.t)
    assert len(footage.qpos) == len(footage.com) == len(footage.modes) == len(footage.support) == n
    assert set(footage.modes) == {Mode.CRAWL}


def test_a_standing_robot_stands_within_its_support_and_hides_nothing(footage):
    from mobius.reproduce.fig_13 import outside

    assert outside(footage.com[-1, :2], footage.support[-1]) < -0.05
    faults = footage.faults[Mode.CRAWL]
    assert 0 < faults.into_floor < 0.003 and faults.into_itself == 0.0
    assert (faults.pressed_s > 0.3).all()


def test_captions_tell_time_and_mode(footage):
    assert captions(footage)[0].split() == ["0.0", "s", "crawl"]


def test_rows_of_a_reel_cover_every_stretch(footage):
    footage.modes[4:8] = 4 * [Mode.ROLL]
    try:
        assert [s[0] for s in stretches(footage)] == [Mode.CRAWL, Mode.ROLL, Mode.CRAWL]
        rows = reel_rows(footage)
        assert rows == sorted(rows) and {footage.modes[k] for k in rows} == set(footage.modes)
        shown = motion_rows(footage, 5)
        assert shown[0] <= 4 and shown[-1] >= 7
    finally:
        footage.modes[4:8] = 4 * [Mode.CRAWL]


def test_the_json_says_what_was_asked_and_what_came(footage):
    show = Show("short", "", "crawl", (Act(Mode.CRAWL, 0.4), Act(Mode.ROLL)))
    told = as_json(show, footage, 3)
    assert told["complete"] and told["seed"] == 3 and told["events"] == []
    assert [a["begins_s"] for a in told["acts"]] == [0.0, None]
    assert set(told["faults"]) == {"crawl"}
