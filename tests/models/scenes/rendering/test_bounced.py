"""Light that comes from the sky and from walls."""

from dataclasses import replace

import numpy as np
import pytest

from footprints_edge_models.scenes.assets.things import box, joined
from footprints_edge_models.scenes.rendering.geometry import geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.rendering.shading.bounced import SecondLight, sky_table
from footprints_edge_models.scenes.rendering.shading.surfaces import material_table


@pytest.fixture
def second_light(scene_of, library):
    def build(*things):
        scene = scene_of(*things)
        scene = replace(scene, sky=replace(scene.sky, sun=(0, 0, 0), zenith=(0.5, 0.5, 1.0)))
        geometry = geometry_of(scene)
        materials = material_table(geometry, library, np.arange(len(geometry.materials)))
        solids = Triangles(geometry.points, geometry.triangles)
        return SecondLight(scene, geometry, materials, solids, sky_table(scene, library))

    return build


def column(*values):
    return np.array(values, np.float32)[:, None]


def test_a_ray_into_the_open_brings_the_sky(second_light):
    *light, near = second_light().along(column(0, 0, 0.01), column(0, 0, 1), [])[:, 0]
    assert light[2] > 1.2 * light[0] > 0
    assert near == 0


def test_a_ray_at_a_red_wall_brings_red_light_and_less_of_it_close_by(second_light, plain):
    red = replace(plain, tint=(1.0, 0.1, 0.1))
    wall = joined("wall", [box(red, (4, 0.2, 3), (0, 2, 0))], is_wall=True)
    light = second_light(wall)
    far, close = (light.along(column(0, y, 0.5), column(0, 1, 0), [])[:, 0] for y in (0, 1.85))
    assert far[0] > 5 * far[1] > 0
    assert close[0] < 0.5 * far[0]
    assert close[3] > 0.8 and far[3] == 0
