"""The search keeps what is better, and nothing else."""

import pytest

from mobius.choreography.designs import DESIGNS, read_numbers
from mobius.errors import InvalidInput

cma = pytest.importorskip("cma", reason="install mobius[train]")

from mobius.choreography import search as searching  # noqa: E402


def _bowl(name: str, numbers: dict, seeds: object) -> float:
    """Least where both gains are 0.5 and 0.1."""
    return (numbers["k_p"] - 0.5) ** 2 + (numbers["k_d"] - 0.1) ** 2 + 1.0


def test_it_finds_better_numbers_within_their_ranges(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(searching, "cost_of", _bowl)
    design = DESIGNS["crawl_to_stand"]
    begin = read_numbers(design)
    seen: list[float] = []
    best, cost = searching.search(
        "crawl_to_stand",
        begin,
        seeds=range(2),
        seconds=1.0,
        workers=1,
        progress=lambda g, least, now: seen.append(least),
    )
    assert cost < _bowl("", begin, ())
    assert seen == sorted(seen, reverse=True)
    for key, (low, high, _) in design.ranges.items():
        assert low <= best[key] <= high


def test_numbers_that_cannot_be_built_cost_much_and_do_not_end_the_search():
    numbers = {**read_numbers(DESIGNS["crawl_to_stand"]), "hip_height": 0.9}
    assert searching.cost_of("crawl_to_stand", numbers, [0]) == searching.UNREACHABLE


def test_a_motion_without_numbers_cannot_be_searched():
    with pytest.raises(InvalidInput, match="nothing to search"):
        searching.search("prone_to_crawl", {}, seeds=[0], seconds=1.0)
