"""The robot in MuJoCo physics, behind the same protocol as a real one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.geometry import heading_yaw, quat_conj, quat_mul, rotate, rpy_to_quat
from mobius.model import robot as model_robot
from mobius.robot.ends import LimbEnds
from mobius.robot.grasp import PinchGrasp
from mobius.robot.interface import TICK, Simulated
from mobius.robot.limits import limit_targets
from mobius.robot.variation import Variation
from mobius.types import LIMBS, JointCommand, Pose, SensorFrame, StateEstimate

Array = NDArray[np.float64]

SOLE_REACH = 0.07
"""Ground within this distance of a sole's middle counts as under it at the start [m]."""


def at_or_slice(index: NDArray[np.int64]) -> NDArray[np.int64] | slice:
    """The same places as a slice where they follow one another: several times faster."""
    first = int(index[0])
    return slice(first, first + len(index)) if (np.diff(index) == 1).all() else index


class SimRobot(Simulated):
    """One simulated robot in a scene.

    The model must hold the robot (with wrench and IMU sensors) and a floor; geoms named
    ``wall_*`` and ``shelf_*`` count as obstacles in :meth:`obstacle_force`.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        *,
        variation: Variation | None = None,
        keyframe: str = "crawl",
        xy: ArrayLike = (0.0, 0.0),
        yaw: float = 0.0,
        ground: Callable[[Array], Array] | None = None,
        qpos: ArrayLike | None = None,
    ) -> None:
        """Start ``keyframe`` at ``xy`` [m] with heading ``yaw`` [rad] in the world.

        Args:
            model: The scene; the variation changes it in place.
            variation: How robot and floor differ from the drawing.
            keyframe: Posture to start in.
            xy: Trunk [m].
            yaw: Heading [rad].
            ground: Height [m] of the floor at points (..., 2) [m]; flat at 0 if not given. The
                robot starts on the highest place under its soles.
            qpos: A whole configuration (nq,) instead of keyframe, place and heading; the servos'
                targets are then its joint angles.
        """
        if abs(model.opt.timestep - TICK) > 1e-9:
            raise InvalidInput(
                f"SimRobot expects a physics step of 1/600 s, got {model.opt.timestep:.6f} s;"
                " set model.opt.timestep = 1 / 600"
            )
        self.model, self.data = model, mujoco.MjData(model)
        self.variation = variation or Variation()
        self.variation.apply(model)
        self.at = model_robot.addresses(model)
        self.tick = 0
        name = mujoco.mj_id2name
        names = [name(model, mujoco.mjtObj.mjOBJ_GEOM, i) or "" for i in range(model.ngeom)]
        self._soles = np.array([i for i, n in enumerate(names) if "_sole" in n], dtype=np.int64)
        if qpos is None:
            self._start(keyframe, np.asarray(xy, dtype=float), yaw, ground)
        else:
            self._start_at(np.asarray(qpos, dtype=float))
        self._obstacle = np.array([n.startswith(("wall_", "shelf_")) for n in names])
        self._has_obstacles, self._hit = bool(self._obstacle.any()), 0.0
        self._ground = np.array([n == "floor" or n.startswith("rough_") for n in names])
        self._trunk = model.body("base_link").id
        self._ends = LimbEnds(model, np.flatnonzero(self._ground))
        self._shove, self._shove_ticks, self._shove_as_force = np.zeros(2), 0, False
        self._shoved: Array | float = 0.0
        self.grasps: list[PinchGrasp] = []
        """Hands on bars; each acts at every step, see :mod:`mobius.robot.grasp`."""
        contact = [int(model.sensor(f"{limb}_contact").adr[0]) for limb in LIMBS]
        self._contact_at = np.array([[a + 1, a + 2, a + 3] for a in contact])
        gyro, accel = (int(model.sensor(k).adr[0]) for k in ("imu_gyro", "imu_accel"))
        self._imu_at = at_or_slice(np.r_[gyro : gyro + 3, accel : accel + 3])
        self._imu = np.array(self.data.sensordata[self._imu_at])
        self._imu_sum, self._imu_ticks = np.zeros(6), 0
        wrench = [
            int(model.sensor(f"{side}_wrist_{kind}").adr[0]) + i
            for side in ("left", "right")
            for kind in ("force", "torque")
            for i in range(3)
        ]
        self._wrench_at = np.array(wrench)
        self._motors = at_or_slice(self.at.actuator)

    def _start(
        self,
        keyframe: str,
        xy: Array,
        yaw: float,
        ground: Callable[[Array], Array] | None,
    ) -> None:
        q, ctrl = model_robot.keyframe_joints(keyframe)
        base = model_robot.keyframe(keyframe)[0][:7]
        lying = keyframe in ("crawl", "home", "prone", "supine")
        heading = float(heading_yaw("crawl" if lying else "biped", base[3:]))
        turn = rpy_to_quat(0.0, 0.0, yaw - heading)
        self.data.qpos[:] = model_robot.configuration(
            self.model, q, p=(*xy, base[2] + 0.001), quat=quat_mul(turn, base[3:])
        )
        self.data.ctrl[self.at.actuator] = ctrl
        self._queue: deque[Array] = deque([ctrl.copy()] * self.variation.delay_ticks)
        self._target, self._fresh = ctrl.copy(), False
        if ground is not None:
            mujoco.mj_kinematics(self.model, self.data)
            angle = np.linspace(0, 2 * np.pi, 8, endpoint=False)
            around = SOLE_REACH * np.column_stack([np.cos(angle), np.sin(angle)])
            under = self.data.geom_xpos[self._soles, None, :2] + np.vstack([around, [0.0, 0.0]])
            self.data.qpos[2] += float(ground(under).max())
        mujoco.mj_forward(self.model, self.data)
        self._vio: Pose | None = self._pose()

    def _start_at(self, qpos: Array) -> None:
        if qpos.shape != (self.model.nq,):
            raise InvalidInput(
                f"SimRobot.qpos: expected {self.model.nq} numbers as mobius.model.robot"
                f".configuration gives them, got shape {qpos.shape}"
            )
        self.data.qpos[:] = qpos
        ctrl = np.array(qpos[self.at.qpos])
        self.data.ctrl[self.at.actuator] = ctrl
        self._queue = deque([ctrl.copy()] * self.variation.delay_ticks)
        self._target, self._fresh = ctrl.copy(), False
        mujoco.mj_forward(self.model, self.data)
        self._vio = self._pose()

    # -- protocol ------------------------------------------------------------------------

    def read(self) -> SensorFrame:
        """Perfect readings of this tick; :mod:`mobius.sense` makes them real.

        The IMU averages over the ticks since the last read, as a real one does, so that foot
        strikes do not alias.
        """
        d, at = self.data, self.at
        vio, self._vio = self._vio, None
        if self._imu_ticks:
            self._imu = self._imu_sum / self._imu_ticks
            self._imu_sum, self._imu_ticks = np.zeros(6), 0
        return SensorFrame(
            stamp=self.tick * TICK,
            q=d.qpos[at.qpos],
            dq=d.qvel[at.dof],
            torque=self.torque(),
            wrench_S=d.sensordata[self._wrench_at].reshape(2, 6),
            gyro_I=self._imu[:3],
            accel_I=self._imu[3:],
            vio=vio,
        )

    def write(self, command: JointCommand) -> JointCommand:
        """Send servo targets; returns them as the joint limits let them through."""
        sent = limit_targets(command)
        self._target, self._fresh = np.array(sent.q), True
        return sent

    def wait(self) -> None:
        """One physics step of 1/600 s."""
        if self.variation.delay_ticks:
            self._queue.append(self._target)
            self.data.ctrl[self._motors] = self._queue.popleft()
        elif self._fresh:
            self.data.ctrl[self._motors] = self._target
            self._fresh = False
        if self._shove_ticks:
            self._push_on()
        if self.grasps:
            mujoco.mj_step1(self.model, self.data)
            for grasp in self.grasps:
                grasp.apply()
            mujoco.mj_step2(self.model, self.data)
        else:
            mujoco.mj_step(self.model, self.data)
        self._imu_sum += self.data.sensordata[self._imu_at]
        self._imu_ticks += 1
        self.tick += 1
        if self.tick % 3 == 0:
            self._vio = self._pose()
            if self._has_obstacles and self.data.ncon:
                self._feel_obstacles()

    # -- disturbance -----------------------------------------------------------------------

    def push(self, dv_xy: ArrayLike, duration: float = 0.1, *, as_force: bool = False) -> None:
        """Shove the whole robot from the next step on, over ``duration`` [s].

        A free robot would be faster by ``dv_xy`` (2,) [m/s] afterwards. The trunk's velocity,
        which carries all bodies along, is raised by an equal share at every step: a uniform
        acceleration of the whole robot, as by a force m dv / duration through its centre of
        mass, except that its accelerometer does not feel it. With ``as_force`` it does: every
        body gets the force of its own mass.
        """
        ticks = round(duration / TICK)
        if ticks < 1:
            raise InvalidInput(f"push: expected a duration >= 1/600 s, got {duration}")
        self._shove, self._shove_ticks = np.asarray(dv_xy, dtype=float) / ticks, ticks + 1
        self._shove_as_force = as_force

    def pull(self, xfrc: ArrayLike) -> None:
        """Pull at bodies from now on, until told otherwise; a push that goes on is kept apart.

        Args:
            xfrc: (nbody, 6) force [N] and torque [N m] at the centre of each body, world frame.
        """
        self.data.xfrc_applied[:] = xfrc
        self.data.xfrc_applied[:, :2] += self._shoved

    def _push_on(self) -> None:
        self._shove_ticks -= 1
        share = self._shove * (self._shove_ticks > 0)  # the last call lets go
        if self._shove_as_force:
            force = self.model.body_mass[:, None] * share / TICK
            self.data.xfrc_applied[:, :2] += force - self._shoved
            self._shoved = force
        else:
            self.data.qvel[self.at.base_dof : self.at.base_dof + 2] += share

    # -- truth, for judges and reports ----------------------------------------------------

    def _pose(self) -> Pose:
        q = self.data.qpos[3:7]
        return Pose(p=self.data.qpos[:3], q=q / np.linalg.norm(q))

    def torque(self) -> Array:
        """(22,) servo torque at the output, drive minus back-EMF [N m]."""
        d, at = self.data, self.at
        drive: Array = d.actuator_force[at.actuator]
        return drive - self.model.dof_damping[at.dof] * d.qvel[at.dof]

    def truth(self) -> StateEstimate:
        """True trunk state; the contact is 1 where a sole presses with more than 1 N."""
        pose = self._pose()
        return StateEstimate(
            stamp=self.tick * TICK,
            p_OB=pose.p,
            q_OB=pose.q,
            v_B=rotate(quat_conj(pose.q), self.data.qvel[:3]),
            w_B=self.data.qvel[3:6],
            contact=(self.contact_force() > 1.0).astype(float),
        )

    def contact_force(self) -> Array:
        """(4,) size of the contact force at each limb's end [N], order LIMBS."""
        force = self.data.sensordata[self._contact_at]
        return np.sqrt(np.einsum("ij,ij->i", force, force))

    def sole_contact(self) -> tuple[Array, Array]:
        """Contact of the limbs' ends with the ground at the last step, order LIMBS.

        Returns:
            Normal force (4,) [N], summed over a limb's contact points, and sliding speed (4,)
            [m/s]: how fast the bodies move along the ground at those points, weighted by force.
            A sphere that rolls does not slide. Both are 0 in the air.
        """
        return self._ends.contact(self.data)

    def servo_line(self) -> tuple[Array, Array]:
        """Stall torque (22,) [N m] of this robot's servos and the slope (22,) [N m s/rad] by
        which their torque falls with speed.
        """
        stall: Array = self.model.actuator_forcerange[self.at.actuator, 1]
        slope: Array = self.model.dof_damping[self.at.dof]
        return stall.copy(), slope.copy()

    def obstacle_force(self) -> float:
        """Largest normal force [N] against a wall or shelf since last asked, felt at 200 Hz."""
        largest, self._hit = self._hit, 0.0
        return largest

    def _feel_obstacles(self) -> None:
        d = self.data
        hits = np.flatnonzero(self._obstacle[d.contact.geom].any(axis=1))
        if hits.size:
            force = np.zeros(6)
            for i in hits:
                mujoco.mj_contactForce(self.model, d, int(i), force)
                self._hit = max(self._hit, float(force[0]))

    def trunk_grounded(self) -> bool:
        """Whether the trunk, its rails or cameras touch the ground at this tick."""
        geom = self.data.contact.geom
        trunk = (self.model.geom_bodyid[geom] == self._trunk).any(axis=1)
        return bool((trunk & self._ground[geom].any(axis=1)).any())

    def loop_residual(self) -> float:
        """Largest gap [m] of the four five-bar loops."""
        gaps = [
            np.linalg.norm(
                self.data.site(f"{limb}_loop_coupler").xpos
                - self.data.site(f"{limb}_loop_distal").xpos
            )
            for limb in LIMBS
        ]
        return float(max(gaps))
