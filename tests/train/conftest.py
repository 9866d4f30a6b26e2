"""torch's idle threads sleep: spinning ones would take the cores from everything else."""

import os

os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # before torch is imported
