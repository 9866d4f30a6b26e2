"""Two arms on one bar: badly tuned they fight until a grasp breaks, and the tuner mends it."""

from mobius.evaluate.pullup_fight import fight


def test_badly_tuned_arms_fight_until_a_grasp_breaks():
    result = fight(seconds=2.5)
    assert result.broken and result.t[-1] < 2.4
    assert result.swing(1.0, 2.0) > 2 * result.swing(0.5, 1.0)


def test_the_tuner_calms_the_same_arms():
    result = fight(seconds=3.0, tune=True)
    assert not result.broken and result.slip_m == 0.0
    assert result.swing(2.5, 3.0) < 0.2 * result.swing(0.5, 1.0)
    assert result.gains.D > 150.0
