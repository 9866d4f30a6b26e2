"""Moves the obstacles of a scenario in physics, and tells the pilot."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from mobius.mission.body import BIPED_ROOM
from mobius.mission.footprint import WIDE
from mobius.mission.pilot import Pilot
from mobius.world import Scenario, Scenery, World, with_obstacles

BERTH = BIPED_ROOM + WIDE.margin
"""An obstacle does not come this near to the robot's trunk [m]; it waits. The robot may lie down
or fall there."""


class Stagehand:
    """Carries out a scenario."""

    def __init__(self, world: World, scenario: Scenario | None) -> None:
        """Args: the world as its map shows it; what happens in it, if anything does."""
        self._bare, self.scenery = world, Scenery(scenario or Scenario())
        self._obstacles = {o.name: o for o in self.scenery.scenario.obstacles}
        self.log: list[dict[str, Any]] = []
        """What happened: ``t`` [s], ``what`` and ``obstacle``."""

    def world(self, *, check: bool = False) -> World:
        """The world as it is now; with ``check`` start and goal must be fit and joined."""
        return with_obstacles(self._bare, self.scenery.areas, check=check)

    def turn(self, t: float, xy_M: ArrayLike, robot: Any, pilot: Pilot) -> None:
        """Carry out what is due at time t [s] with the trunk at (2,) [m]."""
        from mobius.world.scene import movable_pose

        if not self.scenery.pending:
            return
        events = self.scenery.due(t, xy_M, self._bare.grid, room=BERTH)
        for event in events:
            obstacle = self._obstacles[event.obstacle]
            slot = int(robot.model.body(f"moving_{obstacle.name}").mocapid[0])
            robot.data.mocap_pos[slot], robot.data.mocap_quat[slot] = movable_pose(
                obstacle, event.area
            )
            self.log.append({"t": t, "what": event.what, "obstacle": event.obstacle})
        if events:
            pilot.know(self.world())
