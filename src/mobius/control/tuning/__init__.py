"""Tuning of admittance gains while the robot works; optional, nothing else needs it.

The method is that of Menner, Berntorp and Di Cairano, "Automated controller calibration by
Kalman filtering" (arXiv 2111.10832). A patent application on the method's family exists.
"""

from mobius.control.tuning.attach import Attached as Attached
from mobius.control.tuning.specification import Specification as Specification
from mobius.control.tuning.stiffness import ContactEstimate as ContactEstimate
from mobius.control.tuning.stiffness import StiffnessEstimator as StiffnessEstimator
from mobius.control.tuning.tuner import Report as Report
from mobius.control.tuning.tuner import Tuner as Tuner
from mobius.control.tuning.tuner import TunerConfig as TunerConfig
from mobius.control.tuning.ukf import SquareRootUkf as SquareRootUkf
