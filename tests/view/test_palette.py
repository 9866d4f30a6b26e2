"""Every mode has a colour of its own."""

from mobius.types import Mode
from mobius.view.palette import MODE_COLOURS, rgb


def test_every_mode_has_its_own_colour():
    assert set(MODE_COLOURS) == set(Mode)
    assert len(set(MODE_COLOURS.values())) == len(Mode)


def test_a_colour_is_three_shares_of_255():
    assert rgb("#ff8000") == (1.0, 128 / 255, 0.0)
