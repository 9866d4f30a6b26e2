"""The specification, and the tuner's steps."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from mobius.control.admittance import AxisGains, Interval, Loop, spectral_radius
from mobius.control.admittance.stability import as_rows
from mobius.control.tuning import Specification, Tuner, TunerConfig
from mobius.control.tuning.specification import Window, replay
from mobius.errors import InvalidInput
from mobius.evaluate.contact import Contact
from mobius.evaluate.tuning import run, tune_case

SLUGGISH = AxisGains(D=3684.0, K=50.0, K_f=1.0, K_fi=0.1, K_pi=5.0)


class Spy(Tuner):
    """Keeps the window it judged last."""

    def _judge(self, window):
        self.window = window
        return super()._judge(window)


@pytest.mark.parametrize("kind", ["wall", "bar"])
def test_played_again_with_the_same_gains_a_window_is_what_it_was(kind):
    """The replay holds for the true stiffness and any disturbance, since that is what explains
    the measurement."""
    contact = Contact(kind, 5000.0)
    tuner = Spy(SLUGGISH, contact.n, config=TunerConfig(spread_max=1e-9))
    run(contact, SLUGGISH, seconds=3.0, seed=0, tuner=tuner)
    w = tuner.window
    f, x = replay(as_rows(SLUGGISH), w, contact.K, Loop())
    np.testing.assert_allclose(f[0], w.f, atol=1e-6)
    np.testing.assert_allclose(x[0], w.x, atol=1e-9)


def test_the_specification_by_hand():
    """Errors 3 and 4 N: rms sqrt(12.5); a force of 30 N on a limit of 25 is 0.4 beyond 0.8."""
    spec = Specification(
        force_scale=0.5, position_scale=0.01, force_limits=np.array([25.0]), weights=np.ones(5)
    )
    f, w = np.array([[30.0], [30.0]]), np.array([[27.0], [26.0]])
    x, ref = np.array([[0.02], [0.02]]), np.zeros((2, 1))
    out = spec.of_series(f, w, x, ref)
    np.testing.assert_allclose(out, [np.sqrt(12.5) / 0.5, 2.0, 0.4, 0.0])


def test_lack_of_manipulability_counts_at_the_worst_end_of_the_motion():
    spec = Specification(
        manipulability=lambda x: 2.0 - x[..., 0], manipulability_min=1.0, weights=np.ones(5)
    )
    x = np.linspace(0.0, 1.5, 10)[:, None]
    out = spec.of_series(np.zeros((10, 1)), np.zeros((10, 1)), x, x)
    assert out[3] == pytest.approx(0.5)


def test_tuning_helps_and_every_set_of_gains_is_stable():
    case, tuned = tune_case("wall", 2000.0, seed=1)
    assert case.change < -0.45
    assert case.settled_s <= 20.0 and not case.unstable
    loop = Loop()
    for _t, report in tuned.reports:
        if report.contact is not None:
            at = Interval(report.contact.low / 1.5, report.contact.high * 1.5)
            assert spectral_radius(report.gains, at, loop)[0] < 1.0


def test_gains_that_are_zero_stay_zero_and_the_mass_stays():
    gains = AxisGains(D=3000.0, K=0.0, K_f=1.0, K_fi=0.0, K_pi=0.0)
    tuner = Tuner(gains, 1)
    run(Contact("wall", 3000.0), gains, seconds=8.0, seed=0, tuner=tuner)
    after = tuner.gains
    assert (after.K, after.K_fi, after.K_pi, after.M) == (0.0, 0.0, 0.0, gains.M)
    assert after.D != gains.D
    assert tuner.names == ("D", "K_f")


def test_without_excitation_nothing_moves():
    tuner = Tuner(SLUGGISH, 1)
    reports = [
        tuner.observe(np.zeros((1, 4)), [-10.0], [-10.0], filtered=[-10.0]) for _ in range(1200)
    ]
    verdicts = [r.verdict for r in reports if r is not None]
    assert verdicts and set(verdicts) == {"waiting"}
    assert tuner.gains == SLUGGISH


def test_a_window_with_a_drop_out_is_not_used():
    tuner = Tuner(SLUGGISH, 1)
    reports = [
        tuner.observe(np.zeros((1, 4)), [-10.0], [-10.0], filtered=[-10.0], ok=k % 400 != 399)
        for k in range(2000)
    ]
    assert not [r for r in reports if r is not None]  # a window is 450 ticks


def test_a_number_that_is_none_is_a_drop_out_and_not_the_end_of_tuning():
    contact = Contact("wall", 5000.0)
    tuner = Tuner(SLUGGISH)
    tuner.observe(np.zeros((1, 4)), [0.0], [0.0], filtered=[0.0])
    tuner.observe(np.zeros((1, 4)), [np.nan], [0.0], filtered=[0.0])
    verdicts = [
        r.verdict for _t, r in run(contact, SLUGGISH, seconds=9.0, seed=0, tuner=tuner).reports
    ]
    assert "taken" in verdicts


def test_a_step_that_would_be_unstable_is_shrunk_or_refused(monkeypatch):
    """The filter is made to ask for a hundredth of the damping at every measurement."""
    contact = Contact("wall", 20_000.0)
    tuner = Tuner(SLUGGISH, 1, config=TunerConfig(step_max=5.0, spread_max=10.0))
    update = tuner.filter.update

    def reckless(*args, **kw):
        before = tuner.filter.theta.copy()
        out = update(*args, **kw)
        tuner.filter.theta = before
        tuner.filter.theta[0] -= np.log(100.0)
        return out

    monkeypatch.setattr(tuner.filter, "update", reckless)
    done = run(contact, SLUGGISH, seconds=12.0, seed=0, tuner=tuner)
    verdicts = [r.verdict for _t, r in done.reports]
    assert "refused" in verdicts and "taken" not in verdicts
    asked = replace(SLUGGISH, D=SLUGGISH.D / 100)
    assert spectral_radius(asked, Interval(2e4, 2e4), Loop())[0] > 1.0
    assert spectral_radius(tuner.gains, Interval(2e4, 2e4), Loop())[0] < 1.0
    assert np.abs(done.error).max() < 60.0


def test_a_window_is_what_it_says():
    window = Window(*(np.zeros((5, 2)) for _ in range(5)), np.zeros((2, 6)))
    f, x = replay(as_rows(SLUGGISH), window, np.eye(2), Loop())
    assert f.shape == x.shape == (1, 5, 2)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Tuner(SLUGGISH, 0),
        lambda: TunerConfig(period=0.0),
        lambda: TunerConfig(interval=0.5),
        lambda: Specification(force_scale=0.0),
        lambda: Specification(weights=np.ones(3)),
    ],
)
def test_nonsense_is_refused(make):
    with pytest.raises(InvalidInput):
        make()


def test_the_force_loop_does_without_the_tuner():
    """Optional and separable: importing the one does not bring the other."""
    code = "import sys, mobius.control.admittance; print('mobius.control.tuning' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
