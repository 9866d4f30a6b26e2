"""What the robot feels: perfect readings made real by noise, drift, delay and drop-outs."""

from mobius.sense.senses import Senses as Senses
from mobius.sense.vio import VioModel as VioModel
from mobius.sense.vio import VioParameters as VioParameters
