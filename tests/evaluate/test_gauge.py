"""Figures of motion, by hand: slip, chatter, lifts, torque, power."""

import numpy as np
import pytest

from mobius.assemble import flat_model
from mobius.control.bodies import body_of
from mobius.evaluate.gauge import DT, Gauge
from mobius.robot.sim import SimRobot


def column(*runs: tuple[int, int]) -> np.ndarray:
    """Values and how often each comes."""
    return np.concatenate([np.full(n, float(v)) for v, n in runs])[:, None]


def test_slip_counts_only_feet_on_the_ground(readings):
    contact = np.hstack([column((1, 300)), column((1, 150), (0, 150))])
    p = np.zeros((300, 3))
    p[:, 0] = np.linspace(0.0, 0.4, 300)
    seen = readings(contact, slide=np.full((300, 2), 0.02), p=p)
    slid, way = seen.slip(np.ones(300, dtype=bool))
    # foot one slides 0.02 m/s for 1 s, foot two for half of it: mean 0.015 m on 0.4 m
    assert slid == pytest.approx(0.015) and way == pytest.approx(0.4)


def test_the_way_is_straight_from_first_to_last(readings):
    p = np.zeros((5, 3))
    p[:, 1] = [0.0, 0.1, 0.0, 0.1, 0.0]
    assert readings(np.ones((5, 1)), p=p).slip(np.ones(5, dtype=bool)) == (0.0, 0.0)


def test_contacts_are_timed_from_begin_to_end_and_cut_ones_left_out(readings):
    contact = column((1, 30), (0, 10), (1, 6), (0, 10), (1, 60), (0, 5), (1, 40))
    times = readings(contact).contact_times()
    np.testing.assert_allclose(times, [6 / 300, 60 / 300])
    assert readings(contact).chatter() == (1, 2)
    # the short one begins at 40 / 300 s
    assert readings(contact).chatter(after_s=0.15) == (0, 1)


@pytest.mark.parametrize(("looks", "short"), [(14, 1), (15, 0)])
def test_chatter_is_shorter_than_a_twentieth_of_a_second(readings, looks, short):
    contact = column((0, 5), (1, looks), (0, 5))
    assert readings(contact).chatter() == (short, 1)
    assert looks * DT < 0.05 or not short


def test_a_touch_lighter_than_a_newton_is_no_contact(readings):
    assert not readings(np.full((4, 1), 0.9 / 50.0)).contact.any()
    assert readings(np.full((4, 1), 1.1 / 50.0)).contact.all()


def test_lifts_are_counted_within_the_rows(readings):
    contact = np.hstack([column((1, 4), (0, 4), (1, 4)), column((1, 10), (0, 2))])
    seen = readings(contact)
    assert seen.lifts(np.ones(12, dtype=bool)) == 2
    assert seen.lifts(np.arange(12) < 8) == 1


def test_torque_is_held_against_the_line_at_its_speed(readings):
    torque, dq = np.zeros((1, 20)), np.zeros((1, 20))
    torque[0, 0], dq[0, 0] = 6.0, 2.0  # drives: line 10 - 2 * 2 = 6
    torque[0, 1], dq[0, 1] = -5.0, 4.0  # brakes: line 10
    torque[0, 2] = 9.6  # beyond 95 % of stall
    seen = readings(np.ones((1, 2)), torque=torque, dq=dq)
    assert seen.torque_peak()[:3].tolist() == pytest.approx([1.0, 0.5, 0.96])
    assert seen.saturation() == pytest.approx(1 / 20)
    assert seen.power().tolist() == pytest.approx([12.0 + 20.0])
    assert seen.max_dq_rpm() == pytest.approx(4.0 * 60 / (2 * np.pi))


def test_height_is_held_against_the_stance_over_the_ground(readings):
    assert readings(np.ones((2, 1)), height=np.array([0.31, 0.26])).height_error() == (
        pytest.approx(0.04)
    )


@pytest.mark.parametrize("body", ["crawl", "biped"])
def test_a_standing_robot_reads_as_standing(body):
    robot = SimRobot(flat_model(), keyframe=body_of(body).keyframe)
    gauge = Gauge(robot, body=body, ground=lambda xy: np.full(xy.shape[:-1], 0.1))
    for _ in range(120):
        robot.wait()
        gauge.look()
    seen = gauge.readings()
    assert seen.force.shape == (120, len(body_of(body).feet))
    assert seen.force[-1].sum() == pytest.approx(10.3 * 9.81, rel=0.05)
    assert seen.contact[-1].all()
    assert seen.slide[-1].max() < 0.005
    # the ground is told to be 0.1 m high, so that the trunk seems 0.1 m too low
    assert seen.height_error() == pytest.approx(0.1, abs=0.005)
    np.testing.assert_array_equal(np.diff(seen.tick), 1)
