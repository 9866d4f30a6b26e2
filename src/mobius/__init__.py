"""MOBIUS: a map becomes a plan, a plan a mode, a mode joint targets; the robot turns
targets into readings, and the estimator turns readings into belief.

    world -> plan -> modes -> control -> robot -> sense -> estimate
                       ^                                      |
                       +------------- stack.py ---------------+
"""

from mobius.errors import MobiusError as MobiusError
from mobius.types import GridMap as GridMap
from mobius.types import JointCommand as JointCommand
from mobius.types import Mode as Mode
from mobius.types import ModeCommand as ModeCommand
from mobius.types import Plan as Plan
from mobius.types import Pose as Pose
from mobius.types import SensorFrame as SensorFrame
from mobius.types import StateEstimate as StateEstimate


def __getattr__(name: str) -> str:
    """``mobius.__version__``, looked up when asked for (it would double the import time)."""
    if name == "__version__":
        from importlib.metadata import version

        return version("mobius")
    raise AttributeError(f"module 'mobius' has no attribute '{name}'")
