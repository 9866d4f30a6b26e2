"""The locomotion environment: n robots, one body, everything vectorised over robots."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.control.action import POLICY_DT, ActionFilter
from mobius.control.bodies import body_of
from mobius.control.clock import GaitClock
from mobius.control.observation import (
    History,
    Layout,
    build_frame,
    heading_twist,
    join_mirrors,
    mirror_frame,
    mirror_names,
)
from mobius.geometry import heading_yaw, quat_conj, quat_mul, rotate, rpy_to_quat
from mobius.model import robot
from mobius.model.joints import JOINTS
from mobius.model.poses import stance_keyframe
from mobius.model.servo import servo_of
from mobius.train import rewards
from mobius.train.batch import CpuBatch, build_training_model
from mobius.train.config import gait_of
from mobius.train.curriculum import Curriculum
from mobius.train.presets import EnvConfig
from mobius.train.randomise import Randomiser, settle_pool
from mobius.train.terrain import COLUMNS, Tiles

Array = NDArray[np.float64]


_ROBOTS = (
    "steps",
    "command",
    "command_left",
    "target",
    "late",
    "velocity",
    "yaw0",
    "seen_speed",
    "height",
    "foot_height",
    "air",
    "foot_vz",
    "foot_vxy",
    "down",
    "action_1",
    "action_2",
    "frames",
    "observation",
    "privileged",
)


@dataclass
class StepResult:
    """What one policy step gives the learner."""

    observation: Array
    """(n, layout.size)."""
    privileged: Array
    """(n, p) what only the critic may see."""
    reward: Array
    """(n,)."""
    done: NDArray[np.bool_]
    """(n,) episode over, the observation is already that of the next episode."""
    time_out: NDArray[np.bool_]
    """(n,) over by time, not by a fall: to be bootstrapped."""
    log: dict[str, float]


def posture_of(cfg: EnvConfig) -> tuple[Array, Array, Array]:
    """Joint angles (22,), servo targets (22,) [rad] and trunk pose (7,) of the stance."""
    name = body_of(cfg.body).keyframe
    if cfg.stance is None:
        return *robot.keyframe_joints(name), robot.keyframe(name)[0][:7]
    qpos, ctrl = stance_keyframe(cfg.stance)
    return cfg.stance.joints(), ctrl, qpos[:7]


class LocomotionEnv:
    """Walks or crawls on a floor after commanded body twists (Sec. IV-A)."""

    def __init__(self, cfg: EnvConfig, n: int, *, seed: int = 0, nthread: int = 0) -> None:
        self.cfg, self.n = cfg, n
        self.body = body_of(cfg.body)
        self.layout = Layout(cfg.frame, len(self.body.joints), cfg.history, cfg.clock)
        self.rng = np.random.default_rng(seed)
        self.tiles = None if cfg.terrain is None else Tiles(cfg.terrain)
        self.curriculum = Curriculum(
            cfg.curriculum,
            n,
            levels=cfg.terrain.levels if cfg.terrain else 0,
            columns=len(COLUMNS) if cfg.terrain else 0,
        )
        q0, ctrl0, base = posture_of(cfg)
        self.posture = q0
        self.sim = CpuBatch(self._model(q0), self.body, n, nthread)
        self.home = robot.configuration(self.sim.model, q0, p=base[:3], quat=base[3:])
        self.height0 = float(base[2])
        self._feet_H = self._home_feet()
        at, index = self.sim.at, self.body.index
        self.ctrl0 = ctrl0[at.present]
        here = np.searchsorted(at.present, np.sort(index))[np.argsort(np.argsort(index))]
        self._ctrl_at, self._q_at = at.actuator[here], at.qpos[here]
        self.default = ctrl0[index]
        low, high = robot.joint_limits()
        self.filter = ActionFilter(self.default, low[index], high[index], n)
        self.history = History(self.layout, n)
        self.clock = GaitClock(gait_of(cfg), n)
        self.randomiser = Randomiser(self.sim, cfg.randomisation, self.rng)
        self.weights = {**rewards.WEIGHTS, **cfg.weights}
        self.max_steps = round(cfg.episode_s / POLICY_DT)
        self.limit = np.array(
            [servo_of(self.sim.model.actuator(i).name).stall_torque for i in self.sim.at.actuator]
        )
        self._allocate()
        self.level_place = np.full(2, 0.5 * cfg.terrain.tile if cfg.terrain else 0.0)
        self.level_height = 0.0
        self.pool = settle_pool(self)
        self.reset_all()

    def _model(self, posture: Array) -> mujoco.MjModel:
        cfg = self.cfg
        return build_training_model(
            self.body,
            cfg.timestep,
            cfg.iterations,
            ls_iterations=cfg.ls_iterations,
            weld=cfg.weld,
            posture=posture,
            ground=None if self.tiles is None else self.tiles.ground,
        )

    def _home_feet(self) -> Array:
        """(f, 2) where the feet stand in the stance, from the trunk, heading 0 [m]."""
        data = mujoco.MjData(self.sim.model)
        data.qpos[:] = self.home
        mujoco.mj_kinematics(self.sim.model, data)
        yaw = -float(heading_yaw(self.body.heading, self.home[3:7]))
        turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        feet = [data.site(f"{limb}_tip").xpos[:2] - self.home[:2] for limb in self.body.feet]
        return np.asarray(np.array(feet) @ turn.T)

    def _allocate(self) -> None:
        n, f, k = self.n, len(self.body.feet), self.layout.actions
        self.steps = np.zeros(n, dtype=np.int64)
        self.command = np.zeros((n, 3))
        self.command_left = np.zeros(n)
        self.target = np.tile(self.default, (n, 1))
        self.late = np.zeros(n, dtype=bool)
        self.velocity = np.zeros((n, 3))
        self.yaw0 = np.zeros(n)
        self.seen_speed = np.zeros(n)
        self.height = np.full(n, self.height0)
        self.foot_height = np.zeros((n, f))
        self.air = np.zeros((n, f))
        self.foot_vz = np.zeros((n, f))
        self.foot_vxy = np.zeros((n, f))
        self.down = np.zeros((n, f))
        self.touch = np.zeros((1, n, f))
        self.action_1, self.action_2 = np.zeros((n, k)), np.zeros((n, k))
        self.frames = np.zeros((n, 1 + self.cfg.randomisation.delay_steps, self.layout.frame_size))

    def reseed(self, seed: int) -> None:
        """Draw from a new stream, from new episodes on."""
        self.rng = self.randomiser.rng = np.random.default_rng(seed)
        self.reset_all()

    # -- episodes ------------------------------------------------------------------------

    def reset_all(self) -> None:
        """Start all episodes; afterwards :meth:`observe` is valid."""
        self._reset(np.arange(self.n))
        self.observation, self.privileged = self.observe()

    def reset_observation(self) -> None:
        """Forget past frames and observe the present state; after states were set by hand."""
        self.frames[:] = np.nan
        self.history.reset()
        self.observation, self.privileged = self.observe()

    def _reset(self, ids: NDArray[np.int64]) -> None:
        pick = self.rng.integers(len(self.pool[0]), size=len(ids))
        qpos, qvel = self.pool[0][pick].copy(), self.pool[1][pick].copy()
        turn = rpy_to_quat(0.0, 0.0, self.rng.uniform(-np.pi, np.pi, len(ids)))
        qpos[:, 3:7] = quat_mul(turn, qpos[:, 3:7])
        qvel[:, :3] = rotate(turn, qvel[:, :3])
        if self.tiles is not None:
            self._spread_out(ids, qpos)
        self.randomiser.new_episode(ids)
        self.sim.place(ids, qpos, qvel, np.tile(self.ctrl0, (len(ids), 1)))
        which = np.zeros(self.n, dtype=bool)
        which[ids] = True
        self.filter.reset(which)
        self.history.reset(which)
        self.clock.reset(which, self.rng.random(len(ids)))
        self.target[ids] = self.default
        self.late[ids] = self.rng.random(len(ids)) < self.cfg.randomisation.action_delay
        self.steps[ids] = 0
        for state in (
            self.velocity,
            self.air,
            self.foot_vz,
            self.foot_vxy,
            self.down,
            self.action_1,
            self.action_2,
        ):
            state[ids] = 0.0
        self.height[ids], self.foot_height[ids] = self.height0, 0.0
        self.frames[ids] = np.nan
        self.yaw0[ids] = heading_yaw(self.body.heading, qpos[:, 3:7])
        self._new_command(ids)

    def _spread_out(self, ids: NDArray[np.int64], qpos: Array) -> None:
        """Move start states (m, nq) onto tiles of the robots' levels, the highest foot down."""
        assert self.tiles is not None
        here = self.tiles.start(self.rng, self.curriculum.level[ids], self.curriculum.column[ids])
        yaw = heading_yaw(self.body.heading, qpos[:, 3:7])
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        x, y = self._feet_H[:, 0], self._feet_H[:, 1]
        feet = np.stack([c * x - s * y, s * x + c * y], axis=-1) + here[:, None]
        qpos[:, :2] += here
        qpos[:, 2] += self.tiles.ground.at(feet).max(axis=1)

    def _new_command(self, ids: NDArray[np.int64]) -> None:
        """Uniform over the body's range; some stand still, three tenths move along one axis, half
        of these as fast as the body can.
        """
        m = len(ids)
        reach = self.cfg.command_margin * self.curriculum.command
        low = np.array(self.body.command_low) * reach
        high = np.array(self.body.command_high) * reach
        command = self.rng.uniform(low, high, (m, 3))
        kind = self.rng.random((m, 1))
        end = np.where(self.rng.random((m, 1)) < 0.5, low, high)
        axis = np.eye(3)[self.rng.integers(3, size=m)]
        still = self.cfg.stand_share
        command = np.where(kind < still + 0.3, command * axis, command)
        command = np.where(kind < still + 0.15, end * axis, command)
        command = np.where(kind < still, 0.0, command)
        self.command[ids] = command
        self.command_left[ids] = self.rng.uniform(*self.cfg.command_s, m)

    # -- stepping ------------------------------------------------------------------------

    def step(self, action: Array) -> StepResult:
        """Advance every robot by one policy step with raw actions (n, k)."""
        previous = self.target
        self.target = self.filter.push(action)
        sent = np.where(self.late[:, None], previous, self.target)
        self.sim.ctrl[:, self._ctrl_at] = sent
        self.randomiser.kick(POLICY_DT, self.curriculum.kick)
        if self.tiles is not None:
            self.randomiser.surface(*self.tiles.surface(self.sim.foot_position[:, :, :2]))
        if self.cfg.watch_contacts:
            self.touch = self.sim.step_watched(self.cfg.substeps)
        else:
            self.sim.step(self.cfg.substeps)
            self.touch = self.sim.contact[None]
        self.steps += 1
        self.clock.advance(self.command, POLICY_DT, self.seen_speed)
        signals = self._signals()
        reward, log = rewards.total(signals, self.weights)
        if self.cfg.clip_reward:
            reward = np.maximum(reward, 0.0)
        self.action_2, self.action_1 = self.action_1, self.filter.last.copy()
        fallen = signals.fallen > 0
        time_out = (self.steps >= self.max_steps) & ~fallen
        done = fallen | time_out
        log = {f"/reward/{k}": v for k, v in log.items()}
        error = np.linalg.norm(signals.command[:, :2] - signals.velocity[:, :2], axis=1).mean()
        asked = np.linalg.norm(signals.command[:, :2], axis=1).mean()
        log["/error/linear"] = float(error)
        log["/error/yaw"] = float(np.abs(signals.command[:, 2] - signals.velocity[:, 2]).mean())
        log["/power_W"] = float(rewards.power(signals).mean())
        log["/falls_per_minute"] = float(fallen.mean() * 3600)
        self.curriculum.watch(float(error / max(asked, 1e-3)), log["/falls_per_minute"])
        log["/curriculum/command"] = self.curriculum.command
        log["/curriculum/kick"] = self.curriculum.kick
        if self.tiles is not None:
            log["/curriculum/level"] = float(self.curriculum.level.mean())
        self.command_left -= POLICY_DT
        if (stale := np.flatnonzero(self.command_left <= 0)).size:
            self._new_command(stale)
        if done.any():
            ids = np.flatnonzero(done)
            self.curriculum.ended(ids, fallen[ids], self.rng)
            self._reset(ids)
        self.observation, self.privileged = self.observe()
        return StepResult(
            self.observation, self.privileged, reward * POLICY_DT, done, time_out, log
        )

    def _truth(self) -> tuple[Array, Array, Array]:
        """q_OB (n, 4), v_B (n, 3), w_B (n, 3)."""
        q = self.sim.qpos[:, 3:7]
        return q, rotate(quat_conj(q), self.sim.qvel[:, :3]), self.sim.qvel[:, 3:6]

    def _signals(self) -> rewards.Signals:
        q, v_B, w_B = self._truth()
        v_H, w_H = heading_twist(self.body, q, v_B, w_B)
        twist = np.column_stack([v_H[:, :2], w_H[:, 2]])
        blend = POLICY_DT / (self.cfg.velocity_filter_s + POLICY_DT)
        self.velocity += blend * (twist - self.velocity)
        gravity = rotate(quat_conj(q), np.broadcast_to([0.0, 0.0, -1.0], (self.n, 3)))
        contact, touchdown, early, air = self._contacts()
        foot_velocity = self.sim.foot_velocity
        foot_speed = np.linalg.norm(foot_velocity[:, :, :2], axis=2)
        landing, self.foot_vz = self.foot_vz, foot_velocity[:, :, 2]
        drag, self.foot_vxy = self.foot_vxy, foot_speed
        upright = -gravity[:, 2] if self.body.heading == "crawl" else -gravity[:, 0]
        tilt = gravity[:, :2] if self.body.heading == "crawl" else gravity[:, 1:]
        foot = self.sim.foot_position
        below = np.zeros(foot.shape[:2])
        if self.tiles is not None:
            below = self.tiles.ground.at(foot[:, :, :2])
        height = self.sim.qpos[:, 2] - below.mean(axis=1)
        self.height = height
        self.foot_height = foot[:, :, 2] - below
        fallen = self._fallen(height, upright)
        return rewards.Signals(
            command=self.command.copy(),
            moving=self.clock.moving.astype(float),
            swing=self.clock.swing_wanted(),
            contact_wanted=self.clock.contact_wanted(),
            velocity=self.velocity,
            v_z=v_H[:, 2],
            w_xy=w_H[:, :2],
            gravity_xy=tilt,
            height_error=height - self.height0,
            q_error=self.sim.qpos[:, self._q_at] - self.default,
            torque=self.sim.torque,
            speed=self.sim.qvel[:, self.sim.at.dof],
            torque_limit=self.limit,
            action=self.filter.last,
            action_1=self.action_1,
            action_2=self.action_2,
            contact=contact,
            touching=self.touch.mean(axis=0),
            touchdown=touchdown,
            air_time=air,
            contact_time=self.down,
            foot_height=self.foot_height,
            foot_speed=foot_speed,
            landing_speed=landing,
            landing_drag=drag,
            lifted_early=early,
            foot_tilt=self.sim.foot_tilt,
            fallen=fallen.astype(float),
            early=(self.steps < 500).astype(float),
            swing_top=self.clock.gait.height,
            sigma_linear=self.cfg.sigma_linear,
            sigma_yaw=self.cfg.sigma_yaw,
        )

    def _contacts(self) -> tuple[Array, Array, Array, Array]:
        """What the soles did since the last policy step: (n, f) contact now, 1 where a contact
        began, number of contacts of less than 0.08 s that ended, time in the air until now or
        until the first touchdown [s].
        """
        dt = POLICY_DT / len(self.touch)
        began, early = np.zeros_like(self.air), np.zeros_like(self.air)
        aloft = self.air + dt
        for on in self.touch:
            aloft = np.where(began == 0, self.air + dt, aloft)
            began = np.maximum(began, on * (self.air > 0))
            early += (1.0 - on) * (self.down > 0) * (self.down < 0.08)
            self.air = np.where(on > 0, 0.0, self.air + dt)
            self.down = np.where(on > 0, self.down + dt, 0.0)
        return self.touch[-1], began, early, aloft

    def _fallen(self, height: Array, upright: Array) -> NDArray[np.bool_]:
        """Eq. (3) to (5): too low or tilted, a motor too fast, a target at a joint limit."""
        cfg = self.cfg
        fallen = (height < cfg.min_height) | (upright < cfg.min_upright)
        if cfg.max_joint_speed > 0:
            fast = np.abs(self.sim.qvel[:, self.sim.at.dof]).max(axis=1) > cfg.max_joint_speed
            fallen |= fast & (self.steps > 5)
        if cfg.limit_margin > 0:
            near = self.filter.free - cfg.limit_margin < self.filter.low
            near |= self.filter.free + cfg.limit_margin > self.filter.high
            fallen |= near.any(axis=1)
        return np.asarray(fallen)

    # -- stopping and going on -------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """All that changes, as arrays and plain values; :meth:`load_state` goes on from it."""
        return {
            "sim": self.sim.state(),
            "robots": {k: np.array(getattr(self, k)) for k in _ROBOTS},
            "filter": self.filter.past.copy(),
            "history": self.history.state(),
            "clock": {k: np.array(getattr(self.clock, k)) for k in ("phase", "moving", "calm")},
            "randomiser": self.randomiser.state(),
            "curriculum": self.curriculum.state(),
            "pool": {"qpos": self.pool[0].copy(), "qvel": self.pool[1].copy()},
            "rng": self.rng.bit_generator.state,
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from :meth:`state` of an environment with the same configuration."""
        self.sim.load_state(state["sim"])
        for name in _ROBOTS:
            getattr(self, name)[:] = state["robots"][name]
        self.filter.past[:] = state["filter"]
        self.history.load_state(state["history"])
        for name, value in state["clock"].items():
            getattr(self.clock, name)[:] = value
        self.randomiser.load_state(state["randomiser"])
        self.curriculum.load_state(state["curriculum"])
        self.pool = (np.array(state["pool"]["qpos"]), np.array(state["pool"]["qvel"]))
        self.rng.bit_generator.state = state["rng"]

    # -- observing -----------------------------------------------------------------------

    def observe(self) -> tuple[Array, Array]:
        """Noisy, possibly delayed observations (n, size) and the critic's privileged view."""
        self.clock.refresh(self.command)  # new commands have come since it ran
        q, v_B, w_B = self._truth()
        joints = self.sim.qpos[:, self._q_at]
        nq, nv, nw, nj = self.randomiser.noisy(q, v_B, w_B, joints)
        self.seen_speed = np.linalg.norm(rotate(nq, nv)[:, :2], axis=1)
        self.seen = dict(q_OB=nq, v_B=nv, w_B=nw, joints=nj)
        true = dict(q_OB=q, v_B=v_B, w_B=w_B, joints=joints)
        own = dict(
            yaw0=self.yaw0,
            action=self.filter.last,
            command=self.command,
            clock=self.clock.observe(),
        )
        both = {k: np.concatenate([v, true[k]]) for k, v in self.seen.items()}
        both |= {k: np.concatenate([v, v]) for k, v in own.items()}
        frames = build_frame(self.layout, self.body, default=self.default, **both)
        noisy, true_frame = frames[: self.n], frames[self.n :]  # one call costs little more
        fresh = np.isnan(self.frames[:, 0, 0])
        self.frames[:, 1:] = self.frames[:, :-1].copy()
        self.frames[:, 0] = noisy
        self.frames[fresh] = noisy[fresh, None, :]
        seen = self.frames[np.arange(self.n), self.randomiser.delay()]
        tail = 5 if self.layout.clock else 3  # command and clock are the robot's own: never late
        seen = np.concatenate([seen[:, :-tail], noisy[:, -tail:]], axis=1)
        privileged = np.concatenate(
            [
                true_frame,
                self.velocity,
                self.height[:, None] - self.height0,
                self.sim.qvel[:, self.sim.at.dof] * 0.2,
                self.sim.contact,
                self.foot_height * 10.0,
                self.air,
                self.randomiser.describe(),
                self.late[:, None].astype(float),
            ],
            axis=1,
        )
        return self.history.push(seen), privileged

    def mirror_privileged(self) -> tuple[NDArray[np.int64], Array]:
        """Permutation and signs of the left-right mirror on the privileged view."""
        joints = mirror_names([JOINTS[i] for i in self.sim.at.present])
        feet = mirror_names(self.body.feet)
        return join_mirrors(
            mirror_frame(replace(self.layout, history=1), self.body),
            _signs(1, -1, -1),  # velocity
            _signs(1),  # height
            joints,
            *[feet] * 3,  # contact, height, air time
            _signs(1, 1, -1, 1, 1),  # mass, centre of mass, friction
            _signs(1),  # late
        )


def _signs(*signs: int) -> tuple[NDArray[np.int64], Array]:
    return np.arange(len(signs)), np.array(signs, dtype=float)
