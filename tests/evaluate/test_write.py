"""Files of a result, and the motions that the tracking picture shows."""

import json

import numpy as np
import pytest
from PIL import Image

from mobius.evaluate.episode import Setup
from mobius.evaluate.motions import MOTIONS, Series, motions
from mobius.evaluate.push import Push, PushRun
from mobius.evaluate.robustness import Robustness, RobustnessRun, per_sweep
from mobius.evaluate.terrain import Terrain, TerrainRun, per_kind
from mobius.evaluate.tracking import Run, summarise
from mobius.evaluate.write import write_outcome

ZERO = [0.0, 0.0, 0.0]


def results():
    run = Run(0, False, ZERO, ZERO, ZERO, 9.0, 0.0, 10.0, [0.1] * 20, 0.01, 0.1, 0, 0)
    push = [PushRun(0, state, (0.0, 0.0, 0.0), [], [], True) for state in ("stand", "walk")]
    kind = [TerrainRun("soft", 0, False, 20.0, 3.0, ZERO)]
    noise = [RobustnessRun("noise", v, 0, False, ZERO) for v in (0.0, 1.0, 2.0, 3.0, 5.0, 8.0)]
    shares = {"stand": [0.5], "walk": [0.0]}
    return {
        "tracking": summarise("crawl", 0, 1.0, [run]),
        "push": Push("crawl", 0, 2, 2, False, [0.1], shares, push),
        "terrain": Terrain("crawl", 0, 1, 0, {"soft": per_kind(kind)}, kind),
        "robustness": Robustness("crawl", 0, 6, 0, {"noise": per_sweep("noise", noise)}, noise),
    }


@pytest.mark.parametrize("name", results())
def test_a_result_leaves_json_tables_and_a_picture(name, tmp_path):
    t = np.arange(60) / 60
    series = [Series(m, t, *np.zeros((3, 60, 3))) for m in MOTIONS]
    write_outcome(tmp_path, results()[name], series=series if name == "tracking" else ())
    assert json.loads((tmp_path / f"{name}.json").read_text())["body"] == "crawl"
    assert (tmp_path / f"{name}_runs.csv").read_text().count("\n") > 1
    with Image.open(tmp_path / f"{name}.png") as picture:
        assert min(picture.size) > 300
    assert all(p.name.startswith(name) for p in tmp_path.iterdir())


def test_motions_go_from_standing_to_standing(monkeypatch):
    monkeypatch.setattr("mobius.evaluate.motions.HOLD_S", 0.25)
    series = motions(Setup("crawl", 0, "zero"), speed=0.5)
    assert [s.name for s in series] == ["sideways", "forward", "backward", "yaw"]
    for s, axis in zip(series, (1, 0, 0, 2), strict=True):
        moved = np.flatnonzero(s.target.any(axis=0))
        assert moved.tolist() == [axis]
        assert (s.target[:15] == 0).all() and (s.target[-15:] == 0).all()
        assert s.target.shape == s.actual.shape == s.smooth.shape == (60, 3)
