"""The room needs numpy and nothing else."""

from __future__ import annotations

import subprocess
import sys

FOREIGN = (
    "mujoco", "torch", "scipy", "yaml", "matplotlib", "onnxruntime", "didppy", "pyscipopt",
)  # fmt: skip


def test_planning_loads_neither_mujoco_nor_torch_nor_scipy():
    code = (
        "import sys, mobius.plan as p, mobius.plan.solvers as s;"
        "s.solver_of('exact')(p.build_problem(p.reconstructed_map(), horizon=20), 1.0);"
        "[s.solver_of(name) for name in s.BUILT_IN];"
        f"print(sorted(m for m in {FOREIGN} if m in sys.modules))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_no_other_room_is_loaded():
    code = (
        "import sys, mobius.plan;"
        "print(sorted(m for m in sys.modules if m.startswith('mobius.')"
        " and not m.startswith('mobius.plan') and m not in ('mobius.types', 'mobius.errors',"
        " 'mobius.paper', 'mobius.barrier')))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
