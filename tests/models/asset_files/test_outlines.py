"""Outlines against areas in closed form."""

import numpy as np
import pytest

from footprints_edge_models.asset_files.asset import Surface
from footprints_edge_models.asset_files.outlines import outlines_of

BOX = [(0, 1, 2), (1, 3, 2), (4, 6, 5), (5, 6, 7), (0, 4, 1), (1, 4, 5)]
BOX += [(2, 3, 6), (3, 7, 6), (0, 2, 4), (2, 6, 4), (1, 5, 3), (3, 5, 7)]


def box(x0, y0, z0, x1, y1, z1):
    points = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)])
    triangles = np.array(BOX, np.int32)
    return Surface(points.astype(np.float32), triangles, np.zeros((8, 2), np.float32), (9, 9, 9))


def area_m2(outlines):
    def shoelace(ring):
        x, y = ring.T
        return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2

    return sum(map(shoelace, outlines))


def covers(outlines, x, y):
    return any(
        ring[:, 0].min() <= x <= ring[:, 0].max() and ring[:, 1].min() <= y <= ring[:, 1].max()
        for ring in outlines
    )


def test_a_box_takes_its_base():
    outlines = outlines_of([box(-0.5, -0.3, 0, 0.5, 0.3, 0.8)], "Bedroom")
    assert area_m2(outlines) == pytest.approx(0.6, rel=0.08)


def test_a_table_takes_its_legs_alone():
    legs = [
        box(x - 0.03, y - 0.03, 0, x + 0.03, y + 0.03, 0.7)
        for x in (-0.6, 0.6)
        for y in (-0.4, 0.4)
    ]
    outlines = outlines_of([*legs, box(-0.7, -0.5, 0.7, 0.7, 0.5, 0.75)], "Living room")
    assert area_m2(outlines) == pytest.approx(4 * 0.06**2, rel=0.8)  # cells are 2 cm
    assert covers(outlines, 0.6, 0.4) and not covers(outlines, 0, 0)


def test_a_leaning_triangle_takes_what_is_below_the_height():
    # rises from z = 0 at y = 0 to z = 0.7 at y = 1: below 0.35 m up to y = 0.5
    points = np.array([(-0.5, 0, 0), (0.5, 0, 0), (-0.5, 1, 0.7), (0.5, 1, 0.7)], np.float32)
    ramp = Surface(points, np.array([(0, 1, 2), (1, 3, 2)], np.int32), points[:, :2], (9, 9, 9))
    outlines = outlines_of([ramp], "Miscellaneous")
    assert max(ring[:, 1].max() for ring in outlines) == pytest.approx(0.5, abs=0.03)


def test_ground_inside_of_a_thing_is_taken_and_a_large_yard_is_not():
    def frame(side):
        return [
            box(-side, -side, 0, side, -side + 0.05, 0.5),
            box(-side, side - 0.05, 0, side, side, 0.5),
            box(-side, -side, 0, -side + 0.05, side, 0.5),
            box(side - 0.05, -side, 0, side, side, 0.5),
        ]

    assert covers(outlines_of(frame(0.3), "Bathroom"), 0, 0)
    assert not covers(outlines_of(frame(1.5), "Exterior"), 0, 0)


def test_a_car_takes_the_ground_below_its_body():
    wheels = [box(x, y, 0, x + 0.2, y + 0.6, 0.6) for x in (-0.9, 0.7) for y in (-1.8, 1.2)]
    outlines = outlines_of([*wheels, box(-0.9, -2.2, 0.4, 0.9, 2.2, 1.5)], "car")
    assert area_m2(outlines) == pytest.approx(1.8 * 4.4, rel=0.05)


def test_what_hangs_on_a_wall_takes_nothing():
    assert outlines_of([box(0, 0, 1.2, 0.5, 0.2, 1.6)], "Bathroom") == []
