"""Who may import whom, in one page.

Read :data:`LAYERS` from the bottom: a module imports what stands on lower lines, and
names on one line never import one another. ``make check`` holds the same rules with
import-linter (pyproject.toml); here they are plain Python that anyone can read, and the
packages that an import really loads are looked at in a fresh interpreter.
"""

import ast
import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "mobius"

LAYERS = (
    ("cli", "__main__"),
    ("choreography", "drive"),
    ("mission", "evaluate", "bench", "reproduce"),
    ("reel",),
    ("results", "pulls"),
    ("train", "bridge", "view", "sweep", "doctor", "headless"),
    ("assemble", "pace"),
    ("stack",),
    ("world", "plan", "modes", "control", "robot", "sense", "estimate"),
    ("model",),
    ("geometry", "paper", "barrier", "files"),
    ("types",),
    ("errors",),
)
HEIGHT = {name: -line for line, names in enumerate(LAYERS) for name in names}

FENCED = {
    "cma", "daqp", "didppy", "gurobipy", "imageio_ffmpeg", "matplotlib", "mcap", "mujoco", "onnx",
    "onnxruntime", "packaging", "PIL", "pyarrow", "pyscipopt", "ray", "rosbags", "rsl_rl",
    "scipy", "torch", "tqdm", "tyro", "yaml", "zenoh",
}  # fmt: skip
"""Third-party packages that a room must be entitled to; numpy is everybody's."""

MAY_LOAD = {
    "errors": set(),
    "types": set(),
    "geometry": set(),
    "paper": set(),
    "barrier": set(),
    "files": set(),
    "plan": set(),
    "modes": set(),
    "model": {"mujoco"},
    "world": {"mujoco", "PIL", "scipy", "yaml"},
    "control": {"mujoco", "onnxruntime", "scipy"},
    "robot": {"mujoco", "scipy"},
    "sense": {"mujoco", "scipy"},
    "estimate": {"mujoco", "scipy"},
    "bridge": {"mcap", "mujoco", "rosbags"},
    "doctor": {"packaging"},
    "sweep": {"mujoco", "PIL", "scipy", "yaml"},
}
"""What importing a room, with every file in it, may bring along. mujoco may come by way
of the model (which alone may say ``import mujoco``, see pyproject.toml)."""


def modules(name: str) -> list[Path]:
    """Files of a room, or of a single-file module; empty while it is not written."""
    single = SOURCE / f"{name}.py"
    return [single] if single.exists() else sorted((SOURCE / name).rglob("*.py"))


def imported(path: Path) -> set[str]:
    """First names below ``mobius`` that a file imports, at the top or inside a function."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(), str(path))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: write imports in full, not relative"
            names += [f"{node.module}.{alias.name}" for alias in node.names]
    parts = [name.split(".") for name in names]
    return {p[1] for p in parts if p[0] == "mobius" and len(p) > 1} & set(HEIGHT)


def loaded_by(code: str) -> set[str]:
    """Top-level packages in ``sys.modules`` after running ``code`` in a fresh interpreter."""
    show = "import json, sys; print(json.dumps(sorted({m.split('.')[0] for m in sys.modules})))"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{show}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def test_every_module_has_its_place():
    found = {p.stem for p in SOURCE.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    assert found - {"__init__"} <= set(HEIGHT)


@pytest.mark.parametrize("name", HEIGHT)
def test_a_module_imports_only_what_stands_below_it(name):
    wrong = [
        f"{path.relative_to(SOURCE)} imports mobius.{other}"
        for path in modules(name)
        for other in sorted(imported(path) - {name})
        if HEIGHT[other] >= HEIGHT[name]
    ]
    assert not wrong


def test_import_linter_is_told_the_same_layers():
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text())
    contracts = pyproject["tool"]["importlinter"]["contracts"]
    (layers,) = (c["layers"] for c in contracts if c["type"] == "layers")
    told = tuple(tuple(n.strip().strip("()") for n in line.split("|")) for line in layers)
    assert told == LAYERS


@pytest.mark.parametrize("name", MAY_LOAD)
def test_importing_a_room_loads_only_its_third_parties(name):
    files = modules(name)
    if not files:
        pytest.skip(f"mobius.{name} is not written yet")
    dotted = [
        ".".join(("mobius", *path.relative_to(SOURCE).with_suffix("").parts)) for path in files
    ]
    code = "\n".join(f"import {d.removesuffix('.__init__')}" for d in dotted)
    assert loaded_by(code) & FENCED <= MAY_LOAD[name]


def test_import_mobius_loads_numpy_and_nothing_else_of_weight():
    assert not loaded_by("import mobius") & FENCED


def test_import_mobius_plan_loads_neither_mujoco_nor_torch():
    assert not loaded_by("import mobius.plan") & {"mujoco", "torch"}
