"""Motions between bodies (Fig. 13): key poses as data, and what plays them.

A motion is a list of stages; each moves the servo targets smoothly to a key pose and may
wait for the trunk to turn. :func:`load_motion` reads one of ``data/NAME.json``.
"""

from mobius.modes.motions.gather import Gathered as Gathered
from mobius.modes.motions.gather import build_gather as build_gather
from mobius.modes.motions.load import load_motion as load_motion
from mobius.modes.motions.load import motion_names as motion_names
from mobius.modes.motions.load import read_motion as read_motion
from mobius.modes.motions.motion import Feedback as Feedback
from mobius.modes.motions.motion import Guard as Guard
from mobius.modes.motions.motion import Motion as Motion
from mobius.modes.motions.motion import Stage as Stage
from mobius.modes.motions.motion import Until as Until
from mobius.modes.motions.motion import Window as Window
from mobius.modes.motions.player import MotionPlayer as MotionPlayer
from mobius.modes.motions.tilt import Tilt as Tilt
from mobius.modes.motions.tilt import tilt_of as tilt_of
