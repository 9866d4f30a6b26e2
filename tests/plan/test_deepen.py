"""The searches over arrays: exact where nothing is cut off, honest where something is."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
import pytest

from mobius.plan import RECONSTRUCTED_WEIGHTS, Problem, check, solve
from mobius.plan.bounds import build_arcs, capacity_bound, dp_bound
from mobius.plan.check import objective_of
from mobius.plan.deepen import Deepening
from mobius.plan.flatspace import FlatSpace, treats
from mobius.plan.ng import ShortMemory
from mobius.plan.search import Budget, Found, Space, beam, path_of
from mobius.plan.stretches import improve, known_way, part_task, whole_task, worth
from mobius.plan.wide import Way, wide_beam
from mobius.types import GridMap

ENDLESS = 2**60


def space_of(p: Problem) -> Space:
    arcs = build_arcs(p)
    return Space(p, arcs, dp_bound(p, arcs))


def optimum(space: Space) -> Found:
    """By the search state by state, nothing cut off."""
    found, cut = beam(space, ENDLESS, Found(-np.inf, None), Budget(ENDLESS, None))
    assert cut == -np.inf
    return found


@pytest.fixture(scope="module", params=[False, True], ids=["still", "moving"])
def small_problems(request, random_problem) -> list[tuple[Problem, Space, Found]]:
    """Problems that have a plan, with their space and their optimum."""
    made = []
    for seed in range(60):
        p = random_problem(np.random.default_rng([seed, 5]), moving=request.param)
        space = space_of(replace(p, horizon=5))
        if space.root > -np.inf:
            made.append((space.problem, space, optimum(space)))
        if len(made) == 15:
            break
    return made


def saturated(seed: int, side: int = 6, T: int = 26) -> Problem:
    """About as many steps as cells: every bound of the easy searches is far off."""
    rng = np.random.default_rng(seed)
    blocked = rng.random((side, side)) < 0.12
    blocked[0, 0] = blocked[-1, -1] = False
    grid = GridMap("saturated", 0.5, np.zeros(3), blocked, np.full((side, side), 7))
    return Problem(grid, (0, 0), (side - 1, side - 1), T, weights=RECONSTRUCTED_WEIGHTS)


def value(flat: FlatSpace, way: Way) -> float:
    """The objective of a way by the checker's own arithmetic."""
    cells, actions = path_of(flat.link(way.cells, way.actions))
    p = flat.space.problem
    modes = [p.actions[a].mode for a in actions]
    return objective_of(p, [flat.space.arcs.cell(f) for f in cells], modes)


def test_the_arrays_hold_the_same_bound_table(small_problems):
    for _, space, _ in small_problems:
        flat = FlatSpace.of(space)
        table = whole_task(flat).table
        assert table[0] == pytest.approx(flat.row(0))
        for k in range(space.T + 1):
            assert table[k, 0] == pytest.approx(flat.row(k)[0])


def test_a_beam_wide_enough_finds_the_optimum(small_problems):
    for _, space, best in small_problems:
        flat = FlatSpace.of(space)
        way, cut = wide_beam(whole_task(flat), 10**6, Way(-np.inf), Budget(ENDLESS, None))
        assert cut == -np.inf
        assert way.value == pytest.approx(best.value)
        assert value(flat, way) == pytest.approx(best.value)


@pytest.mark.parametrize("width", [1, 3, 20])
def test_what_a_narrow_beam_leaves_out_is_bounded(width, small_problems):
    for _, space, best in small_problems:
        task = whole_task(FlatSpace.of(space))
        way, cut = wide_beam(task, width, Way(-np.inf), Budget(ENDLESS, None), compact=0.1)
        assert way.value <= best.value + 1e-9
        assert max(way.value, cut) >= best.value - 1e-9


@pytest.mark.parametrize("width", [2, 10**6])
def test_the_short_memory_bounds_every_plan_and_ends_at_the_optimum(width, small_problems):
    solved = 0
    for _, space, best in small_problems:
        memory = ShortMemory(whole_task(FlatSpace.of(space)))
        memory.memory[:] = memory.task.begin  # nothing is remembered at first
        bound, known = space.root, -1e9
        for _ in range(100):
            lower, way = memory.step(bound, known, Budget(ENDLESS, None), width)
            assert best.value - 1e-6 <= lower <= bound
            bound = lower
            if way is not None:
                assert value(memory.task.flat, way) == pytest.approx(way.value)
                known = max(known, way.value)
            if memory.stuck or bound <= best.value + 1e-6:
                break
        if width > 2 and not memory.stuck:
            solved += bound == pytest.approx(best.value, abs=1e-5)
    assert solved > 0.8 * len(small_problems) or width == 2


def test_windows_make_a_plan_better_and_leave_it_legal(small_problems):
    gained = 0
    for p, space, best in small_problems:
        flat = FlatSpace.of(space)
        first, _ = beam(space, 1, Found(-np.inf, None), Budget(ENDLESS, None))
        if first.link is None:
            continue
        way = known_way(flat, path_of(first.link)[0])
        better = improve(flat, way, 3, 50, Budget(ENDLESS, None))
        assert value(flat, better) == pytest.approx(better.value)
        assert way.value - 1e-9 <= better.value <= best.value + 1e-9
        gained += better.value > way.value
        whole = improve(flat, way, p.horizon, 10**6, Budget(ENDLESS, None))
        assert whole.value == pytest.approx(best.value)
    assert gained


def test_the_parts_of_a_path_are_worth_what_the_whole_is():
    flat = FlatSpace.of(space_of(saturated(0)))
    way, _ = wide_beam(whole_task(flat), 8, Way(-np.inf), Budget(ENDLESS, None))
    assert worth(whole_task(flat), way.cells) == pytest.approx(way.value)
    part = part_task(flat, way, 5, 12)
    shuffled, _ = wide_beam(part, 4, Way(-np.inf), Budget(ENDLESS, None))
    other = replace(
        way,
        cells=way.cells[:5] + shuffled.cells + way.cells[13:],
        actions=way.actions[:5] + shuffled.actions + way.actions[12:],
    )
    change = shuffled.value - worth(part, way.cells[5:13])
    assert value(flat, other) == pytest.approx(way.value + change)


def test_deepening_from_a_bad_plan_ends_at_the_optimum(small_problems):
    for _, space, best in small_problems:
        first, _ = beam(space, 1, Found(-np.inf, None), Budget(ENDLESS, None))
        if first.link is None:
            continue
        flat = FlatSpace.of(space)
        way = known_way(flat, path_of(first.link)[0])
        found, bound = Deepening(flat, way, space.root, Budget(ENDLESS, None)).run()
        assert (found.value, bound) == pytest.approx((best.value, best.value))


@pytest.mark.parametrize("seed", range(2))
def test_a_saturated_map_is_solved_up_to_its_capacity(seed):
    p = saturated(seed)
    plan = solve(p, deadline_s=None, max_states=50_000)
    check(p, plan)
    assert plan.bound <= capacity_bound(p, build_arcs(p)) < space_of(p).root
    assert plan.gap <= 0.03 * plan.bound


@pytest.mark.parametrize("max_states", [3_000, 12_000])
def test_a_hard_map_gives_the_same_plan_bit_for_bit(max_states):
    one, two = (solve(saturated(1), deadline_s=None, max_states=max_states) for _ in range(2))
    assert one.cells.tobytes() == two.cells.tobytes()
    assert (one.modes, one.status, one.objective, one.bound) == (
        two.modes,
        two.status,
        two.objective,
        two.bound,
    )


def test_more_states_never_give_less():
    p = saturated(2, side=7, T=26)
    plans = [solve(p, deadline_s=None, max_states=n) for n in (1_000, 8_000, 25_000)]
    for plan in plans:
        check(p, plan)
    objectives, bounds = [x.objective for x in plans], [x.bound for x in plans]
    assert objectives == sorted(objectives)
    assert bounds == sorted(bounds, reverse=True)


@pytest.mark.parametrize("deadline_s", [0.05, 0.15, 0.4])
def test_a_deadline_that_cuts_the_search_leaves_an_honest_bound(deadline_s):
    p = saturated(3, side=8, T=40)
    plan = solve(p, deadline_s=deadline_s, max_states=10**9)
    check(p, plan)
    best = solve(p, deadline_s=None, max_states=15_000)
    assert plan.bound >= best.objective


def test_the_caller_hears_of_progress():
    flat = FlatSpace.of(space_of(saturated(1)))
    first, _ = beam(flat.space, 1, Found(-np.inf, None), Budget(ENDLESS, None))
    way, heard = known_way(flat, path_of(first.link)[0]), []
    budget = Budget(20_000, time.perf_counter())
    found, bound = Deepening(
        flat, way, flat.space.root, budget, tell=lambda *got: heard.append(got)
    ).run()
    assert heard[-1] == (found.value, bound)
    assert [v for v, _ in heard] == sorted(v for v, _ in heard)


def test_an_option_the_arrays_do_not_know_is_left_to_the_other_search():
    @dataclass(frozen=True, eq=False)
    class WithMore(Problem):
        wind: float | None = None

    p = saturated(0)
    args = {name: getattr(p, name) for name in ("grid", "start", "goal", "horizon")}
    assert treats(WithMore(**args))
    calm, windy = WithMore(**args), WithMore(**args, wind=1.0)
    assert FlatSpace.of(space_of(calm)) is not None
    assert FlatSpace.of(space_of(windy)) is None
    plan = solve(windy, deadline_s=None, max_states=3_000)
    check(windy, plan)
