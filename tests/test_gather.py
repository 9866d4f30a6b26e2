"""A robot that stands wide steps into the stance of the motions, in physics and the whole stack."""

import numpy as np
import pytest

from mobius.assemble import Start, build_sim_stack, flat_model
from mobius.model.poses import Stance, stance_keyframe
from mobius.model.reach import ends, longest_step
from mobius.model.robot import keyframe_joints
from mobius.modes.motions import tilt_of
from mobius.robot import TICK
from mobius.types import JointCommand, Mode, ModeCommand

WIDE = Stance(arm_r=0.24, arm_turn=0.30, leg_r=0.19, leg_turn=0.20)


class Standing:
    """Holds the wide stance in mode crawl."""

    apart = True

    def reset(self):
        """Nothing to forget."""

    def act(self, command, belief, frame):
        """The same targets always."""
        return JointCommand(q=stance_keyframe(WIDE)[1], stamp=frame.stamp)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_it_gathers_level_softly_and_without_sliding_before_it_stands_up(seed):
    start = Start(qpos=stance_keyframe(WIDE)[0], mode=Mode.CRAWL, seed=seed)
    stack, robot = build_sim_stack(
        flat_model(), start, policy={"crawl": Standing()}, modes=("crawl", "biped")
    )

    def source(belief):
        wanted = Mode.CRAWL if belief.stamp < 0.5 else Mode.BIPED
        return ModeCommand(wanted, np.zeros(3), belief.stamp)

    leans, slid, hits, left = [], np.zeros(4), [0.0], np.zeros(4, bool)
    while stack.machine.mode in (Mode.CRAWL, Mode.GATHER) and stack.tick * TICK < 5.0:
        stack.turn(source)
        if stack.machine.mode is Mode.GATHER:
            tilt, (force, speed) = tilt_of(robot.truth().q_OB), robot.sole_contact()
            leans += [tilt.pitch_B, tilt.roll_B]
            slid += speed * (force > 1.0) * TICK
            hits.append(force.max())
            left |= force == 0.0
    assert [e.after for e in stack.machine.events] == [Mode.GATHER, Mode.STAND_UP]
    q = robot.data.qpos[robot.at.qpos]
    assert longest_step(q, keyframe_joints("crawl")[0]) < 0.02
    assert longest_step(q, stance_keyframe(WIDE)[0][robot.at.qpos]) > 0.09
    assert np.isfinite(ends(q)).all() and left.all()
    assert np.degrees(np.abs(leans).max()) < 6.0
    assert slid.max() < 0.04  # feet creep on soles that give way: 25 mm on hard ones, 33 on these
    assert max(hits) < 130.0  # the robot weighs 101 N; a step of the crawl lands with up to 300
