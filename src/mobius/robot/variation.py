"""How a simulated robot and its floor may differ from the drawing."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Variation:
    """One draw of friction, mass, servo strength and delay; the default is the drawing."""

    friction: float = 0.8
    """Sliding friction of the soles; elsewhere it is MuJoCo's 1."""
    trunk_mass: float = 0.0
    """Added to the trunk [kg]."""
    trunk_com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Shift of the trunk's centre of mass [m]."""
    servo_gain: float = 1.0
    """Factor on stiffness and stall torque of all servos."""
    delay_ticks: int = 0
    """Targets reach the servos this many 1/600 s ticks late."""
    everywhere: bool = False
    """The friction is that of all the robot's surfaces: trunk, rails and links as well."""

    @classmethod
    def sample(cls, rng: np.random.Generator) -> Variation:
        """Friction 0.5-1.2, trunk +-1 kg (10 %), CoM +-2 cm, servos +-10 %, delay 0-20 ms."""
        com = rng.uniform(-0.02, 0.02, 3)
        return cls(
            friction=float(rng.uniform(0.5, 1.2)),
            trunk_mass=float(rng.uniform(-1.0, 1.0)),
            trunk_com=(float(com[0]), float(com[1]), float(com[2])),
            servo_gain=float(rng.uniform(0.9, 1.1)),
            delay_ticks=int(rng.integers(0, 13)),
        )

    def apply(self, model: mujoco.MjModel) -> None:
        """Write the variation into a freshly compiled model."""
        trunk = model.body("base_link").id
        scale = (model.body_mass[trunk] + self.trunk_mass) / model.body_mass[trunk]
        model.body_mass[trunk] *= scale
        model.body_inertia[trunk] *= scale
        model.body_ipos[trunk] += self.trunk_com
        for i in range(model.ngeom):
            robots = self.everywhere and model.body_rootid[model.geom_bodyid[i]] == trunk
            if "_sole" in model.geom(i).name or (robots and model.geom_contype[i]):
                model.geom_friction[i, 0] = self.friction
                model.geom_priority[i] = 1
        model.actuator_gainprm[:, 0] *= self.servo_gain
        model.actuator_biasprm[:, 1] *= self.servo_gain
        model.actuator_forcerange[:] *= self.servo_gain
        mujoco.mj_setConst(model, mujoco.MjData(model))
