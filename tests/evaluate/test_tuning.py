"""The contact simulator, the evaluation of the tuner, and two arms on one bar."""

import numpy as np
import pytest

from mobius.control.admittance import AxisGains, Interval, Loop, damping, spectral_radius
from mobius.control.admittance.stability import as_rows
from mobius.control.tuning import Tuner
from mobius.errors import InvalidInput, UnknownName
from mobius.evaluate.contact import KINDS, Contact, ContactPlant, references
from mobius.evaluate.tuning import RANGE, mediocre, own_seed, run, tuning
from mobius.evaluate.two_arms import GRIP, bad_gains, hold_bar

QUIET = AxisGains(D=2000.0, K=10.0, K_f=1.0, K_fi=0.1, K_pi=0.5)


@pytest.mark.parametrize("kind", KINDS)
def test_a_contact_starts_with_its_first_wish_fulfilled(kind):
    contact = Contact(kind, 3000.0)
    w = references(contact, 600, np.random.default_rng(0))
    f, read = ContactPlant(contact, w[0], seed=0).read()
    np.testing.assert_allclose(f, w[0], atol=1e-9)
    assert np.abs(read - f).max() < 1.0


def test_the_servo_arrives_late_and_all_the_way():
    """Moved by 1 mm in a spring of 1000 N/m the wrench changes by 1 N, half of it after about
    0.7 of the lag."""
    contact = Contact("bar", 1000.0)
    plant = ContactPlant(contact, np.zeros(2), seed=3)
    plant._sway[:] = 0.0
    plant._sway0[:] = 0.0
    f = []
    for _ in range(300):
        f.append(plant.read()[0][0])
        plant.move(np.array([1e-3, 0.0]))
    assert f[0] == f[1] == 0.0  # a tick late, and no jump
    assert f[-1] == pytest.approx(-1.0, rel=1e-3)
    half = np.flatnonzero(np.array(f) < -0.5)[0] / 300
    assert half == pytest.approx(0.7 * plant.tau + 0.006 + 1 / 300, abs=0.01)


def test_a_wall_cannot_pull():
    plant = ContactPlant(Contact("wall", 1000.0), np.array([-5.0]), seed=0)
    for _ in range(200):
        plant.move(np.array([-0.05]))
    assert plant.read()[0][0] == 0.0


def test_the_true_loop_is_judged_with_its_own_lag():
    """Just stable by the true spectral radius is what stays bounded in the simulator."""
    contact = Contact("wall", 20_000.0)
    plant = ContactPlant(contact, np.array([-15.0]), seed=5)
    low, high = 10.0, 1e5
    for _ in range(50):
        D = np.sqrt(low * high)
        g = AxisGains(D=D)
        low, high = (low, D) if plant.closed_loop(as_rows(g)[0], 0.3) < 1 else (D, high)
    good, bad = (run(contact, AxisGains(D=k * high), seconds=6.0, seed=5).error for k in (1.3, 0.8))
    assert np.abs(good[-300:]).max() < 10.0 < np.abs(bad[-300:]).max()


def test_one_set_for_all_is_the_least_damping_that_suits_the_stiffest():
    rng = np.random.default_rng(0)
    sets = {mediocre("one_for_all", Contact(k, s), rng) for k in KINDS for s in (500.0, 5e4)}
    (gains,) = sets
    at = Interval(RANGE[1], RANGE[1], lag=(1.0,))
    assert damping(gains, at, Loop())[0] >= 0.5
    less = AxisGains(gains.M, gains.D / 1.1, gains.K, gains.K_f, gains.K_fi, gains.K_pi)
    assert damping(less, at, Loop())[0] < 0.5


def test_a_guess_is_wrong_by_at_most_3_and_differently_for_each_contact():
    """D goes with the guessed stiffness, so that D over the true one spans up to 3 * 3."""
    ratios = []
    for k in np.geomspace(*RANGE, 12):
        contact = Contact("bar", float(k))
        rng = np.random.default_rng([*own_seed(contact, 0), 3])
        ratios.append(mediocre("guess", contact, rng).D / k)
    assert len({round(r, 6) for r in ratios}) == 12
    assert max(ratios) / min(ratios) < 9.0 * 1.2**2


def test_a_run_repeats_itself_to_the_last_bit():
    contact = Contact("peg", 3000.0)
    a, b = (
        run(contact, QUIET, seconds=4.0, seed=2, tuner=Tuner(QUIET, contact.n)) for _ in range(2)
    )
    np.testing.assert_array_equal(a.error, b.error)
    assert [r.gains for _t, r in a.reports] == [r.gains for _t, r in b.reports]


def test_an_evaluation_tells_its_figures(monkeypatch):
    monkeypatch.setattr("mobius.evaluate.tuning.TUNE_S", 14.0)
    monkeypatch.setattr("mobius.evaluate.tuning.JUDGE_S", 4.0)
    a = tuning(stiffnesses=1, seed=4, workers=1).as_json()
    assert a["cases"] == 3 and a["unstable"] == 0
    assert set(a["by_kind"]) == set(KINDS)
    changes = sorted(r["change"] for r in a["runs"])
    assert a["force_rmse_change"] == changes[1] < -0.45
    assert a["settled_s_worst"] <= 12.0


def test_gains_fine_for_one_arm_make_two_fight_and_the_tuner_mends_it():
    gains = bad_gains()
    alone = hold_bar(gains, both=False)
    fight = hold_bar(gains)
    tuner = Tuner(gains, 1)
    mended = hold_bar(gains, tuner=tuner)
    assert not alone.broke and alone.rmse() < 1.0
    assert fight.broke and fight.t[-1] < 20.0
    early = fight.internal[(fight.t > 3) & (fight.t < 5)]
    late = fight.internal[(fight.t > 8) & (fight.t < 10)]
    assert np.ptp(late) > 2 * np.ptp(early)
    assert not mended.broke and mended.rmse() < 1.5
    assert mended.gains == tuner.gains
    assert spectral_radius(mended.gains, Interval(GRIP, GRIP), Loop())[0] < 1.0


def test_good_gains_do_not_fight():
    assert hold_bar(QUIET, seconds=6.0).rmse() < 4.0


def test_mistakes_are_told():
    with pytest.raises(UnknownName, match="Did you mean 'wall'"):
        Contact("walls", 1.0)
    with pytest.raises(InvalidInput, match="N/m > 0"):
        Contact("wall", 0.0)
    with pytest.raises(UnknownName, match="one_for_all"):
        tuning(start="best")
    with pytest.raises(InvalidInput, match="at least one stiffness"):
        tuning(stiffnesses=0)
