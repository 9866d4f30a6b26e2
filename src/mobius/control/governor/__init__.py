"""Reference governors: a loop never breaks its limits, whatever reference is asked for.

Alone this room needs numpy and scipy only (the command governor daqp too). Any stable linear
loop can be governed:

    loop = LinearSystem(A, B, C)
    governor = ScalarGovernor(exact_set(loop, Constraints.box(low, high)))
    v = governor.step(x, r)          # every tick; give v to the loop instead of r
"""

from mobius.control.governor.admissible import AdmissibleSet as AdmissibleSet
from mobius.control.governor.command import CommandGovernor as CommandGovernor
from mobius.control.governor.exact_set import EmptySet as EmptySet
from mobius.control.governor.exact_set import exact_set as exact_set
from mobius.control.governor.family_set import family_set as family_set
from mobius.control.governor.interface import Governor as Governor
from mobius.control.governor.interface import Verdict as Verdict
from mobius.control.governor.nearest import NearestGovernor as NearestGovernor
from mobius.control.governor.plant import AXES as AXES
from mobius.control.governor.plant import Axis as Axis
from mobius.control.governor.plant import axis_set as axis_set
from mobius.control.governor.plant import axis_system as axis_system
from mobius.control.governor.sampled_set import SampledSet as SampledSet
from mobius.control.governor.sampled_set import algorithm_3 as algorithm_3
from mobius.control.governor.scalar import ScalarGovernor as ScalarGovernor
from mobius.control.governor.system import Constraints as Constraints
from mobius.control.governor.system import Disturbance as Disturbance
from mobius.control.governor.system import LinearSystem as LinearSystem
