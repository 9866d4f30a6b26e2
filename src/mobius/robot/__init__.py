"""The machine: one protocol, several bodies. ``robot.sim`` loads mujoco, this does not."""

from mobius.robot.ghost import GhostRobot as GhostRobot
from mobius.robot.interface import TICK as TICK
from mobius.robot.interface import Observable as Observable
from mobius.robot.interface import Robot as Robot
from mobius.robot.limits import limit_targets as limit_targets
