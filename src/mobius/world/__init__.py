"""Where the robot lives: a map someone drew becomes a grid to plan on and a scene to walk in.

    map.yaml + image, .map  --load-->  World (raster, grid, shapes)  --scene-->  MuJoCo

``mobius.world.scene`` is not imported here, so that planning needs no MuJoCo.
"""

from mobius.world.change import with_obstacles as with_obstacles
from mobius.world.grid import Disc as Disc
from mobius.world.load import World as World
from mobius.world.load import load_world as load_world
from mobius.world.load import map_names as map_names
from mobius.world.load import map_path as map_path
from mobius.world.movingai import read_movingai as read_movingai
from mobius.world.nav2 import read_nav2 as read_nav2
from mobius.world.nav2 import write_nav2 as write_nav2
from mobius.world.occupancy import OccupancyMap as OccupancyMap
from mobius.world.scenario import Scenario as Scenario
from mobius.world.scenario import Scenery as Scenery
from mobius.world.scenario import check_scenario as check_scenario
from mobius.world.scenario import read_scenario as read_scenario
