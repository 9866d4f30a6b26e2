"""Runs of the whole stack that are made to be looked at: single motions and the demo reel."""

from mobius.reel.acts import Act as Act
from mobius.reel.acts import Script as Script
from mobius.reel.film import Footage as Footage
from mobius.reel.film import film as film
from mobius.reel.shows import SHOWS as SHOWS
from mobius.reel.shows import play as play
from mobius.reel.write import write_show as write_show
