"""Which body to be: the mode machine and the follower of plans."""

from mobius.modes.follow import FollowerConfig as FollowerConfig
from mobius.modes.follow import PathFollower as PathFollower
from mobius.modes.machine import SUCCESSORS as SUCCESSORS
from mobius.modes.machine import ModeMachine as ModeMachine
from mobius.modes.modal import ModalFollower as ModalFollower
from mobius.modes.tasks import TaskConfig as TaskConfig
