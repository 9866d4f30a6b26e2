"""Fig. 15: force manipulability of the hanging arm, and the law under a downward push.

``python -m mobius.reproduce.fig_15 [--out FILE.png]``. (A) is the ellipsoid of our arm in a
hang of our own: fingertips 0.42 m above the shoulder, approach axis up, a bar across. The
paper prints no number for it, only that it is longest along the pull. (B) to (D) are the
admittance law of one arm with a prescribed push (15 N down for 1 s) and the paper's
references; they show what the law does, not a pull-up in physics. A spring of 60 N/m stands
for the contact along z, with which the law compromises.

Axes: x pull (the approach axis), y along the handle, z normal of the gripper for (A). For (B)
to (D) the paper plots y as the vertical (row 57), and so do we.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from numpy.typing import NDArray

from mobius import paper
from mobius.control.admittance import DT, Admittance, AdmittanceConfig, Wrenches
from mobius.errors import MobiusError
from mobius.model.arm import gripper_ik, gripper_pose
from mobius.model.dimensions import limb_geometry
from mobius.model.force_ellipsoid import ForceEllipsoid, arm_force_ellipsoid, arm_stall
from mobius.reproduce.common import as_text, write_out

__all__ = ["Response", "draw", "ellipsoid_at", "hang", "push_response", "rows"]

Array = NDArray[np.float64]

LIMB = "left_arm"
HANG = (0.42, 0.10)
"""Fingertips above and before the shoulder in the dead hang, trunk upright [m]."""
PULLED = (0.20, 0.22)
"""The same at the top of the pull [m]."""
TURN = 15.0
"""Of the gripper about its approach axis, which keeps the wrist off its stops [deg]."""
SPRING = 60.0
"""[N/m]."""
PUSH_AT, PUSH_S, PULL_AT, LENGTH = 2.0, 1.0, 6.0, 16.0
"""When the push begins, how long it lasts, when the references move, the whole [s]."""
_INK, _LINES = "#1d2126", ("#c0392b", "#2a7fd4", "#2f9e6e")


def hang(place: tuple[float, float] = HANG) -> Array:
    """Joint angles (6,) [rad] of the left arm with its fingertips at a place, approach up."""
    g, a = limb_geometry(LIMB), np.radians(TURN)
    p_B = np.array(g.hip_B) + [place[0], 0.0, -place[1]]
    z = np.array([-1.0, 0.0, 0.0])
    x = np.array([0.0, np.cos(a), np.sin(a)])
    return gripper_ik(g, p_B, np.column_stack([x, np.cross(z, x), z]))


def ellipsoid_at(q: Array, *, torque: Array | None = None) -> ForceEllipsoid:
    """Section f_x, f_y, tau_z in the handle's axes: pull, along the handle, normal."""
    R = gripper_pose(limb_geometry(LIMB), q)[1]
    R_BF = np.column_stack([-R[:, 2], R[:, 0], -R[:, 1]])
    return arm_force_ellipsoid(LIMB, q, R_BF=R_BF, torque=torque)


@dataclass(frozen=True, eq=False)
class Response:
    """One arm's law over time, axes of the handle."""

    t: Array
    """(n,) [s]."""
    x: Array
    """(n, 3) position from the start [m]."""
    x_ref: Array
    """(n, 3) [m]."""
    force: Array
    """(n, 3) by the environment on the gripper [N]."""
    moment: Array
    """(n,) about the normal [N m]."""


def push_response() -> Response:
    """The law under the push, then on its way to the references."""
    config = AdmittanceConfig(
        damping=[250.0] * 3 + [5.0] * 3,  # type: ignore[arg-type]
        stiffness=[250.0] * 3 + [6.0] * 3,  # type: ignore[arg-type]
        position_min=[-0.4] * 3 + [-1.0] * 3,  # type: ignore[arg-type]
        position_max=[0.4] * 3 + [1.0] * 3,  # type: ignore[arg-type]
    )
    law = Admittance([config])
    n = round(LENGTH / DT)
    t = np.linspace(0.0, (n - 1) * DT, n)
    target = np.array(paper.PULL_UP.reference)
    share = np.clip((t - PULL_AT) / 4.0, 0.0, 1.0)
    x_ref = (share * share * (3 - 2 * share))[:, None] * target
    pushed = (t >= PUSH_AT) & (t < PUSH_AT + PUSH_S)
    push = -paper.PULL_UP.disturbance * pushed.astype(float)
    x, force, moment = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n)
    ready = np.ones(1, dtype=bool)
    zero = np.zeros((1, 6))
    for k in range(n):
        y = law.state[0, :, 3]
        f = np.array([0.0, push[k], -SPRING * y[2]])
        tau = 0.1 * push[k]  # the push does not pass through the grip
        w = np.concatenate([f, [0.0, 0.0, tau]])[None]
        motion = law.step(
            Wrenches(w, w, ready, np.zeros((1, 6), dtype=bool)),
            np.concatenate([x_ref[k], np.zeros(3)])[None],
            zero,
        )
        x[k], force[k], moment[k] = motion.x[0, :3], f, tau
    return Response(t, x, x_ref, force, moment)


def rows(response: Response) -> list[dict[str, Any]]:
    """The figure's numbers, ours beside the paper's."""
    at_hang, pulled = ellipsoid_at(hang()), ellipsoid_at(hang(PULLED))
    strong = ellipsoid_at(hang(), torque=arm_stall(LIMB))
    out: list[dict[str, Any]] = []
    names = ("pull f_x [N]", "along the handle f_y [N]", "moment tau_z [N m]")
    for what, e in (
        ("hang, 1 N m a joint", at_hang),
        ("top of the pull, 1 N m a joint", pulled),
        ("hang, stall torques", strong),
    ):
        for name, value in zip(names, e.reach, strict=True):
            out.append({"what": f"(A) {what}: {name}", "ours": float(value), "paper": None})
    lowest, moment = response.x[:, 1].min(), float(response.moment.min())
    out += [
        {"what": "(A) pull over the handle's direction, hang", "ours": _ratio(at_hang),
         "paper": "longest along x"},
        {"what": "(B) moment about the normal, prescribed [N m]", "ours": moment,
         "paper": paper.PULL_UP.normal_moment[0]},
        {"what": "(C) y at its lowest under the push [m]", "ours": float(lowest), "paper": None},
        {"what": "(C) y at the end [m]", "ours": float(response.x[-1, 1]),
         "paper": paper.PULL_UP.reference[1]},
        {"what": "(C) x at the end [m]", "ours": float(response.x[-1, 0]),
         "paper": paper.PULL_UP.reference[0]},
        {"what": "(C) z at the end [m]", "ours": float(response.x[-1, 2]),
         "paper": paper.PULL_UP.reference[2]},
        {"what": "(D) largest push in y [N]", "ours": float(-response.force[:, 1].min()),
         "paper": paper.PULL_UP.disturbance},
    ]  # fmt: skip
    return out


def _ratio(e: ForceEllipsoid) -> float:
    return float(e.reach[0] / e.reach[1])


def draw(path: Path, response: Response) -> None:
    """Draw the figure into a ``.png``."""
    from mobius.view.png import save_png

    figure = Figure(figsize=(12.5, 7.0), layout="constrained")
    grid = figure.subplots(2, 3)
    pull, along = "pull $f_x$ [N]", "along the handle $f_y$ [N]"
    moment = "moment about the normal $\\tau_z$ [N m]"
    pairs = ((0, 1, pull, along), (0, 5, pull, moment), (1, 5, along, moment))
    for axes, (i, j, x, y) in zip(grid[0], pairs, strict=True):
        for place, colour, name in (
            (HANG, _LINES[0], "dead hang"),
            (PULLED, _LINES[1], "top of the pull"),
        ):
            _ellipse(axes, ellipsoid_at(hang(place)).section(i, j), colour, name)
        _frame(axes, x, y)
        axes.axhline(0, color="#dcdfe3", lw=0.8, zorder=0)
        axes.axvline(0, color="#dcdfe3", lw=0.8, zorder=0)
    grid[0, 0].set_title("(A) force manipulability, 1 N m a joint", loc="left", fontsize=10)
    grid[0, 0].legend(frameon=False, fontsize=8)
    _series(grid[1], response)
    save_png(path, figure, dpi=100, what="Fig. 15")


def _ellipse(axes: Axes, e: ForceEllipsoid, colour: str, name: str) -> None:
    lengths, vectors = e.axes
    angle = float(np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0])))
    axes.add_patch(
        Ellipse(
            (0, 0), 2 * lengths[0], 2 * lengths[1], angle=angle, fc=colour, ec=colour, alpha=0.25,
            label=name,
        )
    )  # fmt: skip
    axes.plot(*e.surface().T, color=colour, lw=1.6)


def _series(panels: Any, r: Response) -> None:
    moment, position, force = panels
    moment.plot(r.t, r.moment, color=_INK, lw=1.6)
    moment.set_title("(B) moment about the normal: the push, off the grip", loc="left", fontsize=10)
    _frame(moment, "time [s]", "$\\tau_z$ [N m]")
    for k, name in enumerate("xyz"):
        position.plot(r.t, r.x_ref[:, k], color=_LINES[k], lw=1.0, ls="--")
        position.plot(r.t, r.x[:, k], color=_LINES[k], lw=1.8, label=name)
        force.plot(r.t, r.force[:, k], color=_LINES[k], lw=1.8, label=name)
    position.set_title("(C) position, dashed its reference", loc="left", fontsize=10)
    force.set_title("(D) force on the gripper", loc="left", fontsize=10)
    for axes in (position, force):
        axes.legend(frameon=False, fontsize=8)
    _frame(position, "time [s]", "from the start [m]")
    _frame(force, "time [s]", "force [N]")


def _frame(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=9)
    axes.set_ylabel(y, fontsize=9)
    axes.tick_params(labelsize=8)
    axes.spines[["top", "right"]].set_visible(False)


def main() -> None:
    """Draw, and print the numbers."""
    parser = argparse.ArgumentParser(
        prog="python -m mobius.reproduce.fig_15", description="force manipulability and the push"
    )
    parser.add_argument("--out", type=Path, default=Path("fig_15.png"), help="the .png to write")
    options = parser.parse_args()
    try:
        response = push_response()
    except MobiusError as error:
        sys.exit(f"fig_15: {error}")
    print(as_text(rows(response)))
    print("(B) to (D): the law under a prescribed push, not a pull-up in physics.")
    write_out("fig_15", lambda: draw(options.out, response), options.out)


if __name__ == "__main__":
    main()
