"""Where a room repeats a number of the paper, it is the paper's number."""

from math import radians

import pytest

from mobius import paper
from mobius.types import Mode


def test_the_planners_speeds_energies_and_steps_are_those_of_tables_iv_to_vi():
    from mobius.plan.actions import STEP_LENGTHS
    from mobius.plan.energy import J_PER_CELL, MAX_SPEED

    assert dict(MAX_SPEED) == dict(paper.MAX_SPEED)
    for mode, row in paper.TABLE_VI_SINGLE.items():
        assert J_PER_CELL[Mode(mode)] == row.energy
        assert STEP_LENGTHS[Mode(mode)] == tuple(d for d in paper.STEPS[mode] if d > 0)


def test_the_model_weighs_what_the_third_version_prints():
    from mobius.model import dimensions as dim

    assert pytest.approx(paper.MASS_V3) == dim.ROBOT_MASS


def test_the_policys_action_scale_sizes_and_commands_are_those_of_table_i_and_sec_iv_a():
    from mobius.control.action import ACTION_SCALE
    from mobius.control.bodies import body_of
    from mobius.control.observation import Layout

    crawl, size = body_of("crawl"), paper.OBSERVATION["crawl"]
    layout = Layout(kind="paper", actions=len(crawl.joints), history=size.history + 1)
    assert (layout.frame_size, layout.size) == (size.frame, size.printed_total)
    assert crawl.command_high[0] >= paper.MAX_SPEED["crawl"]
    assert crawl.command_high[2] >= paper.MAX_YAW_RATE["crawl"]
    assert paper.TABLE_I.action_scale == ACTION_SCALE


def test_training_has_every_reward_of_table_ii():
    from mobius.train.rewards import TERMS

    assert set(paper.TABLE_II.terms) <= set(TERMS)


def test_training_draws_the_noise_of_table_iii_where_it_does_not_say_otherwise():
    from mobius.train.presets import Randomisation

    ours, table = Randomisation(), paper.TABLE_III
    assert ours.orientation == pytest.approx(radians(table.orientation.high), abs=1e-4)
    assert ours.angular_velocity == table.yaw_rate.high
    assert ours.linear_velocity == table.linear_velocity.high
    assert ours.delay_chance == table.delay_probability
    assert ours.friction == (table.friction.low, table.friction.high)
