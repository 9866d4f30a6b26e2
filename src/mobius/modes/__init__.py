"""Which body to be: the mode machine, motions between bodies, and the follower of plans."""

from mobius.modes.follow import FollowerConfig as FollowerConfig
from mobius.modes.follow import PathFollower as PathFollower
from mobius.modes.gather import Gather as Gather
from mobius.modes.machine import SUCCESSORS as SUCCESSORS
from mobius.modes.machine import Event as Event
from mobius.modes.machine import MachineConfig as MachineConfig
from mobius.modes.machine import ModeMachine as ModeMachine
from mobius.modes.machine import Seen as Seen
from mobius.modes.modal import ModalFollower as ModalFollower
from mobius.modes.motions import MotionPlayer as MotionPlayer
from mobius.modes.motions import load_motion as load_motion
from mobius.modes.motions import motion_names as motion_names
from mobius.modes.motions.gather import Gathered as Gathered
from mobius.modes.posture import FallDetector as FallDetector
from mobius.modes.posture import Posture as Posture
from mobius.modes.posture import posture_of as posture_of
from mobius.modes.recover import Recovery as Recovery
from mobius.modes.rest import DampedHold as DampedHold
from mobius.modes.tasks import TaskConfig as TaskConfig
from mobius.modes.tasks import check_roll as check_roll
from mobius.modes.trust import Trust as Trust
from mobius.modes.trust import TrustWatch as TrustWatch
