"""Trees as safetensors: everything comes back bit for bit, nothing else is let in."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("safetensors")

import safetensors.numpy

from mobius.errors import InvalidInput
from mobius.train.checkpoint import read_tree, write_tree

TREE = {
    "env": {
        "state": np.random.default_rng(0).normal(size=(3, 4)),
        "frames": np.array([[np.nan, np.inf], [-0.0, 5e-324]]),
        "done": np.array([True, False]),
        "none": np.zeros((0, 3)),
        "view": np.arange(12, dtype=np.int64).reshape(3, 4).T[1:],
        "rng": np.random.default_rng(7).bit_generator.state,  # two whole numbers of 128 bits
    },
    "torch": np.arange(5, dtype=np.uint8),
    "count": np.array(3),
    "learning_rate": 0.1 + 0.2,
    "steps": 2**60,
    "python": {"words": (1, 2, 3), "gauss": None},
    "name": "crawl",
    "on": True,
    "params": [np.ones(2, dtype=np.float32), np.zeros(1, dtype=np.float32)],
    "empty": {},
}


def assert_same(a, b, where="tree"):
    if isinstance(a, dict):
        assert isinstance(b, dict) and a.keys() == b.keys(), where
        for key in a:
            assert_same(a[key], b[key], f"{where}/{key}")
    elif isinstance(a, list | tuple):
        assert len(a) == len(b), where
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{where}/{i}")
    elif isinstance(a, np.ndarray):
        assert a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(), where
    else:
        assert a == b and type(a) is type(b), where


def test_a_tree_comes_back_bit_for_bit(tmp_path):
    write_tree(tmp_path / "deep" / "t.safetensors", TREE)
    assert_same(TREE, read_tree(tmp_path / "deep" / "t.safetensors"))
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["t.safetensors"]


def test_the_file_is_plain_safetensors(tmp_path):
    path = tmp_path / "t.safetensors"
    write_tree(path, TREE)
    arrays = safetensors.numpy.load_file(path)
    np.testing.assert_array_equal(arrays["env/state"], TREE["env"]["state"])
    assert "params/1" in arrays


@pytest.mark.parametrize("keep", [0, 5, 300, -1])
def test_a_cut_off_file_is_refused_in_one_line(tmp_path, keep):
    path = tmp_path / "t.safetensors"
    write_tree(path, TREE)
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(InvalidInput, match="not a whole safetensors file") as caught:
        read_tree(path)
    assert "\n" not in str(caught.value)


def test_foreign_and_missing_files_are_refused(tmp_path):
    foreign = tmp_path / "foreign.safetensors"
    safetensors.numpy.save_file({"x": np.zeros(2)}, foreign)
    with pytest.raises(InvalidInput, match="format 'mobius tree 1', got 'None'"):
        read_tree(foreign)
    pickle = tmp_path / "checkpoint.pt"
    pickle.write_bytes(b"\x80\x04" + bytes(200))
    with pytest.raises(InvalidInput, match="not a whole safetensors file"):
        read_tree(pickle)
    with pytest.raises(InvalidInput, match="no such file"):
        read_tree(tmp_path / "absent.safetensors")


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        ({"x": float("nan")}, "cannot store"),
        ({"x": object()}, "cannot store"),
        ({1: 2}, "string keys"),
        ({"a": {"$array": "b"}}, "string keys"),
        ({"a/b": np.zeros(1), "a": {"b": np.zeros(1)}}, "two arrays"),
    ],
)
def test_what_cannot_be_stored_is_refused_and_the_old_file_stays(tmp_path, tree, message):
    path = tmp_path / "t.safetensors"
    write_tree(path, {"x": 1})
    with pytest.raises(InvalidInput, match=message):
        write_tree(path, tree)
    assert read_tree(path) == {"x": 1}


def test_a_failure_while_writing_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "t.safetensors"
    write_tree(path, {"x": 1})

    def full(_):
        raise OSError("disk full")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="disk full"):
        write_tree(path, TREE)
    assert read_tree(path) == {"x": 1}
    assert [p.name for p in tmp_path.iterdir()] == ["t.safetensors"]


def test_training_uses_no_pickle():
    source = Path(__file__).parents[2] / "src" / "mobius" / "train"
    text = "".join(p.read_text() for p in source.glob("*.py"))
    for word in ("import pickle", "torch.load", "torch.save", "np.load"):
        assert word not in text


def test_json_of_the_tree_is_strict(tmp_path):
    path = tmp_path / "t.safetensors"
    write_tree(path, TREE)
    with safetensors.safe_open(path, framework="numpy") as file:
        json.loads(file.metadata()["tree"], parse_constant=lambda c: pytest.fail(c))
