import numpy as np

from mobius.control.governor import Axis, axis_set
from mobius.reproduce import fig_18, fig_19
from mobius.reproduce.moas import volumes

AXIS = Axis(dt=0.02, environment=(0.0, 300.0))


def test_the_paper_s_experiment_with_and_without_a_governor(tmp_path):
    rows = axis_set(AXIS, tolerance=0.02)
    runs = fig_19.experiment(AXIS, rows)
    assert runs["none"].broken.mean() > 0.1
    assert not runs["exact"].broken.any()
    late = (runs["exact"].t > 11) & (runs["exact"].t < 17)
    assert (runs["exact"].x_ref == runs["exact"].wish)[late].all()
    fig_19.draw(tmp_path / "19.png", AXIS, runs)
    fig_18.draw(tmp_path / "18.png", AXIS, rows)
    assert (tmp_path / "19.png").stat().st_size > 10_000
    assert (tmp_path / "18.png").stat().st_size > 10_000
    shares = volumes(AXIS, rows, 2000)
    assert 0.0 < shares["exact_share"] < shares["bare_exact_share"] < 1.0
    assert np.isfinite(list(shares.values())).all()
