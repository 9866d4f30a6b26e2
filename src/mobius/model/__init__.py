"""What the robot is: dimensions, joints, servos, closed-form kinematics, MJCF.

Importing this room does not load mujoco; :mod:`mobius.model.robot` does.
"""

from mobius.model.dimensions import LimbGeometry as LimbGeometry
from mobius.model.dimensions import limb_geometry as limb_geometry
from mobius.model.fivebar import FiveBar as FiveBar
from mobius.model.joints import JOINTS as JOINTS
from mobius.model.joints import LIMB_JOINTS as LIMB_JOINTS
from mobius.model.joints import joint_index as joint_index
