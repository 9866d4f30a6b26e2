"""A tuner on the running force loop: which axes of which arm it sees, and who gets the gains.

    attached = Attached(Tuner(config.axis(2)), [(0, "z")])
    while True:
        attached.before(loop)
        out = loop.step(frame, q_WB)
        report = attached.after(loop, out)

``mix`` makes the tuner's axes from the loop's: ``[[0.5, -0.5]]`` over ``[(0, "y"), (1, "y")]`` is
the internal axis of two arms that hold one thing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobius.control.admittance import AXES, ForceLoop, LoopOutput
from mobius.control.tuning.tuner import Report, Tuner
from mobius.errors import InvalidInput, UnknownName

__all__ = ["Attached"]

Array = NDArray[np.float64]


class Attached:
    """Feeds a tuner from a :class:`ForceLoop` and gives its gains to the loop's axes."""

    def __init__(
        self, tuner: Tuner, axes: Sequence[tuple[int, str]], *, mix: ArrayLike | None = None
    ) -> None:
        """Attach.

        Args:
            tuner: Of as many axes as ``mix`` has rows.
            axes: Arm (0 left, 1 right) and axis, e.g. ``(0, "z")``; all get the tuner's gains.
            mix: (tuner.n, len(axes)) the tuner's axes as sums of these; each its own if not
                given.
        """
        for arm, axis in axes:
            if arm not in (0, 1) or axis not in AXES:
                raise UnknownName(
                    "axis of an arm", f"{arm}, {axis}", [f"0 or 1, {a}" for a in AXES]
                )
        self.tuner, self.axes = tuner, tuple(axes)
        self.mix = np.eye(len(self.axes)) if mix is None else np.asarray(mix, dtype=float)
        if self.mix.shape != (tuner.n, len(self.axes)):
            raise InvalidInput(
                f"Attached.mix: expected shape ({tuner.n}, {len(self.axes)}), a row an axis of the"
                f" tuner, got {self.mix.shape}"
            )
        self._at = (np.array([a for a, _ in axes]), np.array([AXES.index(i) for _, i in axes]))
        self._state: Array | None = None
        self._calm = False

    def before(self, loop: ForceLoop) -> None:
        """Remember what the law knows before it steps."""
        self._state = self.mix @ loop.law.state[self._at]
        self._filtered = self.mix @ loop.wrench.filtered_C[self._at]

    def after(self, loop: ForceLoop, out: LoopOutput) -> Report | None:
        """Show the tuner the tick; where it has new gains, the law gets them."""
        if self._state is None:
            raise InvalidInput("Attached.after: call before(loop) ahead of loop.step")
        arms = self._at[0]
        limited = out.motion.velocity_clipped | out.motion.position_clipped
        limited = limited | out.motion.integral_clipped | out.motion.governed
        lost = loop.law.resuming[arms] | out.unreachable[arms]
        calm = not (limited[self._at].any() or lost.any())
        report = self.tuner.observe(
            self._state,
            self.mix @ out.wrenches.raw_C[self._at],
            self.mix @ loop.wrench_reference[self._at],
            filtered=self._filtered,
            x_ref=self.mix @ loop.x_ref[self._at],
            ok=calm and self._calm,
        )
        self._calm = calm  # a tick that begins where a limit was met says nothing either
        if report is not None and report.verdict in ("taken", "shrunk"):
            for arm, axis in self.axes:
                loop.law.set_gains(arm, axis, report.gains)
        return report
