"""Domain randomisation: Table III, Algorithms 1 and 2, row by row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mobius.geometry import quat_mul, rpy_to_quat
from mobius.model import robot
from mobius.train.batch import CpuBatch
from mobius.train.presets import Randomisation

if TYPE_CHECKING:
    from mobius.train.env import LocomotionEnv

Array = NDArray[np.float64]
_DRAWN = ("kick_left", "kick_every", "n_delay", "mass", "friction", "com", "gain")


class Randomiser:
    """Draws the variations of n robots."""

    def __init__(self, sim: CpuBatch, cfg: Randomisation, rng: np.random.Generator) -> None:
        self.sim, self.cfg, self.rng = sim, cfg, rng
        model, n = sim.model, sim.n
        self._trunk = model.body("base_link").id
        self._foot = sim.soles[sim.soles >= 0]
        self._foot_of = np.nonzero(sim.soles >= 0)[0]
        self._kp = model.actuator_gainprm[:, 0].copy()
        self._force0 = model.actuator_forcerange.copy()
        self._mass0 = float(model.body_mass[self._trunk])
        self._inertia0 = model.body_inertia[self._trunk].copy()
        self._ipos0 = model.body_ipos[self._trunk].copy()
        self.kick_left, self.kick_every = np.full(n, np.inf), np.full(n, np.inf)
        self.n_delay = np.ones(n, dtype=np.int64)
        self.mass, self.friction = np.zeros(n), np.full(n, 0.8)
        self.com, self.gain = np.zeros((n, 3)), np.ones((n, len(self._kp)))

    def new_episode(self, ids: NDArray[np.int64]) -> None:
        """Draw body, friction, servos and delays of robots (m,) anew (rows 7 to 13)."""
        m, cfg, rng, sim = len(ids), self.cfg, self.rng, self.sim
        self.mass[ids] = np.maximum(rng.uniform(*cfg.trunk_mass, m), cfg.trunk_floor - self._mass0)
        self.com[ids] = rng.uniform(-cfg.trunk_com, cfg.trunk_com, (m, 3))
        self.friction[ids] = 0.8 + rng.uniform(*cfg.friction, m)
        kp = self._servo(ids, rng.uniform(-1, 1, (m, len(self._kp))))
        spread = cfg.bias * rng.uniform(-1, 1, kp.shape)
        mass = self._mass0 + self.mass[ids]
        fields = sim.fields
        fields["mass"][ids, self._trunk] = mass
        fields["inertia"][ids, self._trunk] = self._inertia0 * (mass / self._mass0)[:, None]
        fields["ipos"][ids, self._trunk] = self._ipos0 + self.com[ids]
        fields["friction"][ids[:, None], self._foot, 0] = self.friction[ids, None]
        fields["gain"][ids, :, 0] = kp
        fields["bias"][ids, :, 1] = -(kp + spread)
        strength = 1.0 + rng.uniform(-cfg.strength, cfg.strength, m)
        fields["force"][ids] = self._force0 * strength[:, None, None]
        sim.constants_changed(ids)
        self.n_delay[ids] = rng.integers(1, cfg.delay_steps + 1, m)
        self.kick_every[ids] = rng.uniform(*cfg.kick_interval, m)
        self.kick_left[ids] = self.kick_every[ids]

    def _servo(self, ids: NDArray[np.int64], draw: Array) -> Array:
        """Stiffness (m, nu) [N m/rad]: relative or, as printed, absolute, at least half."""
        cfg = self.cfg
        kp = self._kp * (1.0 + cfg.gain * draw) + cfg.gain_absolute * draw
        kp = np.maximum(kp, 0.5 * self._kp)
        self.gain[ids] = kp / self._kp
        return np.asarray(kp)

    def surface(self, friction: Array, firmness: Array) -> None:
        """Put feet on patches: friction factor and time constant [s] under each foot (n, f)."""
        fields, of = self.sim.fields, self._foot_of
        fields["friction"][:, self._foot, 0] = self.friction[:, None] * friction[:, of]
        fields["solref"][:, self._foot, 0] = firmness[:, of]

    def kick(self, dt: float, share: float = 1.0) -> None:
        """Alg. 2: a horizontal velocity step of random direction every P_int.

        ``share`` of the largest kick is the curriculum's.
        """
        if self.cfg.kick_velocity <= 0:
            return
        self.kick_left -= dt
        due = np.flatnonzero(self.kick_left <= 0)
        if due.size:
            angle = self.rng.uniform(0, 2 * np.pi, due.size)
            size = 1.0 - self.cfg.kick_spread * self.rng.random(due.size)
            size *= share * self.cfg.kick_velocity
            self.sim.qvel[due, 0] += size * np.cos(angle)
            self.sim.qvel[due, 1] += size * np.sin(angle)
            self.kick_left[due] += self.kick_every[due]

    def delay(self) -> NDArray[np.int64]:
        """Alg. 1: (n,) how many steps old the observed frame is; 0 with chance 1 - p."""
        n = self.sim.n
        late = self.rng.random(n) < self.cfg.delay_chance
        steps = 1 + np.floor(self.rng.random(n) * self.n_delay).astype(np.int64)
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

    def state(self) -> dict[str, Any]:
        """What is drawn per episode; the model fields are the simulator's."""
        return {k: np.array(getattr(self, k)) for k in _DRAWN}

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state`."""
        for name in _DRAWN:
            getattr(self, name)[:] = state[name]

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
    start[:, :2], start[:, 2] = env.level_place, env.home[2] + env.level_height
    ctrl = np.tile(env.ctrl0, (env.n, 1))
    if env.cfg.stance is not None:
        _in_keyframe(env, start[::4], ctrl[::4])
    env.sim.place(ids, start, np.zeros((env.n, nv)), ctrl)
    for _ in range(18):
        noise = env.rng.normal(0, max(env.cfg.randomisation.initial_joint, 1e-9), (env.n, nu))
        env.sim.ctrl[:] = ctrl + noise
        env.sim.step(env.cfg.substeps)
    qpos = np.array(env.sim.qpos)
    qpos[:, :2] -= env.level_place
    qpos[:, 2] -= env.level_height
    return qpos, np.array(env.sim.qvel)


def _in_keyframe(env: LocomotionEnv, qpos: Array, ctrl: Array) -> None:
    """Put start states (m, nq) and targets (m, nu) into the body's keyframe, but for the joints
    that the policy does not move.
    """
    q, target = robot.keyframe_joints(env.body.keyframe)
    mixed = env.posture.copy()
    mixed[env.body.index] = q[env.body.index]
    here = robot.configuration(env.sim.model, mixed)
    qpos[:, 7:] = here[7:]
    qpos[:, 2] += 0.01
    ctrl[:, env._ctrl_at] = target[env.body.index]
