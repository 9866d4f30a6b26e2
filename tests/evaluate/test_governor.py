import numpy as np
import pytest

from mobius.cli import main
from mobius.control.governor import Axis
from mobius.evaluate import governed
from mobius.evaluate.governor import as_text, chooser, governor

AXIS = Axis("test", dt=0.02, environment=(0.0, 300.0))
"""Ours at 50 Hz."""


@pytest.fixture(scope="module")
def result():
    return governor(seeds=4, ticks=400, axes=(AXIS,), workers=1)


def test_only_the_exact_governor_never_breaks_a_limit(result):
    assert result.steps == 1600
    assert result.violations["exact"] == 0
    assert all(v <= 1 for v in result.worst["exact"].values())
    assert result.violations["none"] > 400
    assert result.violations["algorithm_3"] > 0
    assert "exact" in as_text(result)


def test_gentle_references_pass_as_they_are(result):
    assert result.safe_episodes > 0
    assert result.safe_unchanged > 0.95
    assert result.safe_tracking <= 0.05


def test_every_kind_of_reference_breaks_limits_ungoverned():
    for seed in range(4):
        drawn = governed.draw(AXIS, 0, [seed], 600)
        assert governed.run(AXIS, drawn, governed.ungoverned).broken.any()


def test_what_is_drawn_is_within_what_is_assumed():
    drawn = governed.draw(AXIS, 1, [0, 1, 2, 3], 500)
    assert np.abs(drawn.d).max() <= AXIS.disturbance
    assert drawn.k_env.min() >= 0.0
    assert drawn.k_env.max() <= 300.0
    assert len(np.unique(drawn.k_env)) > 4
    again = governed.draw(AXIS, 1, [2], 500)
    assert (again.r[:, 0] == drawn.r[:, 2]).all()


def test_a_force_beyond_the_assumed_bound_can_break_a_limit():
    """The bar of zero violations is not for free: twenty times the assumed force breaks it."""
    drawn = governed.draw(AXIS, 0, [0], 600)
    wild = governed.Drawn(drawn.r, 20.0 * np.sign(drawn.d + 1e-9), drawn.k_env, drawn.adversarial)
    assert governed.run(AXIS, wild, chooser(AXIS, "exact")).broken.any()


def test_mistakes_on_the_command_line_are_told_in_a_line(capsys, tmp_path):
    for argv, said in (
        (["eval", "governor", "--seeds", "0"], "--seeds: expected a whole number >= 1"),
        (["eval", "governor", "--variant", "exat"], "Did you mean 'exact'?"),
        (["moas", "--axis", "tork"], "unknown axis 'tork'"),
        (["moas", "--mass", "-1"], "mass: expected a number > 0"),
        (["moas", "--environment", "0", "50000"], "N/m: LinearSystem.A: expected a stable loop"),
        (["moas", "--disturbance", "30"], "no state is admissible"),
        (["moas", "--save", str(tmp_path / "a.txt")], "ends in .npz"),
        (
            ["moas", "--environment", "0", "0", "--samples", "1000"]
            + ["--save", "/dev/null/a.npz"],
            "cannot be written",
        ),
    ):
        assert main(argv) == 2
        assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
