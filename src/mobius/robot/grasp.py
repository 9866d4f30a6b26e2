"""A hand that pinches a bar: a stiff, passive hold that slips and breaks at its limit surface.

Axes of the grasp, fixed to the bar when the hand closes: x along the bar and its groove, y the
pinch normal (finger b to finger a), z across the groove, away from the palm's inside towards the
forearm. A robot that hangs from a horizontal bar pulls along z: across the groove, where the
spines hook. Sideways sway pulls along x, where only friction holds.

Between the hand and a point anchored in the bar acts a spring and damper in all six directions.
Its force is capped: along x and z with the torsion about y by the drawn
:class:`~mobius.model.limit_surface.LimitSurface`; the moments about x and z by what two pads
pressed on the bar's faces can take. What the spring asks beyond a cap moves the anchor instead
(elastic predictor, plastic corrector: radial return), so that sliding only takes energy. Once
the anchor has slipped across the groove by :data:`HOOK`, or off the bar's end, the grasp breaks.

The hold acts on the hand's body as an external wrench, so the wrist's force/torque sensor feels
it. Weight, inertia, arms and contacts are MuJoCo's.
"""

from __future__ import annotations

from typing import Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.errors import UnknownName
from mobius.geometry import cross, exp_so3, log_so3
from mobius.model.gripper import finger_tips, pinch_angle, pinch_force
from mobius.model.limit_surface import LimitSurface

Array = NDArray[np.float64]
State = Literal["open", "held", "slipping", "broken"]

STIFFNESS = np.array([4e4, 3e4, 1e5, 100.0, 200.0, 100.0])
"""Along and about x, y, z [N/m, N m/rad] [A]: half the robot's weight moves it 0.5 mm along z.

Bounded by the step of 1/600 s: across the fingers the hand moves with as little as 0.48 kg. The
explicit spring and damper stay stable while (dt^2 + 2 dt t_d) lambda < 4, lambda the greatest
eigenvalue of stiffness times mobility; over all poses of the arm it is at most 1.4."""
DAMPING_TIME = 0.002
"""t_d, damping over stiffness [s] [A]."""
HOOK = 0.003
"""Slip across the groove at which the spines leave it [m] [A]."""
REACH = 0.012
"""The bar's axis may pass the middle between the tips this far off when the hand closes [m]."""
SKEW = 0.35
"""The hand may be turned this far from the bar's axis when it closes [rad]."""
PAD = (0.009, 0.012)
"""Half width along the bar and half height of a finger's pad [m]; width as drawn, height [A]."""
CLEAR = 0.006
"""Fingers whose gap is this much wider than the bar have let go of it [m]."""


class PinchGrasp:
    """One hand on one bar of a compiled scene. Call :meth:`step` before every ``mj_step``.

    Attributes:
        surface: What this grasp can hold; drawn by the caller, one draw per closing.
        state: ``open``, ``held``, ``slipping`` (the load is at the limit) or ``broken``.
        slip: Way the spines have slid on the bar since closing [m].
        force: (6,) force and moment of the bar on the hand in the grasp's axes, about the
            grasp's centre [N, N m], as of the last step.
        load: How far ``force`` goes towards the limit surface; 1 is on it.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        *,
        hand: str = "left",
        bar: str = "bar",
        surface: LimitSurface | None = None,
    ) -> None:
        """Find hand and bar; the hand is open.

        Args:
            model: A scene with the robot (or its hand) and a bar, see :mod:`mobius.world.bar`.
            data: Its state.
            hand: ``left`` or ``right``.
            bar: Name of the bar's geom, a box, longest along its axis.
            surface: The draw; Table IX's means if not given.

        Raises:
            UnknownName: There is no such hand or bar.
            InvalidInput: The hand cannot span the bar.
        """
        if hand not in ("left", "right"):
            raise UnknownName("hand", hand, ("left", "right"))
        if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, bar) < 0:
            raise UnknownName(
                "geom to grasp", bar, [model.geom(i).name for i in range(model.ngeom)]
            )
        self.model, self.data, self.hand = model, data, hand
        self._body = model.body(f"{hand}_arm_gripper_base").id
        self._site = model.site(f"{hand}_wrist_ft").id
        self.bar_geom = model.geom(bar).id
        self._bar = int(model.geom_bodyid[self.bar_geom])
        self._bar_is_fixed = int(model.body_weldid[self._bar]) == 0
        self._finger = int(model.joint(f"{hand}_gripper").qposadr[0])
        self._axis = int(np.argmax(model.geom_size[self.bar_geom]))
        self._half_length = float(model.geom_size[self.bar_geom, self._axis])
        self.width = 2.0 * float(np.min(model.geom_size[self.bar_geom]))
        self.pinch = pinch_angle(self.width)
        self._let_go = pinch_angle(self.width + CLEAR)
        self._normal = pinch_force(self.pinch)
        self._c_H: Array = finger_tips(self.pinch).mean(axis=0)
        self.surface = surface or LimitSurface()
        self.state: State = "open"
        self.slip, self.load = 0.0, 0.0
        self.force = np.zeros(6)
        self._slip_across = 0.0
        self._applied = np.zeros((2, 6))
        self._wrench_W = np.zeros(6)
        self._R_GB = np.eye(3)  # grasp axes in the bar's body frame, as columns
        self._p_B, self._R_BH = np.zeros(3), np.eye(3)  # anchor: centre, hand's attitude

    # -- hand and bar ------------------------------------------------------------------------

    def centre(self) -> Array:
        """(3,) middle between the pinching tips, world [m]; needs current kinematics."""
        return self.data.xpos[self._body] + self._R_WH @ self._c_H

    @property
    def _R_WH(self) -> Array:
        return self.data.xmat[self._body].reshape(3, 3)

    def offset(self) -> tuple[float, float]:
        """How far [m] the middle between the tips is from the bar, and how far [rad] the hand
        is turned from its axis; within :data:`REACH` and :data:`SKEW` it can close on it.
        """
        self._refresh()
        axis, d, s = self._axis_and_offset()
        past_end = max(abs(s) - self._half_length, 0.0)
        away = float(np.hypot(np.linalg.norm(d), past_end))
        cosine = min(abs(float(axis @ self._R_WH[:, 0])), 1.0)
        return away, float(np.arccos(cosine))

    def _axis_and_offset(self) -> tuple[Array, Array, float]:
        """Axis (3,) of the bar, vector from axis to grasp centre (3,) [m], place on it [m]."""
        axis = self.data.geom_xmat[self.bar_geom].reshape(3, 3)[:, self._axis]
        d = self.centre() - self.data.geom_xpos[self.bar_geom]
        s = float(d @ axis)
        return axis, d - s * axis, s

    def close(self, surface: LimitSurface | None = None) -> State:
        """Take hold where the hand is; the spring starts at rest.

        Returns ``held``, or ``open`` where the bar is out of reach (see :meth:`offset`). The
        gripper's servo must be told to close as well: its opening lets go.

        Args:
            surface: A new draw for this grasp.
        """
        away, turned = self.offset()
        if away > REACH or turned > SKEW:
            return self.release()
        if surface is not None:
            self.surface = surface
        axis, _, _ = self._axis_and_offset()
        x = axis * np.sign(axis @ self._R_WH[:, 0])
        y = self._R_WH[:, 1] - (self._R_WH[:, 1] @ x) * x
        y /= np.linalg.norm(y)
        R_WB = self.data.xmat[self._bar].reshape(3, 3)
        self._R_GB = R_WB.T @ np.column_stack([x, y, cross(x, y)])
        self._p_B = R_WB.T @ (self.centre() - self.data.xpos[self._bar])
        self._R_BH = R_WB.T @ self._R_WH
        self.slip = self._slip_across = 0.0
        self.state = "held"
        return self.state

    def release(self) -> State:
        """Let go; takes effect at the next :meth:`step`."""
        self.state = "open"
        self._clear()
        return self.state

    def reset(self) -> None:
        """Forget what was applied; after ``mj_resetData``. The hand is open."""
        self.release()
        self._applied = np.zeros((2, 6))

    @property
    def holds(self) -> bool:
        """Whether the hand hangs on to the bar, slipping or not."""
        return self.state in ("held", "slipping")

    # -- physics -----------------------------------------------------------------------------

    def step(self) -> None:
        """Bring kinematics up to date and apply this tick's force. Before each ``mj_step``."""
        if self.holds:
            self._refresh()
        self.apply()

    def _refresh(self) -> None:
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)

    def apply(self) -> None:
        """As :meth:`step`, where positions and velocities are already those of this tick
        (after ``mj_step1``).
        """
        if self.holds and self.data.qpos[self._finger] > self._let_go:
            self.release()
        if self.holds:
            self._advance()
        self._send()

    def _advance(self) -> None:
        """Spring force, its caps, slip of the anchor, break."""
        d = self.data
        R_WB = d.xmat[self._bar].reshape(3, 3)
        R_WG = R_WB @ self._R_GB
        c = self.centre()
        p_B = R_WB.T @ (c - d.xpos[self._bar])
        stretch = np.empty(6)
        stretch[:3] = (p_B - self._p_B) @ self._R_GB
        turned = R_WB.T @ self._R_WH @ self._R_BH.T
        stretch[3:] = log_so3(turned) @ self._R_GB
        w, v = self._velocity(self._body, c)
        if not self._bar_is_fixed:
            w_bar, v_bar = self._velocity(self._bar, c)
            w, v = w - w_bar, v - v_bar
        speed = np.concatenate([v @ R_WG, w @ R_WG])
        trial = -STIFFNESS * (stretch + DAMPING_TIME * speed)
        force = self._cap(trial)
        give = (force - trial) / STIFFNESS  # the anchor follows the hand by this much
        if give.any():
            self._p_B += self._R_GB @ give[:3]
            self._R_BH = exp_so3(self._R_GB @ give[3:]) @ self._R_BH
            self.slip += float(np.hypot(give[0], give[2]))
            self._slip_across += float(give[2])
        self.force = force
        self._wrench_W = np.concatenate([R_WG @ force[:3], R_WG @ force[3:]])
        _, _, s = self._axis_and_offset()
        if abs(self._slip_across) > HOOK or abs(s) > self._half_length:
            self.state = "broken"
            self._clear()

    def _cap(self, trial: Array) -> Array:
        """Radial return to the limit surface, then the moments about x and z."""
        force = trial.copy()
        load = self.surface.load(trial[2], trial[0], trial[4])
        self.load = min(load, 1.0)
        self.state = "held" if load <= 1.0 else "slipping"
        if load > 1.0:
            force[[0, 2, 4]] /= load
        r, pad = 0.5 * self.width, 2.0 * self._normal
        about_x = pad * PAD[1] + r * max(self.surface.F_across - abs(force[2]), 0.0)
        about_z = pad * PAD[0] + r * max(self.surface.F_along - abs(force[0]), 0.0)
        force[3] = min(max(force[3], -about_x), about_x)
        force[5] = min(max(force[5], -about_z), about_z)
        return force

    def _velocity(self, body: int, point: Array) -> tuple[Array, Array]:
        """Angular (3,) velocity of a body and linear (3,) of its material at a world point."""
        twist = self.data.cvel[body]
        arm = point - self.data.subtree_com[self.model.body_rootid[body]]
        return twist[:3], twist[3:] + cross(twist[:3], arm)

    def _clear(self) -> None:
        self.force, self._wrench_W, self.load = np.zeros(6), np.zeros(6), 0.0

    def _send(self) -> None:
        """Replace what this grasp added to the external forces of hand and bar."""
        c, f, m = self.centre(), self._wrench_W[:3], self._wrench_W[3:]
        for row, body, sign in ((0, self._body, 1.0), (1, self._bar, -1.0)):
            if row and self._bar_is_fixed:
                return
            at_com = np.concatenate([sign * f, sign * (m + cross(c - self.data.xipos[body], f))])
            self.data.xfrc_applied[body] += at_com - self._applied[row]
            self._applied[row] = at_com

    @property
    def wrench_S(self) -> Array:
        """(6,) force [N] and moment [N m] of the bar on the hand, at the wrist's F/T site and
        in its axes, as of the last step. MuJoCo's wrist sensor, which reads what the forearm
        does to the hand, shows minus this, the hand's weight and inertia, and along y what the
        two fingers' contacts with the bar differ by.
        """
        f, m = self._wrench_W[:3], self._wrench_W[3:]
        R = self.data.site_xmat[self._site].reshape(3, 3)
        moment = m + cross(self.centre() - self.data.site_xpos[self._site], f)
        return np.concatenate([R.T @ f, R.T @ moment])
