"""A raster knows where its pixels are."""

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.world.occupancy import OccupancyMap


def raster(yaw=0.0, shape=(3, 4)):
    return OccupancyMap("test", np.zeros(shape, int), 0.5, np.array([1.0, 2.0, yaw]))


def test_pixels_and_points_are_inverse_at_any_yaw():
    for yaw in (0.0, 0.4, -2.0, np.pi):
        m = raster(yaw)
        rows, cols = np.indices(m.shape)
        assert np.array_equal(m.pixel_of(m.pixel_centers()), np.stack([rows, cols], axis=-1))


def test_local_and_map_frames_are_inverse():
    m, xy = raster(0.7), np.array([[0.1, 0.2], [-3.0, 4.0]])
    assert np.allclose(m.to_map(m.to_local(xy)), xy)


def test_a_yaw_of_a_quarter_turn_turns_the_raster_about_its_lower_left_corner():
    # pixel (row 0, col 2) has its centre at (1.25, 0.25) m of the raster; turned by +90 deg
    # that is (-0.25, 1.25), and the corner stands at (1, 2)
    m = raster(np.pi / 2)
    assert np.allclose(m.pixel_centers()[0, 2], [0.75, 3.25])
    assert m.pixel_of([0.75, 3.25]).tolist() == [0, 2]


def test_half_full_is_an_obstacle_and_unknown_is_not():
    m = OccupancyMap("test", np.array([[-1, 0, 49, 50, 100]]), 1.0, np.zeros(3))
    assert m.occupied.tolist() == [[False, False, False, True, True]]
    assert m.unknown.tolist() == [[True, False, False, False, False]]


def test_a_pixel_is_named_as_an_image_editor_does():
    assert raster().describe_pixel((0, 3)) == "pixel column 3, row 2 from the top"


def test_a_map_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        raster().occupancy[0, 0] = 5


@pytest.mark.parametrize("values", [np.zeros((0, 3)), np.array([[101]]), np.array([[-2]])])
def test_values_that_are_no_occupancy_are_refused(values):
    with pytest.raises(InvalidInput, match="occupancy"):
        OccupancyMap("test", values, 0.05, np.zeros(3))


@pytest.mark.parametrize("resolution", [0.0, -0.05, np.nan, np.inf])
def test_a_resolution_that_is_no_length_is_refused(resolution):
    with pytest.raises(InvalidInput, match="resolution"):
        OccupancyMap("test", np.zeros((2, 2)), resolution, np.zeros(3))
