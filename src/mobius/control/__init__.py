"""How to move: from a mode command and a belief to servo targets."""

from mobius.control.bodies import BODIES as BODIES
from mobius.control.bodies import Body as Body
from mobius.control.bodies import body_of as body_of
from mobius.control.observation import Layout as Layout
from mobius.control.observation import build_frame as build_frame
