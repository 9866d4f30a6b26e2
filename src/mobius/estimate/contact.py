"""Which limbs stand: from servo torques and wrist wrenches to a probability per limb.

The cranks of a limb feel the ground as ``J^T f = M dw + g(q) - tau``: what their torque does
not spend on the inertia of rotors and links and on their weight. A first-order momentum
observer gives it without differentiating rates,

    J^T f = K (p - lowpass(p)) - lowpass(tau - g),    p = M dq,

and two cranks give the force in the limb's plane, whose vertical part presses on the
ground. Links count as point masses at crank pins, wrist or ankle and hand or foot.
An arm's wrist sensor feels the same force beyond all that, less the gripper's weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp

from mobius.estimate.config import ContactConfig
from mobius.estimate.limbs import LimbState, Vector, dot
from mobius.model import LimbGeometry, limb_geometry
from mobius.model import dimensions as dim
from mobius.model.servo import servo_of
from mobius.types import LIMBS

G = 9.81
"""[m/s^2]."""


@dataclass(frozen=True)
class _Load:
    """Point masses [kg] of one limb, and its cranks' rotor inertia [kg m^2]."""

    pin_a: float
    pin_b: float
    wrist: float
    hand: float
    hand_at: float
    """Where the hand's mass is between wrist (0) and contact (1)."""
    rotor: float


def _load_of(g: LimbGeometry) -> _Load:
    if g.is_arm:
        m = dim.MASS_ARM
        hand = sum(m[k] for k in ("wrist_yaw", "ft_sensor", "palm")) + 2 * m["finger"]
        wrist, at = m["wrist_pitch"] + m["wrist_roll"], 0.35
    else:
        m = dim.MASS_LEG
        hand, wrist, at = m["foot"], m["ankle_servo"], 0.9
    side, root = g.name.split("_")[0], "shoulder" if g.is_arm else "hip"
    return _Load(
        pin_a=0.5 * (m["crank_a"] + m["coupler"]),
        pin_b=0.5 * (m["crank_b"] + m["distal"]),
        wrist=0.5 * m["distal"] + wrist,
        hand=hand,
        hand_at=at,
        rotor=servo_of(f"{side}_{root}_motor_a").armature,
    )


GRIPPER_MASS = _load_of(limb_geometry("left_arm")).hand
"""What hangs on a wrist sensor [kg]."""


class TorqueForce:
    """The vertical ground force on one limb from its two cranks."""

    def __init__(self, name: str, bandwidth: float) -> None:
        self._load = _load_of(limb_geometry(name))
        self._bandwidth = bandwidth
        self._slow: tuple[float, float, float, float] | None = None
        """Low-passed momenta and torques of both cranks."""
        self._last = (0.0, 0.0)

    def update(
        self, limb: LimbState, up: Vector, rate: Sequence[float], tau: Sequence[float], dt: float
    ) -> float:
        """Force [N] up on the limb.

        Args:
            limb: Its kinematics.
            up: The believed vertical in ``base_link``.
            rate: Rates of motor a and b [rad/s].
            tau: Their torques [N m].
            dt: Time since the last call [s].
        """
        lift = complex(-up[1], (limb.out.conjugate() * up[0]).real)  # up, in down + i out
        (g_a, g_b), (m_aa, m_ab, m_bb) = self._weight_and_inertia(limb, lift)
        p_a = m_aa * rate[0] + m_ab * rate[1]
        p_b = m_ab * rate[0] + m_bb * rate[1]
        tau_a, tau_b = tau[0] - g_a, tau[1] - g_b
        if self._slow is None:
            self._slow, self._last = (p_a, p_b, tau_a, tau_b), (tau_a, tau_b)
        (s_pa, s_pb, s_ta, s_tb), (l_a, l_b) = self._slow, self._last
        self._last = (tau_a, tau_b)
        K = self._bandwidth
        k = K * dt / (1 + K * dt)
        s_pa, s_pb = s_pa + k * (p_a - s_pa), s_pb + k * (p_b - s_pb)
        # momentum gained over a step is the work of the mean torque
        s_ta, s_tb = (
            s_ta + k * (0.5 * (tau_a + l_a) - s_ta),
            s_tb + k * (0.5 * (tau_b + l_b) - s_tb),
        )
        self._slow = (s_pa, s_pb, s_ta, s_tb)
        push_a, push_b = K * (p_a - s_pa) - s_ta, K * (p_b - s_pb) - s_tb
        # J^T f = push; J's columns are the drives a, b: f = i (push_b a - push_a b) / (a x b)
        a, b = limb.contact_drive
        det = (a.conjugate() * b).imag
        if abs(det) < 1e-6:  # stretched out: the cranks do not feel every direction
            return 0.0
        f = 1j * (push_b * a - push_a * b) / det
        return (lift.conjugate() * f).real

    def _weight_and_inertia(
        self, limb: LimbState, lift: complex
    ) -> tuple[tuple[float, float], tuple[float, float, float]]:
        """Torques [N m] that carry the links, and M's aa, ab, bb [kg m^2]."""
        (a, b), load = limb.pins, self._load
        (wa, wb), (ca, cb), k = limb.wrist_drive, limb.contact_drive, load.hand_at
        ha, hb = wa + k * (ca - wa), wb + k * (cb - wb)
        moment_a = load.pin_a * a + load.wrist * wa + load.hand * ha
        moment_b = load.pin_b * b + load.wrist * wb + load.hand * hb
        m_aa = load.pin_a * abs(a) ** 2 + load.wrist * abs(wa) ** 2 + load.hand * abs(ha) ** 2
        m_bb = load.pin_b * abs(b) ** 2 + load.wrist * abs(wb) ** 2 + load.hand * abs(hb) ** 2
        m_ab = (load.wrist * wa.conjugate() * wb + load.hand * ha.conjugate() * hb).real
        up = lift.conjugate()
        return (G * (up * moment_a).real, G * (up * moment_b).real), (
            load.rotor + m_aa,
            m_ab,
            load.rotor + m_bb,
        )


class ContactDetector:
    """Contact probabilities of the four limbs, order LIMBS."""

    def __init__(self, config: ContactConfig | None = None) -> None:
        self.config = config or ContactConfig()
        self._observers = [TorqueForce(name, self.config.bandwidth) for name in LIMBS]
        self.force = [0.0] * len(LIMBS)
        """Vertical force [N] per limb."""
        self.probability = [0.0] * len(LIMBS)
        self._wrist: list[float | None] = [None, None]

    def update(
        self,
        limbs: Sequence[LimbState],
        up: Vector,
        *,
        rates: Sequence[Sequence[float]],
        torques: Sequence[Sequence[float]],
        wrench_S: Sequence[Sequence[float]],
        dt: float,
    ) -> list[float]:
        """New probabilities (4).

        Args:
            limbs: Kinematics, order LIMBS.
            up: The believed vertical in ``base_link``.
            rates: Per limb, rates of motor a and b [rad/s].
            torques: Per limb, their torques [N m].
            wrench_S: Left and right wrist, force [N] first, sensor frame.
            dt: Time since the last call [s].
        """
        for i, limb in enumerate(limbs):
            if i < 2 and self.config.use_wrench:
                self.force[i] = self._wrist_force(i, limb, up, wrench_S[i], dt)
            else:
                self.force[i] = self._observers[i].update(limb, up, rates[i], torques[i], dt)
            self.probability[i] = self._probability(self.force[i], self.probability[i] > 0.5)
        return list(self.probability)

    def _wrist_force(
        self, i: int, limb: LimbState, up: Vector, wrench: Sequence[float], dt: float
    ) -> float:
        """The sensor feels what the gripper does to the wrist: its weight less the ground."""
        x, y, z = (dot(axis, up) for axis in limb.axes)
        raw = GRIPPER_MASS * G - (x * wrench[0] + y * wrench[1] + z * wrench[2])
        last = self._wrist[i]
        K = self.config.wrist_bandwidth * dt
        value = raw if last is None else last + K / (1 + K) * (raw - last)
        self._wrist[i] = value
        return value

    def _probability(self, force: float, standing: bool) -> float:
        c = self.config
        at = c.force - c.hysteresis if standing else c.force + c.hysteresis
        x = min(max((force - at) / c.width, -30.0), 30.0)
        return 1.0 / (1.0 + exp(-x))
