"""Fig. 4: how fast each mode is and how high it reaches, ours beside what the paper prints.

``python -m mobius.reproduce.fig_4 [--out FILE.png] [--results FOLDER]``

Speed: of crawl and biped the fastest mean speed that was reached on a straight command, from
the results of ``mobius eval BODY tracking`` (100 robots each); of the roll its mean speed from
where the hands let go until the trunk is level again (``mobius eval motions roll``).

Height: of the trunk's centre in the stance; the highest trunk at which the limbs that walk
still reach their places on the floor in the stance; and the highest point that closed fingertips
reach with the trunk in the stance, all by closed-form kinematics within the joint limits, links
taken to pass through one another. The paper's figure has heights of the trunk, drawn and not
printed; its speeds are those of Table V.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from mobius import paper
from mobius.errors import InvalidInput, MobiusError
from mobius.geometry import quat_to_mat
from mobius.headless import import_mujoco
from mobius.model.arm import gripper_pose
from mobius.model.build import joint_ranges
from mobius.model.dimensions import MIN_CRANK_SPREAD, limb_geometry
from mobius.model.joints import JOINTS, LIMB_JOINTS
from mobius.model.leg import sole_position
from mobius.model.reach import arm_joints, leg_joints
from mobius.model.robot import keyframe, keyframe_joints
from mobius.reproduce.common import as_text, write_out
from mobius.types import LIMBS, Mode

__all__ = [
    "Heights",
    "draw",
    "fastest",
    "heights",
    "highest_in_roll",
    "highest_tip",
    "highest_trunk",
    "roll_speed",
]

Array = NDArray[np.float64]

STANCES = {"crawl": "crawl", "biped": "stand"}
"""Mode -> keyframe of its stance."""
STRAIGHT = ("forward", "backward", "left", "right")
STEP = 0.002
"""Between heights that are tried [m]."""


@dataclass(frozen=True)
class Heights:
    """Of one stance, over the floor [m]."""

    trunk: float
    """Of the trunk's centre."""
    top_trunk: float
    """Highest trunk with the walking limbs on their places."""
    tip: float
    """Highest point that fingertips reach from the stance."""


def highest_tip(R_MB: Array, p_M: Array, count: int = 15) -> float:
    """Highest point (z of M) [m] of closed fingertips over all angles of the left arm.

    Args:
        R_MB: (3, 3) trunk.
        p_M: (3,) trunk [m].
        count: Angles tried for each of yaw, cranks and wrist pitch. Wrist roll and yaw stay 0.
    """
    g, ranges = limb_geometry("left_arm"), joint_ranges()
    names = [JOINTS[k] for k in range(4)]
    axes = [np.linspace(*ranges[name], count) for name in names]
    q = np.array(list(product(*axes)))
    q = q[q[:, 2] - q[:, 1] >= MIN_CRANK_SPREAD]
    tips, _ = gripper_pose(g, np.column_stack([q, np.zeros((len(q), 2))]))
    heights = tips @ R_MB[2] + p_M[2]
    return float(np.nanmax(heights))


def _within(limb: str, q: Array) -> bool:
    ranges = joint_ranges()
    low, high = np.array([ranges[j] for j in np.array(JOINTS)[LIMB_JOINTS[limb]]]).T
    fine = np.isfinite(q).all() and (q >= low - 1e-6).all() and (q <= high + 1e-6).all()
    return bool(fine and q[2] - q[1] >= MIN_CRANK_SPREAD - 1e-6)


def highest_trunk(body: str) -> float:
    """Highest trunk [m] that the walking limbs carry, their ends where the stance has them.

    Args:
        body: ``crawl`` or ``biped``.
    """
    qpos, q = keyframe(STANCES[body])[0], keyframe_joints(STANCES[body])[0]
    R, p = quat_to_mat(qpos[3:7]), np.array(qpos[:3])
    places = {}
    for limb in LIMBS:
        g, joints = limb_geometry(limb), q[LIMB_JOINTS[limb]]
        if g.is_arm and body == "biped":
            continue
        end = gripper_pose(g, joints)[0] if g.is_arm else sole_position(g, joints)
        places[limb] = R @ end + p

    def carried(z: float) -> bool:
        at = np.array([p[0], p[1], z])
        for limb, place in places.items():
            solve = arm_joints if limb.endswith("arm") else leg_joints
            if not _within(limb, solve(limb, R, at, place)):
                return False
        return True

    z = float(p[2])
    while carried(z + STEP):
        z += STEP
    return z


def heights(body: str) -> Heights:
    """The heights of a mode's stance.

    Args:
        body: ``crawl`` or ``biped``.
    """
    qpos = keyframe(STANCES[body])[0]
    tip = highest_tip(quat_to_mat(qpos[3:7]), np.array(qpos[:3]))
    return Heights(float(qpos[2]), highest_trunk(body), tip)


def fastest(results: Path, body: str) -> float:
    """Fastest mean speed on a straight command [m/s] in a results file.

    Raises:
        InvalidInput: The file is not there or holds no tracking.
    """
    path = results / f"{body}.json"
    try:
        commands = json.loads(path.read_text())["tracking"]["commands"]
        return max(float(np.linalg.norm(commands[name]["mean"][:2])) for name in STRAIGHT)
    except OSError as error:
        raise InvalidInput(
            f"{path} cannot be read ({error.strerror}); name the folder with --results, or make"
            f" the file with: python benchmarks/policies.py {body}"
        ) from None
    except (ValueError, KeyError):
        raise InvalidInput(f"{path}: expected the results of 'mobius eval {body}'") from None


def roll_speed(results: Path) -> float:
    """Mean speed of the roll [m/s], from where the hands let go until the trunk is level again.

    Raises:
        InvalidInput: The file is not there or holds no rolls.
    """
    path = results / "motions.json"
    try:
        return float(json.loads(path.read_text())["motions"]["roll"]["speed_mps"])
    except OSError as error:
        raise InvalidInput(
            f"{path} cannot be read ({error.strerror}); name the folder with --results, or make"
            " the file with: python benchmarks/motions.py roll"
        ) from None
    except (ValueError, KeyError, TypeError):
        raise InvalidInput(f"{path}: expected rolls of 'mobius eval motions roll'") from None


def highest_in_roll(seeds: int) -> float:
    """Median over rolls of the highest trunk [m]; those that did not come to their end are out.

    Raises:
        MobiusError: None did.
    """
    from mobius.reel import SHOWS, play

    films = [play(SHOWS["roll"], seed=seed) for seed in range(seeds)]
    high = [float(f.qpos[:, 2].max()) for f in films if not f.failed]
    if not high:
        raise MobiusError(f"no roll of {seeds} came to its end")
    return float(np.median(high))


def draw(path: Path, rows: list[dict[str, Any]]) -> None:
    """Speed against height, a line from the stance's trunk to the highest fingertip per mode."""
    from mobius.view.palette import MODE_COLOURS
    from mobius.view.png import save_png

    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    for row in rows:
        colour = MODE_COLOURS[Mode(row["mode"])]
        x, low, top = row["speed m/s"], row["trunk m"], row["top trunk m"]
        tip = row["fingertips m"]
        if tip is not None:
            axes.plot([x, x], [low, tip], color=colour, lw=1.2, ls=":")
            axes.plot(x, tip, "^", color=colour, ms=8)
        axes.plot([x, x], [low, top], color=colour, lw=6, solid_capstyle="butt", alpha=0.6)
        axes.plot(x, low, "o", color=colour, ms=8, label=f"{row['mode']}")
        axes.axvline(row["paper m/s"], color=colour, lw=1, ls="--", alpha=0.6)
    axes.plot([], [], "^", color="#555", label="fingertips reach")
    axes.plot([], [], color="#555", lw=6, alpha=0.6, label="trunk, stance to highest")
    axes.plot([], [], color="#555", lw=1, ls="--", label="speed in the paper's Table V")
    axes.set(
        xlabel="speed [m/s]", ylabel="height over the floor [m]", xlim=(0, None), ylim=(0, None)
    )
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=8, loc="upper right", bbox_to_anchor=(0.97, 1.0))
    save_png(path, figure, dpi=110, what="Fig. 4")


def table(results: Path, seeds: int) -> list[dict[str, Any]]:
    """A row per mode."""
    rows: list[dict[str, Any]] = []
    for body in ("biped", "crawl"):
        h = heights(body)
        rows.append(_row(body, fastest(results, body), h.trunk, h.top_trunk, h.tip))
    crawling = heights("crawl").trunk
    rows.append(_row("roll", roll_speed(results), crawling, highest_in_roll(seeds), None))
    return rows


def _row(mode: str, speed: float, trunk: float, top: float, tip: float | None) -> dict[str, Any]:
    return {
        "mode": mode,
        "speed m/s": round(speed, 3),
        "paper m/s": paper.MAX_SPEED[mode],
        "trunk m": round(trunk, 3),
        "top trunk m": round(top, 3),
        "fingertips m": None if tip is None else round(tip, 3),
    }


def main() -> None:
    """Print the table and draw the figure."""
    parser = argparse.ArgumentParser(prog="python -m mobius.reproduce.fig_4", description="Fig. 4")
    parser.add_argument("--out", type=Path, default=Path("fig_4.png"), help="the .png to write")
    parser.add_argument(
        "--results", type=Path, default=Path("benchmarks/results"), help="of mobius eval"
    )
    parser.add_argument("--seeds", type=int, default=5, help="rolls that are played")
    options = parser.parse_args()
    if options.seeds < 1:
        sys.exit(f"fig_4: --seeds: expected a whole number >= 1, got {options.seeds}")
    import_mujoco()
    try:
        rows = table(options.results, options.seeds)
    except MobiusError as error:
        sys.exit(f"fig_4: {error}")
    print(as_text(rows))
    write_out("fig_4", lambda: draw(options.out, rows), options.out)


if __name__ == "__main__":
    main()
