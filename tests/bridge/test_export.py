"""Exports hold the run's own numbers and are whole or absent."""

import csv
import os

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from mobius.bridge.export import build_table, export
from mobius.bridge.read_log import read_log
from mobius.bridge.read_run import open_run
from mobius.errors import InvalidInput, MissingDependency, UnknownName
from mobius.model.joints import JOINTS


def test_a_csv_reads_back_as_the_same_numbers(run_file, tmp_path):
    out = export(run_file, "csv", tmp_path / "run.csv")
    run = open_run(run_file)
    with open(out, newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(run)
    q = np.array([[float(row[f"{joint}_rad"]) for joint in JOINTS] for row in rows])
    np.testing.assert_array_equal(q, run.q)
    assert rows[5]["mode"] == "crawl"
    assert float(rows[7]["t_s"]) == run.t[7]
    assert float(rows[7]["true_qw"]) == run.true.q_M[7, 0]
    assert float(rows[7]["left_leg_contact"]) == run.contact[7, 2]
    assert float(rows[7]["right_wrist_tz_Nm"]) == run.wrench_S[7, 1, 5]
    assert float(rows[7]["cmd_wz_radps"]) == 0.3


def test_every_column_is_as_long_as_the_run_and_named_once(run_file):
    run = open_run(run_file)
    table = build_table(run)
    assert {len(column) for column in table.values()} == {len(run)}
    # t, mode, power; 4 x 22 joints; 2 x (3 + 4 + 3); 3; 4; 2 x 6; 6
    assert len(table) == 3 + 88 + 20 + 3 + 4 + 12 + 6


def test_what_was_not_recorded_has_no_column(nouns, tmp_path):
    from mobius.bridge.record import McapRecorder

    recorder = McapRecorder()
    recorder.step(0, frame=nouns["frame"])
    recorder.save(tmp_path / "run.mcap")
    table = build_table(open_run(tmp_path / "run.mcap"))
    assert not [name for name in table if name.startswith(("true_", "believed_", "cmd_"))]


def test_parquet_holds_the_same_table(run_file, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(export(run_file, "parquet", tmp_path / "run.parquet"))
    run = open_run(run_file)
    assert table.column_names == list(build_table(run))
    np.testing.assert_array_equal(table["left_hip_yaw_rad"].to_numpy(), run.q[:, 12])
    assert table.schema.metadata[b"map"] == b"demo"


def test_parquet_without_pyarrow_names_what_to_install(run_file, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(MissingDependency, match=r"pip install 'mobius\[sweep\]'"):
        export(run_file, "parquet", tmp_path / "out" / "run.parquet")
    assert not (tmp_path / "out").exists()


def test_a_cut_off_log_made_whole_opens_in_readers_that_want_an_index(run_file, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(run_file.read_bytes()[:-9000])
    with pytest.raises(Exception, match="magic"), AnyReader([cut]):
        pass
    whole = export(cut, "mcap")
    assert whole == tmp_path / "cut.whole.mcap"
    assert read_log(whole).messages == read_log(cut).messages
    assert read_log(whole).about.scene == read_log(cut).about.scene
    assert open_run(whole).complete
    with AnyReader([whole]) as reader:
        assert reader.message_count == sum(read_log(cut).counts.values())


def test_a_run_named_by_its_folder_is_exported_beside_it(run_file):
    """Not into the folder, which only holds what the run itself left."""
    out = export(run_file.parent, "csv")
    assert out == run_file.parent.with_name(run_file.parent.name + ".csv")
    assert os.listdir(run_file.parent) == ["run.mcap"]
    with pytest.raises(InvalidInput, match="exists; choose another --out"):
        export(run_file.parent, "csv")


@pytest.mark.parametrize(
    ("form", "advice"),
    [("rerun", "type: rerun .*run.mcap"), ("foxglove", "drop .*run.mcap"), ("lerobot", "parquet")],
)
def test_forms_that_need_no_export_say_what_to_do(form, advice, run_file):
    with pytest.raises(InvalidInput, match=advice):
        export(run_file, form)


def test_an_unknown_form_or_a_bad_log_leaves_nothing(run_file, tmp_path):
    with pytest.raises(UnknownName, match=r"unknown form 'cvs'. Did you mean 'csv'"):
        export(run_file, "cvs", tmp_path / "a")
    (tmp_path / "bad.mcap").write_bytes(b"no log")
    for form in ("csv", "mcap"):
        with pytest.raises(InvalidInput, match="is no log"):
            export(tmp_path / "bad.mcap", form, tmp_path / "a")
    assert sorted(os.listdir(tmp_path)) == ["bad.mcap", "run.mcap"]
