"""Tables: every row as wide as its head, whatever is missing."""

import csv
import io

import numpy as np
import pytest

from mobius.evaluate.motions import Series
from mobius.evaluate.push import MAGNITUDES, Push, PushRun
from mobius.evaluate.robustness import Robustness, RobustnessRun, per_sweep
from mobius.evaluate.tables import as_csv, as_text, series_table, tables
from mobius.evaluate.terrain import Terrain, TerrainRun, per_kind
from mobius.evaluate.tracking import Run, SegmentScore, summarise


def tracking_result():
    full = SegmentScore("forward", [0.2, 0, 0], [0.1, 0, 0], [0.1, 0, 0], 9.0, False, 0.01, 0.5)
    none = SegmentScore("stand", [0.0, 0, 0], None, None, None, True)
    zero = [0.0, 0.0, 0.0]
    run = Run(3, True, zero, zero, zero, 9.0, 0.0, 10.0, [0.1] * 20, 0.01, 0.1, 0, 0, [full, none])
    return summarise("crawl", 3, 1.0, [run])


def push_result():
    runs = [
        PushRun(0, "stand", (0.0, 0.0, 0.0), [0.1, 0.2, 0.3], [1.0] * 4, True),
        PushRun(0, "walk", (0.1, 0.0, 0.0), [], [], True),
    ]
    shares = {"stand": [1.0] * 3 + [0.0] * 7, "walk": [0.0] * 10}
    return Push("biped", 0, 2, 2, False, list(MAGNITUDES), shares, runs)


def terrain_result():
    runs = [TerrainRun("soft", 0, False, 20.0, 3.0, [0.01, 0.02, 0.03])]
    return Terrain("crawl", 0, 1, 0, {"soft": per_kind(runs)}, runs)


def robustness_result():
    values = (0.0, 1.0, 2.0, 3.0, 5.0, 8.0)
    runs = [RobustnessRun("noise", v, 0, v > 4, [0.01, 0.02, 0.03]) for v in values]
    return Robustness("crawl", 0, 6, 2, {"noise": per_sweep("noise", runs)}, runs)


RESULTS = [tracking_result, push_result, terrain_result, robustness_result]


@pytest.mark.parametrize("build", RESULTS)
def test_every_row_is_as_wide_as_its_head(build):
    for name, table in tables(build()).items():
        read = list(csv.reader(io.StringIO(as_csv(table))))
        assert len(read) > 1, name
        assert {len(row) for row in read} == {len(read[0])}, name


@pytest.mark.parametrize("build", RESULTS)
def test_text_fits_a_terminal(build):
    lines = as_text(build()).splitlines()
    assert len(lines) > 1 and max(map(len, lines)) <= 125
    assert not any("nan" in line or "None" in line for line in lines)


def test_a_command_that_never_counted_leaves_its_cells_empty():
    head, *rows = tables(tracking_result())["commands"]
    stand = dict(zip(head, next(r for r in rows if r[0] == "stand"), strict=True))
    assert stand["mae_vx"] is None and stand["falls"] == 1
    assert ",,," in as_csv(tables(tracking_result())["commands"])


def test_the_survival_table_is_the_curve():
    head, first, *_ = tables(push_result())["survival"]
    assert head == ["magnitude_mps", "stand", "walk"] and first == [0.1, 1.0, 0.0]


def test_a_series_has_target_actual_mean_and_error_of_every_component():
    want, true = np.full((3, 3), 0.2), np.full((3, 3), 0.1)
    table = series_table([Series("yaw", np.arange(3) / 60, want, true, true + 0.05)])
    row = dict(zip(table[0], table[1], strict=True))
    assert row["motion"] == "yaw" and len(table) == 4
    values = [row[f"{kind}_wz"] for kind in ("target", "actual", "mean", "error")]
    assert values == pytest.approx([0.2, 0.1, 0.15, -0.05])
