"""Sweeps change one property, past what is drawn elsewhere."""

import pytest

from mobius.errors import UnknownName
from mobius.evaluate import SWEEPS, robustness
from mobius.evaluate.episode import Setup
from mobius.evaluate.robustness import RobustnessRun, per_sweep, setup_at
from mobius.robot.variation import Variation


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_holds_the_usual_range_and_goes_past_it(name):
    low, high = SWEEPS[name].usual
    assert min(SWEEPS[name].values) <= low and max(SWEEPS[name].values) > high


@pytest.mark.parametrize(
    ("name", "value", "field", "is_"),
    [
        ("friction", 0.3, "friction", 0.3),
        ("payload", 4.0, "trunk_mass", 4.0),
        ("delay", 50.0, "delay_ticks", 30),
        ("motor", 0.6, "servo_gain", 0.6),
    ],
)
def test_a_point_changes_one_property_of_the_robot(name, value, field, is_):
    setup = setup_at(name, value, Setup("crawl", 7, "zero"))
    assert getattr(setup.variation, field) == is_
    changed = {k for k, v in vars(setup.variation).items() if v != vars(Variation())[k]}
    assert changed == {field}
    assert setup.noise == 1.0 and not setup.randomised and setup.seed == 7


def test_noise_changes_the_sensors_and_not_the_robot():
    setup = setup_at("noise", 5.0, Setup("crawl", 0))
    assert setup.noise == 5.0 and setup.variation == Variation()


def test_a_curve_has_a_number_for_every_value():
    values = SWEEPS["delay"].values
    runs = [
        RobustnessRun("delay", v, s, fallen=v > 30 and s == 0, error=[0.001 * v, 0.0, 0.1])
        for v in values
        for s in range(2)
    ]
    curve = per_sweep("delay", [*runs, RobustnessRun("motor", 0.0, 0, True, [9.0, 9.0, 9.0])])
    assert curve["survival"] == [1.0, 1.0, 1.0, 1.0, 0.5, 0.5]
    assert curve["mae"]["vx"] == pytest.approx([0.001 * v for v in values])


def test_an_unknown_sweep_is_refused():
    with pytest.raises(UnknownName, match="Did you mean 'friction'"):
        robustness("crawl", seeds=1, sweeps=("frction",))
