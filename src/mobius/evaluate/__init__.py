"""How good a policy is, in the whole stack and against the truth.

Everything runs with full collision geometry, physics at 1/600 s, a robot, floor and sensors
drawn from the seed, and a controller that sees the estimator's belief, never the truth. What
drives may be an ONNX file, one of the peers ``zero`` and ``random``, or any controller.
"""

from mobius.evaluate.push import Push as Push
from mobius.evaluate.push import push as push
from mobius.evaluate.robustness import SWEEPS as SWEEPS
from mobius.evaluate.robustness import Robustness as Robustness
from mobius.evaluate.robustness import robustness as robustness
from mobius.evaluate.tables import Outcome as Outcome
from mobius.evaluate.terrain import KINDS as KINDS
from mobius.evaluate.terrain import Terrain as Terrain
from mobius.evaluate.terrain import terrain as terrain
from mobius.evaluate.tracking import Tracking as Tracking
from mobius.evaluate.tracking import tracking as tracking
