"""3D models from files in place of things built from parts.

A maker of furniture or vehicles is wrapped by :func:`or_model`: where the scene's library has
models, most of its things are models of the same kind and about the same size. Everything else,
where things stand and which way they look, stays as it is.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import Concatenate, ParamSpec, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Asset, Surface
from footprints_edge_models.asset_files.pack import PackEntry
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.pack_part import PackPart
from footprints_edge_models.scenes.assets.shapes import Shape
from footprints_edge_models.scenes.assets.textures.library import TextureKey
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
)
from footprints_edge_models.scenes.vectors import cross

MODELS_SHARE = 0.85
"""Share of things that are models, where a fitting one is known."""
SAME_AGAIN = 0.6
"""Share of things that are the same model as the last of their kind: sets of chairs."""
LARGEST_FACTOR = 1.6
"""A model is taken for a thing whose sides differ by less than this factor."""

SITTING = "sitting "
"""Names of people that no standing thing may become: without their chair they sit in the air."""

_MOST_LOADED = 400
_SMOOTH = np.cos(np.radians(40))

Params = ParamSpec("Params")
Maker = Callable[Concatenate[Palette, Params], Thing]


class ModelLibrary(PackPart):
    """The models of a pack that belong to one split."""

    @cached_property
    def _entries(self) -> dict[str, PackEntry]:
        return {entry.key: entry for entry in self._pack.of("model", self.split)}

    @cached_property
    def _found(self) -> "dict[tuple[tuple[str, ...], bool], _Named]":
        return {}

    def matching(
        self, words: Sequence[str], size_m: NDArray[np.floating], *, stands: bool
    ) -> list[PackEntry]:
        """Models whose name has one of these words, of about this (width, depth, height).

        Args:
            words: Any of them.
            size_m: The size.
            stands: Whether they take ground, or hang on a wall.
        """
        named = self._named(tuple(words), stands)
        away = np.abs(np.log(named.sizes_m / size_m)).max(axis=1)
        return [named.entries[k] for k in np.flatnonzero(away < np.log(LARGEST_FACTOR))]

    def _named(self, words: tuple[str, ...], stands: bool) -> "_Named":
        if (words, stands) not in self._found:
            entries = [
                entry
                for entry in self._entries.values()
                if entry.stands == stands
                and any(word in f" {entry.name.lower()} " for word in words)
                and not entry.name.lower().startswith(SITTING)
            ]
            sizes_m = np.array([entry.size_m for entry in entries]).reshape(-1, 3)
            self._found[words, stands] = _Named(entries, np.maximum(sizes_m, 0.02))
        return self._found[words, stands]

    def thing(self, entry: PackEntry, label: str) -> Thing:
        """A model as a thing."""
        made = self._load(entry.key).thing
        return Thing(label, made.parts, made.outlines, asset=entry.key)

    def texture(self, key: TextureKey) -> NDArray[np.uint8]:
        """The texture of a model's surface, uint8 (SIDE_PX, SIDE_PX, 3), RGB."""
        return self._load(key.kind.removeprefix("model:")).textures[key.number]

    def _load(self, key: str) -> "_Loaded":
        def load() -> _Loaded:
            return _Loaded.from_asset(self._pack.model(self._entries[key]))

        return self._keep(key, load, _MOST_LOADED)


@dataclass(frozen=True)
class _Named:
    """Models of some names, and their sizes (N, 3), as (width, depth, height)."""

    entries: list[PackEntry]
    sizes_m: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Loaded:
    """A model that is in memory: the thing, and the textures of its surfaces by their number."""

    thing: Thing
    textures: dict[int, NDArray[np.uint8]]

    @classmethod
    def from_asset(cls, asset: Asset) -> "_Loaded":
        """A model of a pack."""
        pictures = [surface.texture for surface in asset.surfaces]
        distinct = {id(picture): picture for picture in pictures if picture is not None}
        numbers = {key: number for number, key in enumerate(distinct)}
        textures = {
            numbers[key]: np.asarray(
                cv2.resize(picture, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA), np.uint8
            )
            for key, picture in distinct.items()
        }
        parts = tuple(
            ThingPart(
                _shape(surface),
                np.eye(3, 4),
                _material(asset.key, number, surface, numbers.get(id(surface.texture), -1)),
            )
            for number, surface in enumerate(asset.surfaces)
            if surface.alpha is None  # leaves with holes are left to the built trees
        )
        return cls(Thing(asset.name, parts, asset.outlines), textures)


def or_model(*words: str) -> Callable[[Maker[Params]], Maker[Params]]:
    """Wraps a maker: most of its things become models whose names have one of these words."""

    def wrap(make: Maker[Params]) -> Maker[Params]:
        @wraps(make)
        def made(palette: Palette, *args: Params.args, **kwargs: Params.kwargs) -> Thing:
            thing = make(palette, *args, **kwargs)
            library = palette.library.models
            if not isinstance(library, ModelLibrary) or palette.rng.random() > MODELS_SHARE:
                return thing
            return _in_place_of(thing, words, library, palette)

        return cast("Maker[Params]", made)

    return wrap


def _in_place_of(
    thing: Thing, words: Sequence[str], library: ModelLibrary, palette: Palette
) -> Thing:
    low, high = thing.extent
    stands = bool(thing.footprints())
    fitting = library.matching(words, np.maximum(high - low, 0.02), stands=stands)
    if not fitting:
        return thing
    last = palette.last_models.get(thing.label)
    if last is not None and last in fitting and palette.rng.random() < SAME_AGAIN:
        return library.thing(last, thing.label)
    entry = fitting[int(palette.rng.integers(len(fitting)))]
    palette.last_models[thing.label] = entry
    return library.thing(entry, thing.label)


def _shape(surface: Surface) -> Shape:
    uv = surface.uv[surface.triangles] * np.array([1, -1], np.float32)
    return Shape(
        surface.points[surface.triangles],
        smooth_normals(surface),
        convex=False,
        uv=uv,
        mesh=(surface.points.astype(np.float64), surface.triangles),
    )


def smooth_normals(surface: Surface) -> NDArray[np.float32]:
    """Unit normals at the corners (T, 3, 3): smooth where faces meet at less than 40 degrees."""
    corners = surface.points[surface.triangles].astype(np.float64)
    flat = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # points on texture seams are several: those within a tenth of a millimetre are one
    x, y, z = np.round((surface.points.T.astype(np.float64) + 100) * 1e4).astype(np.int64)
    _, same = np.unique((x << 42) + (y << 21) + z, return_inverse=True)
    where = same.reshape(-1)[surface.triangles]
    sums = np.zeros((int(same.max()) + 1, 3))
    for axis in range(3):
        sums[:, axis] = np.bincount(where.ravel(), np.repeat(flat[:, axis], 3))
    smooth = _unit(sums)[where]
    face = _unit(flat)[:, None].repeat(3, axis=1)
    alike = (smooth * face).sum(axis=-1) > _SMOOTH
    return np.where(alike[..., None], smooth, face).astype(np.float32)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vectors / np.maximum(
        np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12
    )
    return unit


def _material(key: str, number: int, surface: Surface, texture: int) -> Material:
    """Its own texture, or its colour; a little gloss on some, by the model's name."""
    linear = (np.array(surface.rgb) / 255) ** 2.2
    gloss = (0.0, 0.0, 0.04, 0.1)[_hash(key, number) % 4]
    if surface.texture is not None:
        red, green, blue = (float(value) for value in linear)
        return Material(TextureKey(f"model:{key}", texture), 1.0, (red, green, blue), gloss)
    red, green, blue = (float(value) for value in linear / 0.8**2.2)  # of the blank's grey
    return Material(TextureKey("blank", 2), 1.0, (red, green, blue), gloss)


def _hash(key: str, number: int) -> int:
    """The same number for the same surface in every process."""
    return sum(key.encode()) + 7 * number
