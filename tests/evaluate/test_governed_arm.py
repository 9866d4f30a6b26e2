import numpy as np
import pytest

from mobius.cli import main
from mobius.control.governor import Axis
from mobius.control.governor.plant import DT
from mobius.evaluate.arm_rig import STEPS, ArmRig, Contacts
from mobius.evaluate.governed_arm import (
    ARM_MARGIN,
    arm_as_text,
    config_of,
    governed_arm,
    governors_of,
)

AIR = Axis("test", environment=(0.0, 0.0))
"""Nothing to touch: its set is built at once."""


@pytest.fixture(scope="module")
def rig():
    return ArmRig(0)


def test_a_spring_pulls_back_and_a_wall_only_pushes():
    x = np.array([[0.02, -0.02, 0.05], [-0.05, 0.01, 0.0]])
    wall = np.array([[0.0, 0.01, 0.03], [-0.03, 0.03, 0.0]])
    force = np.zeros((2, 3))
    force[1, 2] = 1.5
    by_hand = [[-2.0, 0.0, -2.0], [2.0, 0.0, 1.5]]  # 100 N/m times depth
    assert np.allclose(Contacts(np.full((2, 3), 100.0), wall, force).wrench(x), by_hand)


def test_a_known_force_moves_the_hand_and_is_what_the_wrist_reads(rig):
    free = Contacts(*np.zeros((3, 2, 3)))
    for _ in range(60):
        rest = rig.tick(rig.targets, free)
    assert np.abs(rest.x).max() < 1e-3
    assert np.abs(rest.v).max() < 1e-2
    before = rig.frame().wrench_S
    force = np.zeros((2, 3))
    force[0, 2] = 10.0
    for _ in range(300):
        pushed = rig.tick(rig.targets, Contacts(*np.zeros((2, 2, 3)), force))
    change = rig.frame().wrench_S - before
    assert pushed.x[-1, 0, 2] > 2e-3  # servos give way
    assert np.abs(pushed.x[-1, 1]).max() < 1e-3  # the other arm does not
    assert np.isclose(np.linalg.norm(change[0, :3]), 10.0, atol=1.0)
    assert np.linalg.norm(change[1, :3]) < 1.0
    for _ in range(300):
        rig.tick(rig.targets, free)


def test_the_speed_that_is_counted_is_that_of_the_position(rig):
    moved = rig.targets.copy()
    moved[0] += 0.1
    free, seen = Contacts(*np.zeros((3, 2, 3))), []
    for _ in range(90):
        seen.append(rig.tick(moved, free))
    x = np.concatenate([m.x for m in seen])
    v = np.concatenate([m.v for m in seen])
    assert np.abs(v).max() > 0.05
    assert np.allclose(np.diff(x, axis=0) * STEPS / DT, v[:-1], atol=1e-9)


def test_only_the_governor_keeps_the_limits_of_the_arms():
    result = governed_arm(seeds=1, seed=1, ticks=150, axis=AIR, workers=1,
                          variants=("none", "exact"))  # fmt: skip
    assert result.steps == 150
    assert result.violations["none"] > 10
    assert result.violations["exact"] == 0
    assert all(0.0 < share <= 1.0 for share in result.worst["exact"].values())
    assert result.margin == ARM_MARGIN
    assert "exact" in arm_as_text(result)


def test_the_controllers_own_clips_do_not_help_the_governor():
    """Else a variant without a governor would keep a limit that nobody kept."""
    config = config_of(AIR)
    assert (config.position_max[:3] > 3 * AIR.position_max).all()
    assert (config.velocity_max[:3] > 10 * AIR.velocity_max).all()
    assert not governors_of("none", AIR)
    assert len(governors_of("exact", AIR)) == 6


def test_a_variant_that_the_arms_do_not_know_is_refused(capsys):
    assert main(["eval", "governor", "--arm", "--variant", "algorithm_3_repaired"]) == 2
    assert "algorithm_3" in capsys.readouterr().err


def test_a_margin_without_the_arms_or_out_of_range_is_refused(capsys):
    for more in (["--margin", "0.2"], ["--arm", "--margin", "1"], ["--arm", "--margin", "nan"],
                 ["--arm", "--margin", "0.1", "0.2"]):  # fmt: skip
        assert main(["eval", "governor", *more]) == 2
        assert "--margin: expected --arm and a number" in capsys.readouterr().err
