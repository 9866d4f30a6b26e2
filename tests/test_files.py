"""Files are whole or absent, whatever happens while they are written."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.files import copy_atomic, write_bytes_atomic, write_json_atomic, write_text_atomic


def test_bytes_text_and_json_come_back_as_written(tmp_path):
    write_bytes_atomic(tmp_path / "a.bin", b"\x00\xff")
    write_text_atomic(tmp_path / "a.txt", "größe")
    write_json_atomic(tmp_path / "a.json", {"falls": 0})
    assert (tmp_path / "a.bin").read_bytes() == b"\x00\xff"
    assert (tmp_path / "a.txt").read_text(encoding="utf-8") == "größe"
    assert json.loads((tmp_path / "a.json").read_text()) == {"falls": 0}


def test_missing_folders_are_made_and_no_temporary_file_stays(tmp_path):
    write_text_atomic(tmp_path / "runs" / "1" / "a.txt", "x")
    assert os.listdir(tmp_path / "runs" / "1") == ["a.txt"]


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    write_text_atomic(tmp_path / "a", "old")
    with pytest.raises(TypeError):
        write_bytes_atomic(tmp_path / "a", 3)  # type: ignore[arg-type]
    assert (tmp_path / "a").read_text() == "old"
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("value", [{"x": float("nan")}, {"x": np.zeros(2)}])
def test_json_that_is_no_json_is_refused_before_anything_is_written(tmp_path, value):
    with pytest.raises(InvalidInput, match=r"a\.json: expected plain finite JSON"):
        write_json_atomic(tmp_path / "a.json", value)
    assert os.listdir(tmp_path) == []


def test_copy_keeps_the_source_and_replaces_the_target(tmp_path):
    (tmp_path / "from").write_bytes(b"new")
    (tmp_path / "to").write_bytes(b"old")
    copy_atomic(tmp_path / "from", tmp_path / "to")
    assert (tmp_path / "to").read_bytes() == b"new"
    assert (tmp_path / "from").exists()


def test_the_file_gets_the_usual_permissions(tmp_path):
    """Temporary files are private to their owner; a report is for everyone the umask admits."""
    (tmp_path / "plain").write_text("x")
    write_text_atomic(tmp_path / "ours", "x")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_kill_in_the_middle_of_writing_leaves_the_old_file(tmp_path):
    code = (
        "import os, signal, sys, pathlib\n"
        "from mobius import files\n"
        "os.fsync = lambda fd: os.kill(os.getpid(), signal.SIGKILL)\n"
        "files.write_text_atomic(sys.argv[1], 'new' * 1000)\n"
    )
    (tmp_path / "a").write_text("old")
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "a")], check=False)
    assert done.returncode == -signal.SIGKILL
    assert (tmp_path / "a").read_text() == "old"
