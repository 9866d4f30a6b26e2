"""One run over a map: load, plan, drive, judge, and leave files to look at."""

from mobius.mission.body import ARRIVE_WITHIN as ARRIVE_WITHIN
from mobius.mission.body import DRIVABLE as DRIVABLE
from mobius.mission.body import FOOTPRINT_MARGIN as FOOTPRINT_MARGIN
from mobius.mission.body import FOOTPRINT_RADIUS as FOOTPRINT_RADIUS
from mobius.mission.body import LANE as LANE
from mobius.mission.body import check_modes as check_modes
from mobius.mission.drive import Driven as Driven
from mobius.mission.drive import drive as drive
from mobius.mission.pilot import Pilot as Pilot
from mobius.mission.prepare import open_world as open_world
from mobius.mission.prepare import plan_mission as plan_mission
from mobius.mission.run import Outcome as Outcome
from mobius.mission.run import run as run
from mobius.mission.summary import summarise as summarise
