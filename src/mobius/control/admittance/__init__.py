"""Admittance control of the grippers, Eq. (20) and (22): law, wrenches, both arms' loop.

``AxisLaw(AxisGains(...)).matrices()`` is the one-axis law as a linear system, for governors;
:class:`Admittance` runs six axes of any number of grippers; :class:`ForceLoop` is the whole
loop of this robot's arms.
"""

from mobius.control.admittance.config import AXES as AXES
from mobius.control.admittance.config import AdmittanceConfig as AdmittanceConfig
from mobius.control.admittance.config import FtSensor as FtSensor
from mobius.control.admittance.config import GravityCompensation as GravityCompensation
from mobius.control.admittance.config import from_ros as from_ros
from mobius.control.admittance.controller import Admittance as Admittance
from mobius.control.admittance.controller import Governed as Governed
from mobius.control.admittance.controller import Governor as Governor
from mobius.control.admittance.controller import Motion as Motion
from mobius.control.admittance.law import DT as DT
from mobius.control.admittance.law import SERVO_LAG as SERVO_LAG
from mobius.control.admittance.law import AxisGains as AxisGains
from mobius.control.admittance.law import AxisLaw as AxisLaw
from mobius.control.admittance.law import Lti as Lti
from mobius.control.admittance.loop import ForceLoop as ForceLoop
from mobius.control.admittance.loop import LoopOutput as LoopOutput
from mobius.control.admittance.loop import mobius_config as mobius_config
from mobius.control.admittance.loop import mobius_tool as mobius_tool
from mobius.control.admittance.stability import Interval as Interval
from mobius.control.admittance.stability import Loop as Loop
from mobius.control.admittance.stability import damping as damping
from mobius.control.admittance.stability import spectral_radius as spectral_radius
from mobius.control.admittance.wrench import WrenchConditioner as WrenchConditioner
from mobius.control.admittance.wrench import Wrenches as Wrenches
