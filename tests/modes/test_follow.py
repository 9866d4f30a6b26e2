"""The follower and the mode machine, with a point robot that obeys perfectly."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.geometry import rpy_to_quat
from mobius.modes import SUCCESSORS, FollowerConfig, ModeMachine, PathFollower
from mobius.types import Mode, ModeCommand, Plan, StateEstimate


def plan_of(*xy: tuple[float, float]) -> Plan:
    xy_M = np.array(xy, dtype=float)
    cells = np.round(xy_M / 0.5).astype(int)
    modes = (Mode.CRAWL,) * (len(xy) - 1)
    return Plan(cells, modes, xy_M, "optimal", 0.0, 0.0, 0.0)


L_SHAPE = plan_of((0, 0), (1, 0), (2, 0), (2, 1), (2, 2))


def belief(p, yaw, t) -> StateEstimate:
    q = rpy_to_quat(0.0, 0.0, yaw)
    zero = np.zeros(3)
    return StateEstimate(t, [*p, 0.27], q, zero, zero, np.ones(4))


def walk(plan: Plan, *, start=(0.0, 0.0), yaw=0.0, seconds=40.0, drift=(0.0, 0.0)):
    """A robot that carries out the twist exactly, plus a constant drift [m/s]."""
    follower = PathFollower(plan)
    p, t, track, twists = np.array(start, dtype=float), 0.0, [], []
    while t < seconds and not follower.arrived:
        twist = follower.command(belief(p, yaw, t), 1 / 60).twist_H
        c, s = np.cos(yaw), np.sin(yaw)
        p = p + (np.array([[c, -s], [s, c]]) @ twist[:2] + drift) / 60
        yaw += twist[2] / 60
        t += 1 / 60
        track.append(p)
        twists.append(twist)
    return follower, np.array(track), np.array(twists)


def test_arrives_at_the_end_of_the_path():
    follower, track, _ = walk(L_SHAPE)
    assert follower.arrived
    assert np.linalg.norm(track[-1] - [2, 2]) <= FollowerConfig().tolerance
    assert follower.length == pytest.approx(4.0)


def test_stays_close_to_the_path():
    _, track, _ = walk(L_SHAPE)
    to_first = np.abs(track[:, 1]) + np.maximum(track[:, 0] - 2, 0)
    to_second = np.abs(track[:, 0] - 2) + np.maximum(-track[:, 1], 0)
    assert np.minimum(to_first, to_second).max() < 0.12


def test_comes_back_from_beside_and_from_the_wrong_heading():
    follower, track, _ = walk(L_SHAPE, start=(0.0, 0.3), yaw=np.pi)
    assert follower.arrived
    assert np.linalg.norm(track[-1] - [2, 2]) < 0.1


def test_holds_against_a_drift():
    follower, track, _ = walk(L_SHAPE, drift=(0.0, -0.05))
    assert follower.arrived
    assert track[track[:, 0] < 1.5][:, 1].min() > -0.15


def test_twist_and_its_change_are_bounded():
    cfg = FollowerConfig()
    _, _, twists = walk(L_SHAPE, yaw=2.0)
    assert np.linalg.norm(twists[:, :2], axis=1).max() <= cfg.speed + 1e-9
    assert np.abs(twists[:, 2]).max() <= cfg.turn_rate + 1e-9
    assert np.abs(np.diff(twists[:, :2], axis=0)).max() <= cfg.acceleration / 60 + 1e-9


def test_after_arrival_it_stands():
    follower, track, _ = walk(L_SHAPE)
    for k in range(60):
        command = follower.command(belief(track[-1], 1.57, 50 + k / 60), 1 / 60)
    np.testing.assert_allclose(command.twist_H, 0.0, atol=1e-12)


def test_a_plan_that_stays_arrives_at_once():
    follower = PathFollower(plan_of((1.0, 1.0)))
    follower.command(belief((1.0, 1.0), 0.0, 0.0), 1 / 60)
    assert follower.arrived


def test_without_room_it_goes_sideways_and_does_not_turn():
    """In a lane of 0.35 m it keeps its sides to the grid; heading 0 all along the L."""
    follower = PathFollower(L_SHAPE, room=lambda p: 0.35)
    p, yaw, yaws = np.array([0.0, 0.0]), 0.1, []
    for k in range(60 * 60):
        twist = follower.command(belief(p, yaw, k / 60), 1 / 60).twist_H
        c, s = np.cos(yaw), np.sin(yaw)
        p = p + np.array([[c, -s], [s, c]]) @ twist[:2] / 60
        yaw += twist[2] / 60
        yaws.append(yaw)
        if follower.arrived:
            break
    assert follower.arrived
    assert np.abs(yaws[120:]).max() < 0.02
    assert np.linalg.norm(p - [2, 2]) < 0.1


def test_modes_follow_the_plan():
    xy = np.array([[0, 0], [1, 0], [2, 0]], dtype=float)
    plan = Plan(np.array([[0, 0], [1, 0], [2, 0]]), ("crawl", "biped"), xy, "optimal", 0, 0, 0.0)
    follower = PathFollower(plan)
    assert follower.command(belief((0.1, 0), 0, 0), 1 / 60).mode is Mode.CRAWL
    follower._progress = 1.6
    assert follower.mode() is Mode.BIPED


def command(mode: Mode) -> ModeCommand:
    return ModeCommand(mode, [0.1, 0, 0], 0.0)


def test_machine_lets_the_available_through_and_explains_the_rest():
    machine = ModeMachine(frozenset({Mode.CRAWL}))
    assert machine.step(command(Mode.CRAWL)).mode is Mode.CRAWL
    with pytest.raises(InvalidInput, match="no controller yet; available: crawl"):
        machine.step(command(Mode.BIPED))


def test_machine_refuses_a_jump_between_bodies():
    machine = ModeMachine(frozenset({Mode.CRAWL, Mode.BIPED}))
    assert machine.step(command(Mode.BIPED)).mode is Mode.CRAWL
    assert "may not follow 'crawl'" in machine.notice


def test_emergency_stop_stands_still_for_good():
    machine = ModeMachine(frozenset({Mode.CRAWL}))
    machine.emergency_stop()
    for mode in (Mode.CRAWL, Mode.BIPED):  # even for a mode it could not switch to
        stopped = machine.step(command(mode))
        assert stopped.mode is Mode.STOP
        np.testing.assert_array_equal(stopped.twist_H, 0.0)


def test_every_mode_may_stay_and_recover():
    assert set(SUCCESSORS) == set(Mode)
    for mode, following in SUCCESSORS.items():
        assert mode in following and Mode.RECOVER in following
