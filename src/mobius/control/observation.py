"""The policy's observation: one frame, its history, its mirror image.

The one place where an observation is laid out; training and the loop both call
:func:`build_frame` and :class:`History`. All arrays are batched over (n, ...).

``paper`` frame (Sec. IV-A2), 10 + 2 |A| wide: roll, pitch, yaw since the start [rad] of the
level heading frame; yaw rate
[rad/s]; vx, vy, vz [m/s]; Theta [rad]; last action; commanded vx, vy, wz.
``fast`` frame: unit gravity in the trunk frame; trunk rates [rad/s]; vx, vy, vz [m/s];
Theta minus its default [rad]; last action; command; with ``clock`` sine and cosine of the
gait clock. Velocities are in the heading frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mobius.control.bodies import Body
from mobius.errors import InvalidInput, UnknownName
from mobius.geometry import heading_yaw, quat_conj, quat_mul, quat_to_rpy, rotate, wrap_angle

Array = NDArray[np.float64]
FrameKind = Literal["fast", "paper"]
_Q_BH = np.array([0.5**0.5, 0.0, 0.5**0.5, 0.0])
"""The standing trunk's level frame (x forward, z up) seen from base_link: without it roll and
yaw of a trunk pitched by 90 degrees would be one angle."""


@dataclass(frozen=True)
class Layout:
    """What an observation consists of."""

    kind: FrameKind
    actions: int
    history: int
    """Frames stacked, the current one first."""
    clock: bool = False
    """Whether the frame ends with the gait clock (2 numbers)."""

    def __post_init__(self) -> None:
        if self.kind not in ("fast", "paper"):
            raise UnknownName("observation frame", self.kind, ("fast", "paper"))

    @property
    def frame_size(self) -> int:
        """Numbers in one frame."""
        head = 12 if self.kind == "fast" else 10
        return head + 2 * self.actions + (2 if self.clock else 0)

    @property
    def size(self) -> int:
        """Numbers in one observation."""
        return self.frame_size * self.history


def heading_twist(body: Body, q_OB: Array, v_B: Array, w_B: Array) -> tuple[Array, Array]:
    """Linear velocity (n, 3) [m/s] and angular velocity (n, 3) [rad/s] in the heading frame.

    Args:
        body: Decides which trunk axis is forward.
        q_OB: (n, 4) trunk orientation, wxyz.
        v_B: (n, 3) trunk velocity in the trunk frame.
        w_B: (n, 3) trunk angular velocity in the trunk frame.
    """
    yaw = heading_yaw(body.heading, q_OB)
    c, s = np.cos(yaw), np.sin(yaw)

    def to_heading(v: Array) -> Array:
        out = np.empty_like(v)
        out[..., 0] = c * v[..., 0] + s * v[..., 1]
        out[..., 1] = c * v[..., 1] - s * v[..., 0]
        out[..., 2] = v[..., 2]
        return out

    return to_heading(rotate(q_OB, v_B)), to_heading(rotate(q_OB, w_B))


def build_frame(
    layout: Layout,
    body: Body,
    *,
    q_OB: Array,
    v_B: Array,
    w_B: Array,
    yaw0: Array,
    joints: Array,
    default: Array,
    action: Array,
    command: Array,
    clock: Array | None = None,
) -> Array:
    """One observation frame (n, frame_size).

    Args:
        layout: Which numbers, in which order.
        body: The body that walks.
        q_OB: (n, 4) believed trunk orientation, wxyz.
        v_B: (n, 3) believed trunk velocity, trunk frame [m/s].
        w_B: (n, 3) trunk angular velocity, trunk frame [rad/s].
        yaw0: (n,) heading at the start [rad]; only ``paper`` uses it.
        joints: (n, k) encoder angles of the actuated joints [rad].
        default: (k,) their default targets [rad].
        action: (n, k) last raw action.
        command: (n, 3) vx, vy [m/s], wz [rad/s] in the heading frame.
        clock: (n, 2) of :meth:`GaitClock.observe`, where the layout has it.
    """
    tail = [action, command]
    if layout.clock:
        if clock is None:
            raise InvalidInput("build_frame: this layout has a gait clock; pass clock=...")
        tail.append(clock)
    v_H, w_H = heading_twist(body, q_OB, v_B, w_B)
    if layout.kind == "paper":
        upright = quat_mul(q_OB, _Q_BH) if body.heading == "biped" else q_OB
        rpy = quat_to_rpy(upright)
        rpy[..., 2] = wrap_angle(rpy[..., 2] - yaw0)
        return np.concatenate([rpy, w_H[..., 2:], v_H, joints, *tail], axis=-1)
    down = np.broadcast_to([0.0, 0.0, -1.0], v_B.shape)
    gravity = rotate(quat_conj(q_OB), down)
    return np.concatenate([gravity, w_B, v_H, joints - default, *tail], axis=-1)


class History:
    """The last ``layout.history`` frames of n robots, newest first."""

    def __init__(self, layout: Layout, n: int) -> None:
        self._frames = np.zeros((n, layout.history, layout.frame_size))
        self._fresh = np.ones(n, dtype=bool)

    def reset(self, which: NDArray[np.bool_] | slice = slice(None)) -> None:
        """The next frame of these robots fills their whole history."""
        self._fresh[which] = True

    def state(self) -> dict[str, Array]:
        """Frames and which robots are fresh."""
        return {"frames": self._frames.copy(), "fresh": self._fresh.astype(float)}

    def load_state(self, state: dict[str, Array]) -> None:
        """Go on from :meth:`state`."""
        self._frames[:], self._fresh[:] = state["frames"], state["fresh"] > 0

    def push(self, frame: Array) -> Array:
        """Add frames (n, frame_size); returns observations (n, size)."""
        frames = self._frames
        frames[:, 1:] = frames[:, :-1].copy()
        frames[:, 0] = frame
        if self._fresh.any():
            frames[self._fresh] = frame[self._fresh, None, :]
            self._fresh[:] = False
        return frames.reshape(len(frames), -1).copy()


def mirror_joints(body: Body) -> tuple[NDArray[np.int64], Array]:
    """Permutation and signs (k,) of the left-right mirror on a joint vector of the body.

    ``mirrored = sign * q[index]``. Yaw and roll joints change sign, the rest do not.
    """
    return mirror_names(body.joints)


def mirror_names(names: Sequence[str]) -> tuple[NDArray[np.int64], Array]:
    """The same for any joints or limbs by name; each must be there with its twin."""
    twins = [("right" if n.startswith("left") else "left") + n[n.index("_") :] for n in names]
    sign = [-1.0 if n.endswith(("yaw", "roll")) else 1.0 for n in names]
    return np.array([list(names).index(t) for t in twins], dtype=np.int64), np.array(sign)


def join_mirrors(*mirrors: tuple[NDArray[np.int64], Array]) -> tuple[NDArray[np.int64], Array]:
    """The mirror of a vector whose parts, one after another, have these mirrors."""
    sizes = np.cumsum([0, *(len(index) for index, _ in mirrors)])
    index = [i + first for (i, _), first in zip(mirrors, sizes, strict=False)]
    return np.concatenate(index), np.concatenate([sign for _, sign in mirrors])


def mirror_frame(layout: Layout, body: Body) -> tuple[NDArray[np.int64], Array]:
    """Permutation and signs (size,) of the mirror on a whole observation."""
    index, sign = mirror_joints(body)
    if layout.kind == "paper":  # roll, pitch, yaw, wz, vx, vy, vz
        head = np.array([-1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0])
    else:  # gravity, rates (a pseudovector), velocity
        head = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    h, k = len(head), layout.actions
    tail = [1.0, -1.0, -1.0] + ([-1.0, -1.0] if layout.clock else [])  # clock: half a period
    perm = np.concatenate(
        [np.arange(h), h + index, h + k + index, h + 2 * k + np.arange(len(tail))]
    ).astype(np.int64)
    signs = np.concatenate([head, sign, sign, tail])
    stacked = np.concatenate([perm + i * layout.frame_size for i in range(layout.history)])
    return stacked, np.tile(signs, layout.history)
