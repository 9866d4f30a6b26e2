"""The paper's failure case: in the dead hang both arms pull against each other.

Each hand runs the law for itself (Sec. V-G4), its force control along the bar tuned badly: so
little damping that the servos' lag turns it into an oscillation. The force that both hands put
on the bar against each other is what is measured, by the truth, second by second.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mobius.control.admittance import AdmittanceConfig, AxisGains
from mobius.control.pullup import pullup_config
from mobius.control.tuning import Tuner, TunerConfig
from mobius.evaluate.pullup import PullUpDraw, build_pullup
from mobius.modes.pullup import PullUpTimes
from mobius.robot.interface import TICK
from mobius.types import Mode, ModeCommand

__all__ = ["BAD_DAMPING", "Fight", "bad_config", "fight"]

Array = NDArray[np.float64]

BAD_DAMPING = 60.0
"""Along the bar [N s/m]; the pull-up's own is 400."""
TUNING = TunerConfig(window=0.6, period=0.2, spread=1.2, step_max=2.5)
"""Quicker and bolder than the tuner's own: the grasps break within two seconds."""


def bad_config(damping: float = BAD_DAMPING) -> AdmittanceConfig:
    """The pull-up's gains with hardly any damping along the bar."""
    base = pullup_config()
    D = np.array(base.damping)
    D[0] = damping
    return pullup_config(damping=D)


@dataclass(frozen=True, eq=False)
class Fight:
    """Both hands along the bar over one dead hang."""

    t: Array
    """(n,) [s]."""
    inner: Array
    """(n,) mean of both hands' forces along the bar, mirrored axes [N]."""
    slip_m: float
    """Of the worse hand [m]."""
    broken: bool
    gains: AxisGains
    """Along the bar at the end."""

    def swing(self, first: float, last: float) -> float:
        """Standard deviation of the inner force between two times [N]."""
        inside = (self.t >= first) & (self.t < last)
        return float(self.inner[inside].std()) if inside.any() else float("nan")


def fight(
    *,
    seconds: float = 8.0,
    config: AdmittanceConfig | None = None,
    together: bool = False,
    tune: bool = False,
    seed: int = 0,
) -> Fight:
    """One dead hang of the robot as drawn.

    Args:
        seconds: Its length [s].
        config: Gains; :func:`bad_config` if not given.
        together: See :class:`mobius.control.pullup.PullUp`.
        tune: Whether the tuner works on the gains along the bar.
        seed: Of the sensors' noise.
    """
    config = config or bad_config()
    tuner = Tuner(config.axis(0), 1 if together else 2, config=TUNING) if tune else None
    stack, robot, controller = build_pullup(
        PullUpDraw(seed=seed),
        config=config,
        together=together,
        tuner=tuner,
        times=PullUpTimes(hang_s=seconds + 1.0),
    )
    inner = []
    for _ in range(round(seconds / TICK)):
        stack.turn(lambda belief: ModeCommand(Mode.PULL_UP, np.zeros(3), belief.stamp))
        inner.append(0.5 * sum(float(g.force[0]) for g in robot.grasps))
        if not all(g.holds for g in robot.grasps):
            break
    return Fight(
        np.asarray(TICK * np.arange(1, len(inner) + 1), dtype=np.float64),
        np.array(inner),
        max(g.slip for g in robot.grasps),
        not all(g.holds for g in robot.grasps),
        AxisGains(*(float(v) for v in controller.law.gains[0, 0])),
    )
