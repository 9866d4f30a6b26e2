"""What a pull-up is worth, by the simulator's truth."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mobius.modes.pullup import Phase

__all__ = ["PullUpJudge", "PullUpTruth", "Push"]

Array = NDArray[np.float64]

BACK_M = 0.01
"""The trunk is back when it is this near to where it was before the push [m]."""
SATURATED = 0.99
"""A servo that gives this share of its stall torque is saturated."""
FALL = 0.15
"""A trunk this far below the dead hang has fallen [m]."""
_CORNERS = np.array(
    [
        [
            0.170 + a * np.cos(np.radians(40.0)) + b * np.sin(np.radians(40.0)),
            0.0,
            0.047 - a * np.sin(np.radians(40.0)) + b * np.cos(np.radians(40.0)),
        ]
        for a in (-0.012, 0.012)
        for b in (-0.0125, 0.0125)
    ]
)
"""(4, 3) corners of the head camera's housing in the trunk's frame [m] (model.links)."""


@dataclass
class Push:
    """A push down on the trunk."""

    force: float
    """[N]."""
    begins: float
    ends: float
    """[s]."""
    place: Array = field(default_factory=lambda: np.zeros(3))
    """Trunk before it [m]."""
    gave: float = 0.0
    """Greatest way down [m]."""
    error: float = np.inf
    """Distance from where it was, 3 s after its end [m]."""


@dataclass(frozen=True)
class PullUpTruth:
    """Measured over one trial."""

    head_m: float
    """Top of the head above the bar's axis, at the end of the quiet hold [m]; -inf where it ended
    before."""
    lifted_m: float
    """Rise of the trunk from dead hang to hold [m]; -inf where it ended before."""
    return_error_m: tuple[float, ...]
    gave_m: tuple[float, ...]
    """Way down under each push [m]."""
    slip_m: tuple[float, float]
    """Of the spines on the bar, left and right [m]."""
    load_max: tuple[float, float]
    """Greatest share of each grasp's limit surface."""
    broken: bool
    fallen: bool
    saturated_share: float
    """Of the arms' servos' time at their stall torque."""
    torque_max: float
    """Greatest share of stall torque an arm's servo gave."""
    inner_N: float
    """Root mean square of the inner force along the bar about its mean while holding [N]."""
    shake_mps2: float
    """Root mean square of the trunk's vertical acceleration in the quiet hold [m/s^2]."""
    touched: tuple[str, ...]
    """What of the robot, fingers aside, has touched bar or itself."""
    ended: str
    """Phase in which it ended."""

    def fault(self, pushes: int) -> str:
        """What keeps it from being a success; empty where nothing does."""
        if self.broken:
            return "a grasp broke"
        if self.fallen:
            return "it fell"
        if self.head_m == -np.inf:
            return f"ended in phase '{self.ended}', before the hold"
        if not self.head_m > 0.0:
            return f"head {100 * self.head_m:.1f} cm from the bar's height"
        if len(self.return_error_m) < pushes:
            return "not pushed"
        bad = [e for e in self.return_error_m if not e <= BACK_M]
        if bad:
            return f"{100 * max(bad):.1f} cm off 3 s after a push"
        if self.ended != Phase.DONE:
            return f"ended in phase '{self.ended}', not lowered"
        if self.touched:
            return f"touched: {self.touched[0]}"
        return ""

    def as_json(self) -> dict[str, Any]:
        """Plain values; None for what was never measured."""
        plain = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(self).items()}
        return {k: None if v == -np.inf else v for k, v in plain.items()}


class PullUpJudge:
    """Watches a pull-up tick by tick."""

    def __init__(self, robot: Any, bar_height: float) -> None:
        self.robot, self.bar_height = robot, bar_height
        self.trunk = robot.model.body("base_link").id
        self.fallen = self.broken = False
        self.pushes: list[Push] = []
        self.push: Push | None = None
        self._z0 = float(robot.data.qpos[2])
        self._head = self._lifted = -np.inf
        self._ticks = 0
        self._full, self._most = 0, 0.0
        self._load = np.zeros(2)
        self._inner: list[float] = []
        self._accel: list[float] = []
        self._last_v = 0.0
        self._phase = Phase.HANG
        self._stall = robot.model.actuator_forcerange[robot.at.actuator[:12], 1]
        self._geoms = [robot.model.geom(i).name for i in range(robot.model.ngeom)]
        self._touched: set[str] = set()

    def head(self) -> float:
        """Top of the head above the bar's axis [m]."""
        d = self.robot.data
        R = d.xmat[self.trunk].reshape(3, 3)
        top = float((_CORNERS @ R.T)[:, 2].max() + d.xpos[self.trunk][2])
        return top - self.bar_height

    def before(self, push: Push) -> None:
        """A push begins now."""
        if not self.pushes:
            self._head, self._lifted = self.head(), float(self.robot.data.qpos[2]) - self._z0
        push.place = np.array(self.robot.data.qpos[:3])
        self.push = push

    def came_back(self, push: Push) -> None:
        """Time is up for coming back from a push."""
        push.error = float(np.linalg.norm(self.robot.data.qpos[:3] - push.place))
        self.pushes.append(push)
        self.push = None

    def see(self, phase: Phase, now: float) -> None:
        """After each tick."""
        robot, d = self.robot, self.robot.data
        self._phase = phase
        self._ticks += 1
        drive = np.abs(d.actuator_force[robot.at.actuator[:12]]) / self._stall
        self._full += int((drive >= SATURATED).sum())
        self._most = max(self._most, float(np.abs(robot.torque()[:12] / self._stall).max()))
        left, right = robot.grasps
        self._load = np.maximum(self._load, [left.load, right.load])
        self.broken |= not (left.holds and right.holds) and phase is not Phase.ABORT
        self.fallen |= bool(d.qpos[2] < self._z0 - FALL)
        v = float(d.qvel[2])
        if phase is Phase.HOLD:
            self._inner.append(0.5 * (left.force[0] + right.force[0]))  # mirrored axes
            if self.push is None and not self.pushes:
                self._accel.append((v - self._last_v) * 600.0)
                self._head, self._lifted = self.head(), float(d.qpos[2]) - self._z0
        self._last_v = v
        if self.push is not None:
            self.push.gave = max(self.push.gave, float(self.push.place[2] - d.qpos[2]))
        if self._ticks % 10 == 0:
            self._feel()

    def _feel(self) -> None:
        d: mujoco.MjData = self.robot.data
        for c in range(d.ncon):
            pair = [self._geoms[g] for g in d.contact.geom[c]]
            if not any("finger" in name for name in pair):
                self._touched.add(" - ".join(sorted(pair)))

    def truth(self) -> PullUpTruth:
        """Everything, at the end."""
        left, right = self.robot.grasps
        inner = np.array(self._inner or [0.0])
        accel = np.array(self._accel[60:] or [0.0])
        return PullUpTruth(
            head_m=float(self._head),
            lifted_m=float(self._lifted),
            return_error_m=tuple(p.error for p in self.pushes),
            gave_m=tuple(p.gave for p in self.pushes),
            slip_m=(float(left.slip), float(right.slip)),
            load_max=(float(self._load[0]), float(self._load[1])),
            broken=self.broken,
            fallen=self.fallen,
            saturated_share=self._full / max(12 * self._ticks, 1),
            torque_max=self._most,
            inner_N=float(inner.std()),
            shake_mps2=float(np.sqrt(np.mean(accel**2))),
            touched=tuple(sorted(self._touched)),
            ended=str(self._phase),
        )
