"""Why a plan does not exist or ends elsewhere: which wall, which ground, how many steps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from mobius.barrier import Barrier, thinnest, wall_between
from mobius.plan.bounds import PAD, UNREACHED, Arcs, build_arcs, shortest_steps, steps_from
from mobius.plan.problem import Problem
from mobius.types import ALL_MODES_BITS, Mode, Plan

__all__ = ["short_of_goal", "shut_in", "what_separates"]

Cell = tuple[int, int]


def what_separates(problem: Problem, arcs: Arcs) -> str:
    """What lies between the cells the robot can reach and those from which it gets to the goal.

    Args:
        problem: One whose goal cannot be reached in any number of steps.
        arcs: Its :func:`mobius.plan.bounds.build_arcs`.
    """
    reached = _cells(arcs, steps_from(problem, arcs) < UNREACHED)
    home = _cells(arcs, shortest_steps(problem, arcs) < UNREACHED)
    line = thinnest(reached, home)
    wall = wall_between(problem.grid, line)
    return wall if wall is not None else _ground(problem, line)


def shut_in(problem: Problem) -> str:
    """What keeps the robot on its start, whichever step it tries."""
    grid, (i, j) = problem.grid, problem.start
    around = [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]
    inside = [c for c in around if grid.holds(c)]
    walls = [c for c in inside if grid.blocked[c]]
    if not inside:
        return "the map has no other cell"
    if walls:
        edge = " and the map's edge" if len(inside) < len(around) else ""
        return f"walls such as the one at {_metres(problem, walls[0])}{edge}"
    return f"no step of {', '.join(problem.modes)} fits the ground around it"


def short_of_goal(problem: Problem, plan: Plan) -> str | None:
    """What to know of a plan that ends away from the goal; ``None`` for one that ends there.

    Says how many steps are missing, or that the goal could be reached and would earn less.
    """
    last = (int(plan.cells[-1][0]), int(plan.cells[-1][1])) if len(plan.cells) else problem.start
    if last == problem.goal:
        return None
    arcs = build_arcs(problem)
    fewest = int(shortest_steps(problem, arcs)[arcs.flat(problem.start)])
    away = float(np.linalg.norm(np.subtract(last, problem.goal))) * problem.grid.cell
    where = f"the plan ends at {_metres(problem, last)}, {away:.3g} m from the goal"
    if fewest >= UNREACHED:
        return f"{where}, which cannot be reached: {what_separates(problem, arcs)}"
    if fewest > problem.horizon:
        return (
            f"{where}, which takes at least {fewest} steps: horizon {problem.horizon} is"
            f" {fewest - problem.horizon} too short"
        )
    return (
        f"{where}: ending there was worth more; pass must_reach=True for a plan that ends at the"
        " goal"
    )


def _mode_names(bits: int) -> str:
    """The modes in a bit set, in words."""
    if bits & ALL_MODES_BITS == ALL_MODES_BITS:
        return "every mode"
    names = [m.value for m in (Mode.BIPED, Mode.CRAWL, Mode.ROLL) if bits & m.bit]
    return " and ".join(names) + " only" if names else "no mode"


def _ground(problem: Problem, line: Barrier) -> str:
    """What is wrong with a line without a wall: its ground, a change of mode, or the steps."""
    allowed = problem.grid.allowed
    usable = sum(m.bit for m in problem.modes)
    bad = [c for c in line.between if not allowed[c] & usable]
    if bad:
        bits = int(allowed[bad[0]])
        hint = "" if bits else ": regions that force different modes overlap there"
        where = _metres(problem, bad[0])
        return f"the ground in between, at {where}, allows {_mode_names(bits)}{hint}"
    path = (line.near, *line.between, line.far)
    for a, b in pairwise(path):
        if not allowed[a] & allowed[b] & usable:
            return (
                f"the ground allows {_mode_names(int(allowed[a]))} at {_metres(problem, a)} and"
                f" {_mode_names(int(allowed[b]))} at {_metres(problem, b)}, and the body changes"
                " its mode only on ground that allows both"
            )
    return (
        f"no wall is in between, but steps of {', '.join(problem.modes)} with connectivity"
        f" '{problem.connectivity}' never land there"
    )


def _cells(arcs: Arcs, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(nx, ny) of a mask over the padded frame."""
    return mask.reshape(-1, arcs.stride)[PAD:-PAD, PAD:-PAD]


def _metres(problem: Problem, cell: Cell) -> str:
    x, y = (round(float(v), 3) + 0.0 for v in problem.grid.center_of(cell))
    return f"({x:g}, {y:g}) m"
