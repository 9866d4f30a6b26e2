"""A table of settings times a pure function: many plans, on every processor, kill-proof.

    settings = product_of({"horizon": [10, 20], "W_exp": [1.0, 50.0]})
    done = run_sweep(work, settings, "folder", workers=2)     # work(setting) -> row

Finished rows are on disk at once; ``resume=True`` goes on after a kill. Ray is optional.
"""

from mobius.sweep.planner import PlannerWork as PlannerWork
from mobius.sweep.planner import plan_row as plan_row
from mobius.sweep.run import Swept as Swept
from mobius.sweep.run import run_sweep as run_sweep
from mobius.sweep.settings import Row as Row
from mobius.sweep.settings import Setting as Setting
from mobius.sweep.settings import product_of as product_of
