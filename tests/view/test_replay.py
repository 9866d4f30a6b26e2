"""A recorded run in the viewer's hands."""

from dataclasses import replace

import numpy as np
import pytest

from mobius.bridge.about import About
from mobius.bridge.read_run import open_run
from mobius.mission import run as run_mission
from mobius.model.robot import addresses
from mobius.view.live.nouns import Freeze, Reset, Snapshot, Way
from mobius.view.live.visited import Visited
from mobius.view.replay import Play, Player, Seek, plotted


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "arena"
    run_mission("arena", out, video=False)
    return open_run(out)


@pytest.fixture
def player(run):
    return Player(run, clock=Clock())


def step(player, seconds):
    player._clock.now += seconds
    return list(player.come())


def test_joints_shown_are_those_recorded(run, player):
    at = addresses(player.model).qpos
    worst = 0.0
    for row in range(0, len(run), 7):
        player.send(Seek(float(run.t[row])))
        snapshot = step(player, 0.0)[-1]
        worst = max(worst, float(np.abs(snapshot.qpos[at] - run.q[row]).max()))
    assert worst <= 1e-6


def test_time_goes_on_at_its_speed_and_ends_with_the_log(run, player):
    step(player, 1.0)
    assert player.t == pytest.approx(run.t[0] + 1.0)
    player.send(Play(True, 2.0))
    step(player, 1.0)
    assert player.t == pytest.approx(run.t[0] + 3.0)
    player.send(Freeze(True))
    step(player, 5.0)
    assert player.t == pytest.approx(run.t[0] + 3.0)
    player.send(Play(True, 4.0))
    step(player, 1e4)
    assert player.t == run.t[-1] and not player.playing
    player.send(Reset())
    assert player.t == run.t[0]


def test_the_slider_stays_within_the_log(run, player):
    player.send(Seek(-5.0))
    assert player.t == run.t[0]
    player.send(Seek(1e9))
    assert player.t == run.t[-1]


def test_the_plan_comes_once_and_the_robot_each_time(player):
    kinds = [type(x) for _ in range(5) for x in step(player, 0.1)]
    assert kinds.count(Way) == 1 and kinds.count(Snapshot) == 5


def test_true_and_believed_poses_are_the_logs(run, player):
    snapshot = step(player, 2.0)[-1]
    row = run.at(player.t)
    assert np.allclose(snapshot.true_pose[:3], run.true.p_M[row])
    assert np.allclose(snapshot.believed_pose[:3], run.believed.p_M[row])
    assert np.allclose(snapshot.twist[2], run.true.twist_H[row])


def test_the_curves_hold_every_number_of_the_tabs(run):
    t, rows = plotted(run, 4)
    assert rows.shape == (len(t), 18) and np.isfinite(rows).all()
    assert np.allclose(rows[:, 9], run.power[::4])


def test_squares_are_gathered_and_a_jump_back_starts_anew(player):
    visited = Visited()
    for _ in range(40):
        visited.see(player.first, step(player, 0.25)[-1])
    assert len(visited.squares) >= 3
    player.send(Reset())
    visited.see(player.first, step(player, 0.0)[-1])
    assert len(visited.squares) == 1


def test_a_frame_forward_shows_the_next_row_and_no_other(run, player):
    """Log times are whole nanoseconds: a sixtieth on top of one can fall short of the next."""
    player.send(Play(False))
    player.send(Reset())
    for row in range(1, 200):
        player.send(Seek(player.beside(1)))
        assert run.at(player.t) == row
    player.send(Seek(player.beside(-1)))
    assert run.at(player.t) == 198
    assert player.beside(-(10**6)) == run.t[0] and player.beside(10**6) == run.t[-1]


def test_play_at_the_end_begins_again(run, player):
    player.send(Seek(1e9))
    step(player, 0.1)
    assert not player.playing
    player.send(Play(True))
    step(player, 1.0)
    assert player.playing and player.t == pytest.approx(run.t[0] + 1.0)


def test_obstacles_are_left_out_where_the_log_holds_no_scene_with_them(run):
    """The empty floor has no bodies to put them at, and Studio would end at that."""
    poses = np.tile([1.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0], (2, 1))
    bare = Player(replace(run, about=About(), obstacles=((0.0, poses),)), clock=Clock())
    assert bare.model.nmocap == 0
    assert bare.snapshot(0).mocap is None
