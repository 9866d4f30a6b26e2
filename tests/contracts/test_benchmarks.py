"""Benchmarks are scripts that no other test runs: each must at least come up."""

import importlib.util
import sys
from pathlib import Path

import pytest

FILES = sorted((Path(__file__).parents[2] / "benchmarks").glob("*.py"))
SCRIPTS = [path for path in FILES if '__name__ == "__main__"' in path.read_text()]


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda p: p.stem)
def test_imports(script, monkeypatch):
    monkeypatch.syspath_prepend(script.parent)  # as python does for a script
    if script.stem in ("clock_free", "bench_train"):
        pytest.importorskip("torch")
    spec = importlib.util.spec_from_file_location(f"benchmark_{script.stem}", script)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # dataclasses look themselves up there
    spec.loader.exec_module(module)
    assert callable(module.main)
