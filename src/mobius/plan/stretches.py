"""Parts of a plan searched again while the rest stays as it is.

The bound table of a part pays only for cells that the rest does not count, so it is far
tighter than the table of the whole problem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mobius.plan.flatspace import Bits, FlatSpace
from mobius.plan.search import Budget
from mobius.plan.wide import Task, Way, wide_beam

__all__ = ["improve", "known_way", "part_task", "whole_task", "worth"]


def whole_task(flat: FlatSpace) -> Task:
    """The whole problem, with the tables of what is left to be counted."""
    task = part_task(flat, None, 0, flat.T)
    nothing = np.zeros_like(task.pay)
    rest = flat.table(nothing, flat.end, flat.T, 0, early=task.stops_early)
    return replace(task, rest=rest, reach=flat.within())


def part_task(flat: FlatSpace, way: Way | None, first: int, last: int) -> Task:
    """Steps ``first`` to ``last`` of a path (of any path, if ``None``).

    A part that ends with the path may end anywhere, and as early as the problem allows;
    another must end where the rest goes on.
    """
    problem = flat.space.problem
    begin = flat.begin if way is None else _counted(flat, way, first, last)
    cell = 0 if way is None else way.cells[first]
    pay = np.where(flat.holds(begin), 0.0, flat.W)
    if way is None or last >= len(way.actions):
        end, steps, later = flat.end, flat.T - first, 0
        counts, early = problem.count_terminal, problem.early_stop
    else:
        end = np.full(len(flat.cells), -np.inf)
        end[way.cells[last]] = 0.0
        steps, later = last - first, flat.T - last
        counts = early = False
    stop = end + (pay[flat.bit] if counts else 0.0)
    table = flat.table(pay, stop, steps, later, early=early)
    return Task(flat, cell, begin, steps, later, table, pay, end, counts, early)


def _counted(flat: FlatSpace, way: Way, first: int, last: int) -> Bits:
    """(words,) cells that a path counts outside its steps ``first`` to ``last``."""
    bits = [flat.none]
    for t, arc in enumerate(flat.arcs_of(way.cells)):
        if not first <= t < last:
            bits += flat.seen[way.cells[t], arc].tolist()
    if last < len(way.actions) and flat.space.problem.count_terminal:
        bits.append(int(flat.bit[way.cells[-1]]))
    return flat.set_of(bits)


def worth(task: Task, cells: tuple[int, ...]) -> float:
    """What a path earns as a path of the task, every cell paying once [points]."""
    flat = task.flat
    begin = task.begin.copy()
    gained = begin.copy()
    cost = 0.0
    for c, arc in zip(cells, flat.arcs_of(cells), strict=False):
        gained |= flat.set_of(flat.seen[c, arc].tolist())
        cost += float(flat.cost[c, arc])
    if task.counts_end:
        gained |= flat.set_of([int(flat.bit[cells[-1]])])
    new = int(np.bitwise_count(gained & ~begin).sum())
    return flat.W * new - cost + float(task.end[cells[-1]])


def known_way(flat: FlatSpace, cells: Sequence[int]) -> Way:
    """A path of the whole problem given by flat cells, each step by its cheapest action."""
    numbers = tuple(flat.numbers(cells))
    actions = [int(flat.action[c, a]) for c, a in zip(numbers, flat.arcs_of(numbers), strict=False)]
    return Way(worth(part_task(flat, None, 0, flat.T), numbers), numbers, tuple(actions))


def improve(flat: FlatSpace, way: Way, length: int, width: int, budget: Budget) -> Way:
    """Search parts of ``length`` steps again, from the last to the first, until none gains.

    A part that is as good but different is taken as well: it may let another part gain.
    """
    stale, turn = 0, 0
    while budget.spend(0):
        most = max(len(way.actions) - length, 0)
        stride = max(1, length // 3)
        firsts = sorted({*range(0, most, stride), most}, reverse=True)
        if stale >= len(firsts):
            break
        first = firsts[turn % len(firsts)]
        turn += 1
        task = part_task(flat, way, first, first + length)
        old = worth(task, way.cells[first : first + length + 1])
        found, _ = wide_beam(task, width, Way(old - 2 * flat.tol), budget)
        if not found.cells:
            stale += 1
            continue
        stale = 0 if found.value > old + flat.tol else stale + 1
        after = first + length if task.later else len(way.actions)
        way = Way(
            way.value + found.value - old,
            way.cells[:first] + found.cells + way.cells[after + 1 :],
            way.actions[:first] + found.actions + way.actions[after:],
        )
    return way
