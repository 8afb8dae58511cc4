"""A panorama whose sun and colours are known."""

import numpy as np
import pytest

from footprints_edge_models.scenes.layout.panoramas import colours_in, heading_of, panorama

ROWS = 256


class Pictures:
    """A blue sky, a grey ground, and a white sun at azimuth 90 degrees, elevation 30."""

    def panorama(self, key):
        picture = np.zeros((ROWS, 2 * ROWS, 3), np.uint8)
        picture[: ROWS // 2] = (90, 120, 160)
        picture[ROWS // 2 :] = 100
        if key == "sunny":
            row, column = round(ROWS * (0.5 - 30 / 180)), round(2 * ROWS * 90 / 360)
            picture[row - 6 : row + 6, column - 6 : column + 6] = 255
        return picture


def towards(azimuth, elevation):
    azimuth, elevation = np.radians(azimuth), np.radians(elevation)
    flat = np.cos(elevation)
    return np.array(
        [[np.cos(azimuth) * flat, np.sin(azimuth) * flat, np.sin(elevation)]], np.float32
    )


def test_the_sun_is_found_where_it_is():
    azimuth, elevation = panorama(Pictures(), "sunny").sun
    assert np.degrees(azimuth) == pytest.approx(90, abs=1.5)
    assert np.degrees(elevation) == pytest.approx(30, abs=1.5)
    assert panorama(Pictures(), "dull").sun is None


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_turned_sun_stands_where_its_light_comes_from(mirrored):
    seen, turn = panorama(Pictures(), "sunny"), 0.7
    heading = np.degrees(heading_of(seen.sun[0], turn, mirrored=mirrored))
    at_sun = colours_in(seen, towards(heading, 30), turn, mirrored=mirrored)
    beside = colours_in(seen, towards(heading + 20, 30), turn, mirrored=mirrored)
    assert at_sun.min() > 1 > beside.max()


def test_colours_above_and_below_the_horizon():
    seen = panorama(Pictures(), "dull")
    above, below = (colours_in(seen, towards(200, e), 0.0, mirrored=False)[0] for e in (5, -5))
    assert above == pytest.approx((np.array([90, 120, 160]) / 255) ** 2.2, abs=0.01)
    assert below == pytest.approx((100 / 255) ** 2.2, abs=0.01)
    assert seen.zenith == pytest.approx(above, abs=0.01)
    assert colours_in(seen, np.zeros((0, 3), np.float32), 0.0, mirrored=False).shape == (0, 3)
