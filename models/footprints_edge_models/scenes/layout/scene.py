"""A scene before it is rendered: ground, things, light, and where a camera may stand."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.library import TextureKey
from footprints_edge_models.scenes.assets.things import Patch, Thing, ThingPart

SceneKind: TypeAlias = Literal["rooms", "street"]
Colour: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True)
class Lamp:
    """A light of limited size.

    Attributes:
        centre_m: (x, y, z).
        size_m: its extent along x, y and z; shadows soften with it.
        power: light on a surface one metre away, facing it; white in ordinary light is 1.
    """

    centre_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    power: Colour


@dataclass(frozen=True)
class Backdrop:
    """A panorama around a scene.

    Attributes:
        panorama: its key in the pack of assets.
        turn: how far it is turned, radians.
        mirrored: whether left and right are swapped.
        tint: factors on its linear colours.
    """

    panorama: str
    turn: float
    mirrored: bool
    tint: Colour


@dataclass(frozen=True)
class Sky:
    """The sky and the horizon, and their light.

    Attributes:
        towards_sun: unit (3,).
        sun: light on a surface that faces the sun; zero on overcast days.
        zenith: colour above.
        horizon: colour at eye level.
        far: colour of hills, trees and houses at the horizon.
        far_deg: how high these reach.
        clouds: the texture that says where clouds are.
        backdrop: a panorama in place of the colours and clouds above.
    """

    towards_sun: NDArray[np.float64]
    sun: Colour
    zenith: Colour
    horizon: Colour
    far: Colour
    far_deg: float
    clouds: TextureKey
    backdrop: Backdrop | None = None


@dataclass(frozen=True)
class Standpoint:
    """A rectangle, in x and y, that a camera may stand in, and its weight in the draw.

    Attributes:
        x0, y0, x1, y1: the rectangle.
        weight: how often it is drawn.
        level_m: height of the ground there.
        heights_m: least and greatest height of a camera; None: those of the scene's kind.
        look_deg: as in :class:`Scene`, for this place.
        sights: what a camera there mostly looks at: (x, y), half of its width, height, in metres.
    """

    x0: float
    y0: float
    x1: float
    y1: float
    weight: float = 1.0
    level_m: float = 0.0
    heights_m: tuple[float, float] | None = None
    look_deg: tuple[float, ...] = ()
    sights: tuple[tuple[float, float, float, float], ...] = ()


@dataclass(frozen=True)
class Scene:
    """A scene without a camera.

    Attributes:
        kind: rooms or street.
        ground: the walkable patches, in the world.
        things: what stands there, placed.
        lamps: lights inside; none on streets.
        sky: the background.
        ambient: ambient light.
        standpoints: where a camera may be.
        slope: how much the ground rises along x and y; everything rises with it.
        haze_m: distance at which haze hides two thirds of a surface.
        look_deg: preferred headings of a camera, degrees from +x anticlockwise; empty = any.
        floors: walkable surfaces of any shape, in the world; their triangles look up.
        kerbs: the sides of floors.
        world: key of the world that it stands in; empty if it stands in none.
    """

    kind: SceneKind
    ground: tuple[Patch, ...]
    things: tuple[Thing, ...]
    lamps: tuple[Lamp, ...]
    sky: Sky
    ambient: Colour
    standpoints: tuple[Standpoint, ...]
    slope: tuple[float, float] = (0.0, 0.0)
    haze_m: float = 1e6
    look_deg: tuple[float, ...] = ()
    floors: tuple[ThingPart, ...] = ()
    kerbs: tuple[ThingPart, ...] = ()
    world: str = ""

    def assets(self) -> tuple[str, ...]:
        """Keys of the models, worlds, textures and panoramas that the scene is made of."""
        parts = [part for thing in self.things for part in thing.parts]
        materials = [part.material for part in (*parts, *self.floors, *self.kerbs)]
        materials += [patch.material for patch in self.ground]
        backdrop = self.sky.backdrop.panorama if self.sky.backdrop else ""
        used = {material.texture.picture for material in materials}
        used |= {thing.asset for thing in self.things} | {backdrop, self.world}
        return tuple(sorted(used - {""}))
