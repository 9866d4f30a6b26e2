"""Gather: hands and feet step from wherever they stand to where the motions begin.

A crawl policy may stand on other places than keyframe ``crawl``, in which every motion between
bodies begins. The feet go there in diagonal pairs, as in a trot, but slower: left hand and right
foot, then the others. Before a pair lifts, the trunk moves until the centre of mass is over the
line between the two that stay, so that the robot balances on them.

Everything is laid out in the trunk frame B as it is at the start. A foot is its ankle or wrist
axis, which the five-bars' closed form reaches, and the angle of what hangs on it. A servo carries
load by the angle that its joint gives way, so each target has statics added, tau / kp with
tau = -J^T F: a pair that stands alone carries all, one in the air nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.errors import InvalidInput
from mobius.model.arm import gripper_jacobian
from mobius.model.build import joint_ranges
from mobius.model.dimensions import limb_geometry
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.model.leg import ankle_ik, ankle_position, sole_jacobian
from mobius.model.reach import ends
from mobius.model.servo import servo_of
from mobius.modes.motions.motion import Motion, Stage, Window
from mobius.modes.motions.player import smooth_step
from mobius.modes.posture import Posture
from mobius.types import LIMBS, frozen_array

Array = NDArray[np.float64]

Feet = tuple[int, ...]
"""Some of LIMBS, by number."""

LIFT = 0.03
"""How high the feet go [m]."""
LEAN_S, STEP_S, SHIFT_S = 0.2, 0.31, 0.12
"""Times to level the trunk and shift it over the first two feet, to step with a pair, and to shift
from one pair to the other, and back to the middle [s]."""
STILL_S = 0.1
"""The trunk comes to rest this long before the first pair lifts [s]; servos trail by 0.05 s."""
REST_S, HOLD_S = 0.12, 0.0
"""And to lower the trunk at the end, and to come to rest there [s]."""
PAIRS: tuple[Feet, ...] = ((0, 3), (1, 2))
"""Which of LIMBS step together: left hand and right foot, right hand and left foot."""
POSES = 8
"""Key poses of a step."""
ROUNDS = 2
"""Fixed-point rounds for the trunk's shift; the second leaves 3 % of the first's error."""
EDGE = 0.2
"""Share of a step in which a pair is unloaded; it is loaded once it stands."""
LEVEL = Window(pitch=0.0, within=0.6, lean=0.5)
"""The trunk stays within 34 deg of level, as in all motions on four limbs."""
GRAVITY = 9.81
_KP = np.array([servo_of(joint).kp for joint in JOINTS])
_LOW, _HIGH = np.array([joint_ranges()[j] for j in JOINTS]).T


@dataclass(frozen=True, eq=False)
class Gathered:
    """Where it ends."""

    q: Array
    """(22,) joint angles [rad]."""
    targets: Array
    """(22,) servo targets that hold them [rad]."""
    com: Callable[[Array], Array]
    """Centre of mass (3,) in B [m] at joint angles (22,) [rad]."""
    mass: float
    """Of the robot [kg]."""

    def __post_init__(self) -> None:
        frozen_array(self, "q", self.q, (len(JOINTS),))
        frozen_array(self, "targets", self.targets, (len(JOINTS),))


@dataclass(frozen=True, eq=False)
class _Stand:
    """Four limbs in B: ankle or wrist axes (4, 3) [m], angles (4,) [rad] of feet and grippers
    outward of "down", and wrist roll and yaw (4, 2) [rad], 0 for legs.
    """

    axes: Array
    tilt: Array
    wrist: Array


def build_gather(q: ArrayLike, up_B: ArrayLike, end: Gathered) -> Motion:
    """The motion of a robot on its four limbs to ``end``.

    Args:
        q: (22,) joint angles [rad] it begins in.
        up_B: (3,) the world's up in its trunk frame.
        end: Where it ends.

    Raises:
        InvalidInput: A place on the way is out of a limb's reach.
    """
    return _Way(np.asarray(q, dtype=float), np.asarray(up_B, dtype=float), end).motion()


class _Way:
    """The poses between two stands; a step is a pair of LIMBS, a shift (2,) [m] is how far the
    trunk has moved over the floor.
    """

    def __init__(self, q: Array, up_B: Array, end: Gathered) -> None:
        self._end = end
        self._before, self._after = _stand_of(q), _stand_of(np.asarray(end.q))
        soles, last = ends(q), ends(np.asarray(end.q))
        self._soles = soles[:, :2], last[:, :2]
        depth = float(soles[:, 2].mean())
        self._before.axes[:, 2] += depth - soles[:, 2]  # level over the feet
        self._drop = float(last[:, 2].mean()) - depth
        """Feet are set down this far below their last places [m]: the trunk is lowered last."""
        self._depth, self._slope = depth, _slope(soles, up_B)

    def motion(self) -> Motion:
        """Shift, step, shift, step, lower."""
        first, second = sorted(PAIRS, key=lambda pair: self._shift_before(pair))
        none, half, all_ = (), first, (0, 1, 2, 3)
        over_second = self._over(none, second)
        over_first = self._over(half, first)
        stages = (
            self._still(none, over_second, LEAN_S, STILL_S),
            self._stepped(none, first, over_second, over_first),
            self._still(half, over_first, SHIFT_S),
            self._stepped(half, second, over_first, over_first),
            self._still(all_, np.zeros(2), SHIFT_S),
            Stage(np.asarray(self._end.targets), REST_S, hold=HOLD_S, window=LEVEL),
        )
        return Motion("gather", Posture.CRAWLING, Posture.CRAWLING, stages)

    def _places(self, moved: Feet) -> Array:
        """(4, 2) [m] of the soles and fingertips on the floor."""
        before, after = self._soles
        on = np.isin(np.arange(4), moved)[:, None]
        return np.where(on, after, before)

    def _weight(self, moved: Feet, shift: Array) -> Array:
        """(2,) on the floor below the centre of mass [m]; limbs stay behind as the trunk moves."""
        com = self._end.com(self._joints(*self._feet(moved, (), 0.0), shift))
        return np.asarray(shift + com[:2] - self._slope * (com[2] - self._depth))

    def _shift_before(self, pair: Feet) -> float:
        """How far the trunk must move before a pair may lift first [m]."""
        stays = PAIRS[1 - PAIRS.index(pair)]
        return float(np.linalg.norm(self._over((), stays)))

    def _over(self, moved: Feet, pair: Feet) -> Array:
        """(2,) shift [m] that brings the centre of mass over the line between two feet, on the
        shortest way from where it would be in the middle.
        """
        a, b = self._places(moved)[list(pair)]
        along = (b - a) / np.linalg.norm(b - a)
        shift = np.zeros(2)
        for _ in range(ROUNDS):
            off = a - self._weight(moved, shift)
            shift = shift + off - (off @ along) * along
        return shift

    def _still(self, moved: Feet, shift: Array, seconds: float, hold: float = 0.0) -> Stage:
        """All feet stand."""
        q = self._joints(*self._feet(moved, (), 0.0), shift)
        weight = self._weight(moved, shift)
        return Stage(self._held(q, self._shares(moved, weight)), seconds, hold=hold, window=LEVEL)

    def _stepped(self, moved: Feet, pair: Feet, begin: Array, end: Array) -> Stage:
        """A pair goes to its last places."""
        weight = self._weight(moved, begin)
        four, two = self._shares(moved, weight), self._shares(moved, weight, air=pair)
        on_the_way = np.arange(1, POSES + 1) / POSES
        q = [
            self._joints(*self._feet(moved, pair, u), begin + u * (end - begin)) for u in on_the_way
        ]
        poses = self._held(
            np.stack(q), four + np.minimum(1.0, on_the_way / EDGE)[:, None] * (two - four)
        )
        return Stage(poses[-1], STEP_S, through=poses[:-1], window=LEVEL)

    def _feet(self, moved: Feet, pair: Feet, u: float) -> tuple[Array, Array, Array]:
        """Axes, tilts and wrists with a pair on its way at ``u``, 0 to 1."""
        share = np.isin(np.arange(4), moved).astype(float)
        share[list(pair)] = smooth_step((u - 0.5 * EDGE) / (1.0 - EDGE))
        a, b, s = self._before, self._after, share[:, None]
        axes = a.axes + s * (b.axes - a.axes)
        axes[:, 2] -= share * self._drop
        axes[list(pair), 2] += LIFT * np.sin(np.pi * u) ** 2
        return axes, a.tilt + share * (b.tilt - a.tilt), a.wrist + s * (b.wrist - a.wrist)

    def _joints(self, axes: Array, tilt: Array, wrist: Array, shift: Array) -> Array:
        """(22,) angles [rad]; grippers as at the end."""
        q = np.array(self._end.q)
        for k, limb in enumerate(LIMBS):
            g, joints = limb_geometry(limb), LIMB_JOINTS[limb]
            yaw, a, b = ankle_ik(g, axes[k] - [*shift, 0.0])
            if not np.isfinite([yaw, a, b]).all():
                raise InvalidInput(
                    f"gather, {limb}: expected an ankle or wrist within reach, got"
                    f" {np.round(axes[k], 3).tolist()} m in the trunk frame"
                )
            pitch = tilt[k] - float(g.fivebar.distal_angle(a, b))
            more = wrist[k] if g.is_arm else ()
            q[joints] = [yaw, a, b, pitch, *more]
        return q

    def _shares(self, moved: Feet, weight: Array, air: Feet = ()) -> Array:
        """(4,) of the weight, over (2,) [m], that each foot carries; 0 in the air, else the most
        even shares that balance.
        """
        feet = [k for k in range(4) if k not in air]
        A = np.vstack([np.ones(len(feet)), (self._places(moved)[feet] - weight).T])
        share = np.zeros(4)
        share[feet] = np.linalg.pinv(A) @ [1.0, 0.0, 0.0]
        return share

    def _held(self, q: Array, share: Array) -> Array:
        """Targets (..., 22) [rad] that hold q (..., 22) where each foot carries its share
        (..., 4).
        """
        target, kg = q.copy(), share * self._end.mass
        for k, limb in enumerate(LIMBS):
            g, joints = limb_geometry(limb), LIMB_JOINTS[limb]
            J = gripper_jacobian if g.is_arm else sole_jacobian
            rise = J(g, q[..., joints])[..., 2, :]
            target[..., joints] -= GRAVITY * kg[..., k, None] * rise / _KP[joints]
        return np.clip(target, _LOW, _HIGH)


def _slope(soles: Array, up_B: Array) -> Array:
    """(2,) how far "up" leans off the normal of the floor below four feet (4, 3) [m], per metre."""
    A = np.column_stack([soles[:, :2], np.ones(len(soles))])
    floor = np.linalg.lstsq(A, soles[:, 2], rcond=None)[0]  # z = floor . (x, y, 1)
    return np.asarray(up_B[:2] / up_B[2] + floor[:2])


def _stand_of(q: Array) -> _Stand:
    axes, tilt, wrist = np.zeros((4, 3)), np.zeros(4), np.zeros((4, 2))
    for k, limb in enumerate(LIMBS):
        g, joints = limb_geometry(limb), q[LIMB_JOINTS[limb]]
        axes[k] = ankle_position(g, joints)
        tilt[k] = g.fivebar.distal_angle(joints[1], joints[2]) + joints[3]
        if g.is_arm:
            wrist[k] = joints[4:]
    return _Stand(axes, tilt, wrist)
