"""Meshes as trimesh reads them, turned into surfaces."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge_models.asset_files.asset import (
    LONGEST_TEXTURE_PX,
    AssetError,
    Surface,
    upright,
)

_GREY = (180, 180, 180)


def check_mesh(mesh: object, points: NDArray[np.floating], source: str) -> None:
    """Refuses a mesh whose numbers lead nowhere: code in C++ would follow them.

    Args:
        mesh: A `trimesh.Trimesh`.
        points: (P, 3), its vertices.
        source: What the message calls it.

    Raises:
        AssetError: If a triangle names a vertex that is not there, or one has no place.
    """
    faces = np.asarray(mesh.faces)  # type: ignore[attr-defined]
    if len(faces) and (faces.min() < 0 or faces.max() >= len(points)):
        raise AssetError(f"{source}: a triangle of vertex {faces.max()}, there are {len(points)}")
    if not np.isfinite(points).all():
        raise AssetError(f"{source}: a vertex is not at a finite place")


def surfaces_of(
    mesh: object,
    points: NDArray[np.floating],
    *,
    rgb: tuple[int, int, int] | None = None,
    has_alpha: bool = False,
    role: str = "object",
    name: str = "",
) -> Iterator[Surface]:
    """The surface of one trimesh mesh; none if it has no triangle.

    Args:
        mesh: A `trimesh.Trimesh`.
        points: (P, 3), its vertices where they shall be, metres, y up.
        rgb: Its colour, if the source states it apart from the file.
        has_alpha: Whether its texture's alpha cuts holes.
        role: Role of the surface.
        name: Name of the surface.
    """
    faces = np.asarray(mesh.faces, np.int32)  # type: ignore[attr-defined]
    if not len(faces):
        return
    visual = mesh.visual  # type: ignore[attr-defined]
    uv = getattr(visual, "uv", None)
    image, colour = _material(getattr(visual, "material", None))
    texture = alpha = None
    if image is not None and uv is not None and len(uv) == len(points):
        texture, alpha = _pixels(image, has_alpha=has_alpha)
        # Readers disagree on whether a colour beside a texture counts; photos of it do not.
        colour = (255, 255, 255)
    coordinates = np.zeros((len(points), 2), np.float32)
    if texture is not None:
        coordinates = np.asarray(uv, np.float32)
    yield Surface(upright(points), faces, coordinates, rgb or colour, texture, alpha, role, name)


def _material(material: object) -> tuple[Image.Image | None, tuple[int, int, int]]:
    """The texture and the colour of a trimesh material."""
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    colour = getattr(material, "baseColorFactor", None)
    if colour is None:
        colour = getattr(material, "diffuse", None)
    if colour is None:
        return image, _GREY
    values = np.asarray(colour, np.float64)[:3]
    if values.max() <= 1 and np.asarray(colour).dtype.kind == "f":
        values = values * 255
    red, green, blue = (round(min(max(float(value), 0.0), 255.0)) for value in values)
    return image, (red, green, blue)


def _pixels(
    image: Image.Image, *, has_alpha: bool
) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    """A texture, no longer than `LONGEST_TEXTURE_PX`, and where it is opaque."""
    kept = image.convert("RGBA" if has_alpha else "RGB")
    kept.thumbnail((LONGEST_TEXTURE_PX, LONGEST_TEXTURE_PX))
    pixels = np.asarray(kept, np.uint8)
    return pixels[..., :3], pixels[..., 3] > 127 if has_alpha else None
