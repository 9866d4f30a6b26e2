"""Where the robot lives: a map someone drew becomes a grid to plan on and a scene to walk in.

    map.yaml + image, .map  --load-->  World (raster, grid, shapes)  --scene-->  MuJoCo

``mobius.world.scene`` is not imported here, so that planning needs no MuJoCo.
"""

from mobius.world.grid import Disc as Disc
from mobius.world.load import World as World
from mobius.world.load import load_world as load_world
from mobius.world.load import map_names as map_names
from mobius.world.load import map_path as map_path
from mobius.world.movingai import read_movingai as read_movingai
from mobius.world.nav2 import read_nav2 as read_nav2
from mobius.world.nav2 import write_nav2 as write_nav2
from mobius.world.occupancy import OccupancyMap as OccupancyMap
