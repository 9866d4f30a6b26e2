"""One run over a map: load, plan, drive, judge, and leave files to look at."""

from mobius.mission.body import ARRIVE_WITHIN as ARRIVE_WITHIN
from mobius.mission.body import DRIVABLE as DRIVABLE
from mobius.mission.body import check_modes as check_modes
from mobius.mission.drive import Driven as Driven
from mobius.mission.drive import drive as drive
from mobius.mission.footprint import NARROW as NARROW
from mobius.mission.footprint import WIDE as WIDE
from mobius.mission.footprint import Footprint as Footprint
from mobius.mission.footprint import footprint_of as footprint_of
from mobius.mission.pilot import Pilot as Pilot
from mobius.mission.prepare import open_world as open_world
from mobius.mission.prepare import plan_mission as plan_mission
from mobius.mission.run import Outcome as Outcome
from mobius.mission.run import run as run
from mobius.mission.summary import summarise as summarise
