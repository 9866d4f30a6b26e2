"""Motions in physics, on drawn robots, without the stack."""

import pytest

from mobius.choreography.designs import DESIGNS, read_numbers
from mobius.choreography.rehearse import rehearse


@pytest.mark.parametrize("name", ["crawl_to_stand", "roll", "supine_to_crawl", "prone_to_crawl"])
def test_a_shipped_motion_ends_in_its_stance(name: str):
    design = DESIGNS[name]
    result = rehearse(design.build(read_numbers(design)), design.keyframe, seed=3)
    assert result.done
    assert result.pitch_error < 0.2
    assert result.height_error < 0.03
    assert result.cost < 0.6


def test_a_roll_that_does_not_throw_itself_back_is_stopped_and_costs_more():
    design = DESIGNS["roll"]
    numbers = read_numbers(design)
    lame = {**numbers, **{f"p0{j}": numbers[f"p3{j}"] for j in range(8)}, "a0": 150.0}
    result = rehearse(design.build(lame), design.keyframe, seed=3)
    assert not result.done
    assert result.progress < 1.0
    assert result.cost > 2.0
