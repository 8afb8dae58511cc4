"""A scene simple enough to know the answer: a floor, and boxes on it."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.assets.things import Patch, rectangle
from footprints_edge_models.scenes.ground_truth.pixels import trace_ground_truth
from footprints_edge_models.scenes.layout.scene import Scene, Sky, Standpoint
from footprints_edge_models.scenes.rendering.cameras import Camera, looking
from footprints_edge_models.scenes.rendering.geometry import geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles

PLAIN = Material(TextureKey("blank", 0))
SIZE = (60, 80)


@pytest.fixture
def plain():
    return PLAIN


@pytest.fixture
def scene_of():
    """A scene with a floor of 20 x 20 m around the origin."""

    def build(*things, slope=(0.0, 0.0), ground=None):
        floor = Patch(rectangle(-10, -10, 10, 10), 0.0, PLAIN)
        sky = Sky(
            np.array([0.0, 0.0, 1.0]), (1, 1, 1), (1, 1, 1), (1, 1, 1), (0.2, 0.2, 0.2), 2.0,
            TextureKey("clouds", 0),
        )  # fmt: skip
        return Scene(
            "street",
            tuple(ground or (floor,)),
            tuple(things),
            (),
            sky,
            (0.5, 0.5, 0.5),
            (Standpoint(-1, -1, 1, 1),),
            slope,
        )

    return build


@pytest.fixture
def camera():
    """At the origin, 1.5 m up, looking along +y and 20 degrees down."""
    return Camera(
        np.array([0.0, 0.0, 1.5]),
        looking(np.pi / 2, np.radians(20), 0.0),
        Intrinsics.from_hfov(70, SIZE),
        SIZE,
    )


@pytest.fixture
def truth_for():
    def compute(scene, camera):
        geometry = geometry_of(scene)
        return trace_ground_truth(
            camera, geometry, Triangles(geometry.corners), Triangles(geometry.outlines)
        )

    return compute


@pytest.fixture(scope="session")
def library():
    return TextureLibrary("train")
