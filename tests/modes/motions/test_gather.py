"""Gathering: from wherever four feet stand to the stance that motions begin in."""

from itertools import combinations

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.model import LIMB_JOINTS
from mobius.model.poses import Stance
from mobius.model.reach import ends
from mobius.model.robot import centre_of_mass, keyframe_joints
from mobius.modes import Gather, Gathered
from mobius.modes.motions.gather import LIFT, PAIRS, build_gather
from mobius.types import Mode, ModeCommand

CRAWL, HOLDS = keyframe_joints("crawl")
WIDE = Stance(arm_r=0.24, arm_turn=0.30, leg_r=0.19, leg_turn=0.20).joints()
UP = np.array([0.0, 0.0, 1.0])
MASS = 10.3
STEPS = (1, 3)
"""Stages in which a pair is in the air."""
STILL = ModeCommand(Mode.GATHER, np.zeros(3), 0.0)


@pytest.fixture(scope="module")
def end():
    return Gathered(CRAWL, HOLDS, centre_of_mass, MASS)


@pytest.fixture(scope="module")
def light():
    """Without weight no target is off its joint's angle: key poses are where the robot is."""
    return Gathered(CRAWL, CRAWL, centre_of_mass, 0.0)


def poses(stage):
    return np.vstack([stage.through, stage.q])


def lifted(stage):
    """Which limbs are off the floor in the middle of a stage."""
    depth = np.array([ends(q)[:, 2] for q in poses(stage)])
    return set(np.flatnonzero(depth.max(axis=0) - depth[-1] > 0.5 * LIFT).tolist())


def test_each_diagonal_pair_is_lifted_once_and_high_enough(light):
    stages = build_gather(WIDE, UP, light).stages
    assert {frozenset(lifted(stages[k])) for k in STEPS} == {frozenset(p) for p in PAIRS}
    assert all(not lifted(s) for k, s in enumerate(stages) if k not in STEPS)
    for k in STEPS:
        depth = np.array([ends(q)[:, 2] for q in poses(stages[k])])
        rise = (depth.max(axis=0) - depth[-1])[list(lifted(stages[k]))]
        np.testing.assert_allclose(rise, LIFT, atol=2e-3)


def test_feet_that_stand_stay_where_they_are(light):
    """The trunk may move, two standing feet may not: their distance is the same in all poses."""
    before = WIDE
    for k, stage in enumerate(build_gather(WIDE, UP, light).stages):
        stand = [i for i in range(4) if k not in STEPS or i not in lifted(stage)]
        for a, b in combinations(stand, 2):
            apart = [np.linalg.norm(ends(q)[a] - ends(q)[b]) for q in [before, *poses(stage)]]
            np.testing.assert_allclose(apart, apart[0], atol=1e-3)
        before = stage.q


def test_the_weight_is_over_the_two_feet_that_stay_when_the_others_lift(light):
    stages = build_gather(WIDE, UP, light).stages
    for k in STEPS:
        q = stages[k - 1].q
        a, b = ends(q)[[i for i in range(4) if i not in lifted(stages[k])], :2]
        along = (b - a) / np.linalg.norm(b - a)
        off = centre_of_mass(q)[:2] - a
        assert abs(off[0] * along[1] - off[1] * along[0]) < 2e-3
    a, b = ends(WIDE)[[0, 3], :2]
    along, off = (b - a) / np.linalg.norm(b - a), centre_of_mass(WIDE)[:2] - a
    assert abs(off[0] * along[1] - off[1] * along[0]) > 0.01  # it was not before


def test_the_trunk_leans_uphill(light):
    """On a floor that falls forward the centre of mass hangs further forward: 2 deg of 0.22 m
    are 8 mm, times the cosine of about 42 deg between them and the line's normal.
    """
    slope = np.radians(2.0)
    level = build_gather(WIDE, UP, light).stages[0].q
    tilted = build_gather(WIDE, [np.sin(-slope), 0, np.cos(slope)], light).stages[0].q
    shift = (ends(tilted) - ends(level)).mean(axis=0)
    assert 0.002 < shift[0] < 0.009  # feet forward of where they were: the trunk went back


def test_it_ends_in_the_stance_and_begins_with_all_four_loaded(end):
    stages = build_gather(WIDE, UP, end).stages
    np.testing.assert_allclose(stages[-1].q, HOLDS)
    assert (ends(stages[0].q)[:, 2] < ends(WIDE)[:, 2] - 0.003).all()  # targets below the floor


def test_a_pair_alone_is_given_twice_the_load(end, light):
    """Targets sink where the limb carries: half the weight each in the air stage, a quarter
    before; the other pair's do not.
    """
    heavy, free = (build_gather(WIDE, UP, e).stages for e in (end, light))
    sag = [
        ends(f)[:, 2] - ends(h)[:, 2] for h, f in zip(poses(heavy[1]), poses(free[1]), strict=True)
    ]
    before = ends(free[0].q)[:, 2] - ends(heavy[0].q)[:, 2]
    air = list(lifted(free[1]))
    stand = [i for i in range(4) if i not in air]
    middle = sag[len(sag) // 2]
    assert np.abs(middle[air]).max() < 1e-3
    np.testing.assert_allclose(middle[stand] / before[stand], 2.0, rtol=0.25)


def test_it_takes_feet_from_where_they_are(light):
    """One hand 4 cm off, one foot 2 cm in the air: both end in the stance."""
    q = WIDE.copy()
    q[LIMB_JOINTS["left_arm"].start] += 0.15
    leg = LIMB_JOINTS["right_leg"]
    q[leg.start + 1 : leg.start + 3] += [-0.05, 0.03]
    assert np.abs(ends(q) - ends(WIDE)).max() > 0.02
    np.testing.assert_allclose(ends(build_gather(q, UP, light).stages[-1].q), ends(CRAWL))


def test_angles_that_are_no_stance_are_refused_by_limb(light):
    q = WIDE.copy()
    leg = LIMB_JOINTS["left_leg"]
    q[leg.start + 1], q[leg.start + 2] = 2.0, -2.0
    with pytest.raises(InvalidInput, match="gather, left_leg: expected an ankle or wrist within"):
        build_gather(q, UP, light)


def test_the_controller_begins_at_the_targets_sent_last_and_fails_rather_than_raise(
    end, belief_of, frame_of
):
    gather = Gather(end)
    gather.begin(WIDE + 0.01)
    first = gather.act(STILL, belief_of(), frame_of(0.0, WIDE))
    np.testing.assert_allclose(first.q, WIDE + 0.01)
    assert gather.state == "running"
    gather.reset()
    bad = WIDE.copy()
    bad[17], bad[18] = 2.0, -2.0
    kept = gather.act(STILL, belief_of(), frame_of(0.0, bad))
    assert gather.state == "failed" and "gather" in gather.reason
    np.testing.assert_allclose(kept.q, bad)
