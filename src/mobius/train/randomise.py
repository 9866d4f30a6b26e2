"""Domain randomisation: Table III, Algorithms 1 and 2, row by row."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import quat_mul, rpy_to_quat
from mobius.train.batch import CpuBatch
from mobius.train.presets import Randomisation

if TYPE_CHECKING:
    from mobius.train.env import LocomotionEnv

Array = NDArray[np.float64]


class Randomiser:
    """Draws the variations of n robots."""

    def __init__(self, sim: CpuBatch, cfg: Randomisation, rng: np.random.Generator) -> None:
        self.sim, self.cfg, self.rng = sim, cfg, rng
        model, n = sim.model, sim.n
        self._trunk = model.body("base_link").id
        self._soles = np.array(
            [i for i in range(model.ngeom) if "_sole" in model.geom(i).name], dtype=np.int64
        )
        self._kp = model.actuator_gainprm[:, 0].copy()
        self._mass0 = float(model.body_mass[self._trunk])
        self._inertia0 = model.body_inertia[self._trunk].copy()
        self._ipos0 = model.body_ipos[self._trunk].copy()
        self._kick_left = np.full(n, np.inf)
        self._n_delay = np.ones(n, dtype=np.int64)
        self.mass, self.friction = np.zeros(n), np.full(n, 0.8)
        self.com, self.gain = np.zeros((n, 3)), np.ones((n, len(self._kp)))

    def new_episode(self, ids: NDArray[np.int64]) -> None:
        """Draw body, friction, servo gains and delays of robots (m,) anew."""
        m, cfg, rng = len(ids), self.cfg, self.rng
        self.mass[ids] = rng.uniform(*cfg.trunk_mass, m)
        self.com[ids] = rng.uniform(-cfg.trunk_com, cfg.trunk_com, (m, 3))
        self.friction[ids] = 0.8 + rng.uniform(*cfg.friction, m)
        self.gain[ids] = 1.0 + rng.uniform(-cfg.gain, cfg.gain, (m, len(self._kp)))
        mass = self._mass0 + self.mass[ids]
        self.sim.mass[ids, self._trunk] = mass
        self.sim.inertia[ids, self._trunk] = self._inertia0 * (mass / self._mass0)[:, None]
        self.sim.ipos[ids, self._trunk] = self._ipos0 + self.com[ids]
        self.sim.friction[ids[:, None], self._soles, 0] = self.friction[ids, None]
        kp = self._kp * self.gain[ids]
        self.sim.gain[ids, :, 0] = kp
        self.sim.bias[ids, :, 1] = -kp
        self.sim.constants_changed(ids)
        self._n_delay[ids] = rng.integers(1, cfg.delay_steps + 1, m)
        self._kick_left[ids] = rng.uniform(*cfg.kick_interval, m)

    def kick(self, dt: float) -> None:
        """Alg. 2: a horizontal velocity step of random direction at random intervals [s]."""
        if self.cfg.kick_velocity <= 0:
            return
        self._kick_left -= dt
        due = np.flatnonzero(self._kick_left <= 0)
        if due.size:
            angle = self.rng.uniform(0, 2 * np.pi, due.size)
            size = self.rng.uniform(0, self.cfg.kick_velocity, due.size)
            self.sim.qvel[due, 0] += size * np.cos(angle)
            self.sim.qvel[due, 1] += size * np.sin(angle)
            self._kick_left[due] = self.rng.uniform(*self.cfg.kick_interval, due.size)

    def delay(self) -> NDArray[np.int64]:
        """Alg. 1: (n,) how many steps old the observed frame is; 0 with chance 1 - p."""
        n = self.sim.n
        late = self.rng.random(n) < self.cfg.delay_chance
        steps = 1 + np.floor(self.rng.random(n) * self._n_delay).astype(np.int64)
        return np.where(late, steps, 0)

    def noisy(self, q: Array, v_B: Array, w_B: Array, joints: Array) -> tuple[Array, ...]:
        """Table III's additive noise on orientation, velocities and encoders."""
        cfg, rng = self.cfg, self.rng

        def noise(shape: tuple[int, ...], size: float) -> Array:
            return rng.uniform(-size, size, shape) if size > 0 else np.zeros(shape)

        turn = noise((len(q), 3), cfg.orientation)
        return (
            quat_mul(q, rpy_to_quat(turn[:, 0], turn[:, 1], turn[:, 2])),
            v_B + noise(v_B.shape, cfg.linear_velocity),
            w_B + noise(w_B.shape, cfg.angular_velocity),
            joints + noise(joints.shape, cfg.encoder),
        )

    def describe(self) -> Array:
        """(n, 5) mass, com, friction for the critic."""
        return np.column_stack([self.mass, self.com * 10.0, self.friction])


def settle_pool(env: LocomotionEnv) -> tuple[Array, Array]:
    """Start states (n, nq), (n, nv): the stance after 0.3 s of small random targets.

    Noise put straight on the joints would tear the five-bars open; this keeps them closed.
    """
    ids = np.arange(env.n)
    nv, nu = env.sim.model.nv, env.sim.model.nu
    start = np.tile(env.home, (env.n, 1))
    env.sim.place(ids, start, np.zeros((env.n, nv)), np.tile(env.ctrl0, (env.n, 1)))
    for _ in range(18):
        noise = env.rng.normal(0, max(env.cfg.randomisation.initial_joint, 1e-9), (env.n, nu))
        env.sim.ctrl[:] = env.ctrl0 + noise
        env.sim.step(env.cfg.substeps)
    qpos = np.array(env.sim.qpos)
    qpos[:, :2] = 0.0
    return qpos, np.array(env.sim.qvel)
