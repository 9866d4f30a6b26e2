"""A sweep's rows: all of them, once, in order, whatever kills it and whoever does the work."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mobius.errors import InvalidInput
from mobius.sweep import product_of, run_sweep
from mobius.sweep.output import as_csv

SETTINGS = product_of({"a": [1, 2, 3, 4], "b": ["x", "y", "z"]})
SLOW = """
import sys, time
sys.path.insert(0, {here!r})
from test_sweep import SETTINGS, slowly
from mobius.sweep import run_sweep
run_sweep(slowly, SETTINGS, sys.argv[1], resume=True, workers=int(sys.argv[2]))
"""


def double(setting):
    return {"twice": 2 * setting["a"], "pid": 0}


def slowly(setting):
    time.sleep(0.03)
    return double(setting)


def refuse(setting):
    raise RuntimeError(f"asked for {setting}")


def expected():
    return [{**s, **double(s)} for s in SETTINGS]


def table_of(path: Path):
    if path.suffix == ".csv":
        return path.read_text()
    return pytest.importorskip("pyarrow.parquet").read_table(path).to_pylist()


def test_a_product_has_every_combination_the_last_name_fastest():
    assert len(SETTINGS) == 12
    assert SETTINGS[:4] == [{"a": 1, "b": b} for b in "xyz"] + [{"a": 2, "b": "x"}]


@pytest.mark.parametrize(("table", "says"), [({"a": []}, "empty"), ({"a": [1, 1]}, "twice")])
def test_an_empty_or_repeated_value_is_refused(table, says):
    with pytest.raises(InvalidInput, match=says):
        product_of(table)


@pytest.mark.parametrize("workers", [1, 2])
def test_rows_are_those_of_the_settings_in_their_order_for_any_number_of_workers(tmp_path, workers):
    shares: list[float] = []
    done = run_sweep(double, SETTINGS, tmp_path / "s", workers=workers, progress=shares.append)
    assert done.rows == expected() and done.resumed == 0
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert table_of(done.table) in (expected(), as_csv(expected()))
    assert {p.name for p in (tmp_path / "s").iterdir()} == {"rows.jsonl", done.table.name}


def test_without_pyarrow_the_table_is_csv(tmp_path, monkeypatch):
    monkeypatch.setattr("mobius.sweep.output.find_spec", lambda name: None)
    done = run_sweep(double, SETTINGS, tmp_path / "s", workers=1)
    assert done.table.name == "rows.csv"
    assert done.table.read_text().splitlines()[:2] == ["a,b,twice,pid", "1,x,2,0"]


@pytest.mark.parametrize("workers", [1, 2])
def test_kill_minus_nine_loses_no_row_and_doubles_none(tmp_path, workers):
    folder = tmp_path / "s"
    code = SLOW.format(here=str(Path(__file__).parent))
    argv = [sys.executable, "-c", code, str(folder), str(workers)]
    part = folder / "rows.jsonl"
    for rows in (3, 7):
        process = subprocess.Popen(argv)
        while not part.exists() or part.read_bytes().count(b"\n") < 1 + rows:
            assert process.poll() is None, "it ended before it could be killed"
            time.sleep(0.005)
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert not list(folder.glob("rows.parquet")) + list(folder.glob("rows.csv"))
    with part.open("ab") as file:  # what a kill in the middle of a write leaves
        file.write(b'{"n": 11, "row": {"twi')
    kept = part.read_bytes().count(b"\n") - 1
    done = run_sweep(slowly, SETTINGS, folder, resume=True, workers=workers)
    assert 7 <= done.resumed == kept < len(SETTINGS)
    assert done.rows == expected()
    numbers = [json.loads(line)["n"] for line in part.read_text().splitlines()[1:]]
    assert sorted(numbers) == list(range(len(SETTINGS)))


def test_workers_end_with_the_process_that_started_them(tmp_path):
    code = (
        "import os, sys, time\nfrom mobius.sweep.workers import rows_here\n"
        "def work(s):\n os.write(1, b'%d\\n' % os.getpid()); time.sleep(60)\n"
        "list(rows_here(work, [(0, {}), (1, {})], workers=2))"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    pids = [int(process.stdout.readline()) for _ in range(2)]
    process.kill()
    process.wait()
    process.stdout.close()
    until = time.monotonic() + 10.0
    while any(_alive(pid) for pid in pids):
        assert time.monotonic() < until, "a worker lives on"
        time.sleep(0.05)


def _alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z" and os.path.exists(f"/proc/{pid}")


def test_a_finished_sweep_is_not_done_again(tmp_path):
    first = run_sweep(double, SETTINGS, tmp_path / "s", workers=1)
    again = run_sweep(refuse, SETTINGS, tmp_path / "s", workers=1, resume=True)
    assert again.rows == first.rows and again.resumed == len(SETTINGS)


def test_rows_done_before_an_error_are_kept(tmp_path):
    def work(setting):
        return refuse(setting) if setting == SETTINGS[5] else double(setting)

    with pytest.raises(RuntimeError, match="asked for"):
        run_sweep(work, SETTINGS, tmp_path / "s", workers=1)
    done = run_sweep(double, SETTINGS, tmp_path / "s", workers=1, resume=True)
    assert done.resumed == 5 and done.rows == expected()


def test_what_is_in_the_folder_already_is_refused_with_what_to_type(tmp_path):
    (tmp_path / "precious").write_text("data")
    with pytest.raises(InvalidInput, match="not empty"):
        run_sweep(double, SETTINGS, tmp_path, resume=True)
    run_sweep(double, SETTINGS, tmp_path / "s", workers=1)
    with pytest.raises(InvalidInput, match="--resume"):
        run_sweep(double, SETTINGS, tmp_path / "s")
    for other in ({"stamp": "another map"}, {"settings": SETTINGS[:-1]}):
        with pytest.raises(InvalidInput, match="another sweep"):
            run_sweep(double, folder=tmp_path / "s", resume=True, **{"settings": SETTINGS, **other})


def test_a_part_file_damaged_before_its_end_is_refused(tmp_path):
    run_sweep(double, SETTINGS, tmp_path / "s", workers=1)
    part = tmp_path / "s" / "rows.jsonl"
    part.write_bytes(part.read_bytes().replace(b'{"n": 3,', b'{"n": \0,'))
    with pytest.raises(InvalidInput, match="damaged"):
        run_sweep(double, SETTINGS, tmp_path / "s", resume=True)


def test_two_sweeps_do_not_write_to_one_folder(tmp_path):
    folder = tmp_path / "s"
    code = SLOW.format(here=str(Path(__file__).parent))
    process = subprocess.Popen([sys.executable, "-c", code, str(folder), "1"])
    try:
        while not (folder / "rows.jsonl").exists():
            assert process.poll() is None
            time.sleep(0.005)
        time.sleep(0.05)
        with pytest.raises(InvalidInput, match="another sweep is writing"):
            run_sweep(slowly, SETTINGS, folder, resume=True, workers=1)
    finally:
        process.kill()
        process.wait()


def test_ray_gives_the_same_rows_and_nobody_at_an_address_leaves_nothing(tmp_path):
    pytest.importorskip("ray")
    with pytest.raises(InvalidInput, match="no Ray there"):
        run_sweep(double, SETTINGS, tmp_path / "s", ray="127.0.0.1:1")
    assert not (tmp_path / "s").exists()
    done = run_sweep(_nested(), SETTINGS, tmp_path / "s", ray="local", workers=1)
    assert done.rows == expected()


def _nested():
    """Pickled by value: Ray's workers do not have this file on their path."""
    return lambda setting: {"twice": 2 * setting["a"], "pid": 0}
