"""An asset read from files: its surfaces in metres, what it is, and whom to credit.

Axes are those of scenes: x and y along the ground, z up, metres. Sources state y up; a point
(x, y, z) of theirs is (x, -z, y) here, so that a front along +z looks along -y.
"""

import re
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError

LONGEST_TEXTURE_PX = 512
"""Larger textures are reduced: no picture shows more of them."""


_FREE = re.compile(r"CC0|CC-BY-\d|MIT|Apache|BSD")


class AssetError(FootprintsError):
    """An asset, or a folder of assets, cannot be used."""


@dataclass(frozen=True)
class Credit:
    """Whom to credit for an asset.

    Attributes:
        title: What it is called.
        author: Who made it.
        licence: SPDX-like identifier, such as `CC-BY-3.0`.
        source: Where it comes from.
    """

    title: str
    author: str
    licence: str
    source: str


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of one material.

    Attributes:
        points: float32 (P, 3), metres.
        triangles: int32 (T, 3), indices into `points`.
        uv: float32 (P, 2), in repeats of the texture, v up; zeros where there is no texture.
        rgb: sRGB colour, 0 to 255; factor on the texture where there is one.
        texture: uint8 (H, W, 3), sRGB, row 0 at v = 1; None for a plain colour.
        alpha: bool (H, W), where the texture is opaque; None where all of it is.
        role: `floor`, `wall`, `object` or `stairs`.
        name: Of its node, where there are several.
    """

    points: NDArray[np.float32] = field(repr=False)
    triangles: NDArray[np.int32] = field(repr=False)
    uv: NDArray[np.float32] = field(repr=False)
    rgb: tuple[int, int, int]
    texture: NDArray[np.uint8] | None = field(default=None, repr=False)
    alpha: NDArray[np.bool_] | None = field(default=None, repr=False)
    role: str = "object"
    name: str = ""


@dataclass(frozen=True, eq=False)
class Asset:
    """One thing that can be placed: it stands on z = 0, centred on x and y.

    Attributes:
        key: Unique name, from its file and its place in it.
        name: What it is, in words.
        category: Group that its source puts it in, such as `Bedroom` or `car`.
        size_m: (width, depth, height) along x, y and z.
        surfaces: Its triangles by material.
        credit: Whom to credit.
        outlines: Convex outlines (K, 2) of the ground that it takes.
    """

    key: str
    name: str
    category: str
    size_m: tuple[float, float, float]
    surfaces: tuple[Surface, ...]
    credit: Credit
    outlines: tuple[NDArray[np.float64], ...] = ()

    def lengthwise(self) -> "Asset":
        """It, its longer side along y: turned by a quarter if need be. It has no outlines yet."""
        width, depth, height = self.size_m
        if width <= depth:
            return self
        turned = tuple(
            replace(each, points=each.points[:, [1, 0, 2]] * np.array([-1, 1, 1], np.float32))
            for each in self.surfaces
        )
        return replace(self, size_m=(depth, width, height), surfaces=turned)


def free_licence(stated: str) -> str:
    """A licence as an index states it.

    Raises:
        AssetError: It is none of those that allow anyone to use and pass on what carries it.
    """
    if not _FREE.match(stated):
        raise AssetError(
            f"licence {stated!r} is none of CC0, CC BY, MIT, Apache and BSD; assets under others "
            "are not used, because weights trained on them could not be shipped"
        )
    return stated


def upright(points: NDArray[np.floating]) -> NDArray[np.float32]:
    """Points (..., 3) of a source with y up, in the axes of scenes."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1).astype(np.float32)
