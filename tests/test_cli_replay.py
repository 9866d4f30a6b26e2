"""``mobius replay`` and ``mobius export`` at the command line."""

import sys
import types

import numpy as np
import pytest

from mobius.bridge.record import McapRecorder
from mobius.cli import main
from mobius.types import SensorFrame


@pytest.fixture
def log(tmp_path):
    """Half a second of a robot that holds still, cut off."""
    zeros = np.zeros(22)
    recorder = McapRecorder()
    for tick in range(0, 300, 10):
        recorder.step(
            tick,
            frame=SensorFrame(
                stamp=tick / 600,
                q=zeros,
                dq=zeros,
                torque=zeros,
                wrench_S=np.zeros((2, 6)),
                gyro_I=np.zeros(3),
                accel_I=np.zeros(3),
            ),
        )
    recorder.save(tmp_path / "run.mcap")
    data = (tmp_path / "run.mcap").read_bytes()
    (tmp_path / "run.mcap").write_bytes(data[:-20])
    return tmp_path / "run.mcap"


def test_info_prints_what_a_log_holds_and_that_it_was_cut(log, capsys):
    assert main(["replay", str(log), "--info"]) == 0
    out, err = capsys.readouterr()
    assert "time     0.00 to 0.48 s, 30 samples, not closed" in out
    assert "modes    not recorded 0.5 s" in out
    assert "its index is cut off; every message is there; it reads up to 0.48 s" in err


def test_replay_hands_the_run_to_the_viewer(log, monkeypatch):
    shown = {}
    module = types.ModuleType("mobius.view.replay")
    module.show = lambda run, **options: shown.update(options, rows=len(run))
    monkeypatch.setitem(sys.modules, "mobius.view.replay", module)
    assert main(["replay", str(log), "--port", "0"]) == 0
    assert shown["port"] == 0  # what a taken port is told to be replaced with
    assert main(["replay", str(log), "--viewer", "native", "--port", "9000"]) == 0
    assert callable(shown.pop("ready"))
    assert shown == {"viewer": "native", "port": 9000, "shadows": True, "rows": 30}


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["replay", "nowhere"], "no such run folder or log"),
        (["replay", 300 * "a", "--info"], "the log cannot be read (File name too long)"),
        (["replay", "nowhere", "--viewer", "wed"], "Did you mean 'web'"),
        (["replay", "nowhere", "--port", "80"], "--port: expected a whole number >= 1024"),
        (["replay", "nowhere", "--port", "70000"], "--port: expected at most 65535"),
        (["export", "nowhere"], "no such run folder or log"),
    ],
)
def test_mistakes_are_told_in_one_line(words, complaint, capsys):
    assert main(words) == 2
    err = capsys.readouterr().err
    assert complaint in err
    assert "Traceback" not in err
    assert err.count("\n") == 1


def test_export_says_where_it_wrote(log, tmp_path, capsys):
    assert main(["export", str(log), "--out", str(tmp_path / "a.csv")]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text().startswith("t_s,mode,left_shoulder_yaw_rad,")
