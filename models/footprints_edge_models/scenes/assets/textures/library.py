"""The library of textures: procedural patterns and crops of photos.

Every texture is a square that tiles. A library holds a fixed number of each kind. Each is drawn
from its own seed, so that every process draws the same. The seeds of the two splits are
disjoint, and a photo belongs to one split by a checksum of its bytes: no texture of the test
scenes is seen in training.
"""

import zlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Literal, Protocol, TypeAlias, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX, Rng
from footprints_edge_models.scenes.assets.textures.patterns import PATTERNS
from footprints_edge_models.scenes.assets.textures.photographed import PackPictures

SceneSplit: TypeAlias = Literal["train", "test"]
SPLITS: tuple[SceneSplit, ...] = get_args(SceneSplit)
VARIANTS = 60
"""How many textures of each procedural kind a split has."""
TEST_PHOTOS = 8
"""One photo in this many belongs to the test split."""


@dataclass(frozen=True)
class TextureKey:
    """One texture of a library.

    Attributes:
        kind: Kind of procedural texture, or ``photo``.
        number: Its number.
        picture: Key of a photographed texture that stands for the kind; the number is its variant.
    """

    kind: str
    number: int
    picture: str = ""


class TexturedModels(Protocol):
    """What knows the textures of 3D models."""

    def texture(self, key: TextureKey) -> NDArray[np.uint8]:
        """A texture, uint8 (SIDE_PX, SIDE_PX, 3), RGB."""


@dataclass(frozen=True)
class TextureLibrary:
    """The textures of one split.

    Attributes:
        split: train or test; decides the seeds.
        photos: photos of this split, whose crops are textures of the kind ``photo``.
        models: 3D models of this split, with textures of their own.
        pictures: photographed textures and panoramas of this split.
        worlds: whole places of this split, likewise.
    """

    split: SceneSplit
    photos: tuple[Path, ...] = field(default=(), repr=False)
    models: "TexturedModels | None" = None
    pictures: PackPictures | None = None
    worlds: "TexturedModels | None" = None

    @classmethod
    def over(cls, split: SceneSplit, folders: Iterable[Path]) -> "TextureLibrary":
        """A library with the split's photos in these folders and below.

        One photo in TEST_PHOTOS, by a checksum of its bytes, belongs to the test split.
        """
        found = [
            path
            for folder in folders
            for path in sorted(folder.rglob("*"))
            if path.suffix.lower() in IMAGE_SUFFIXES
        ]
        return cls(split, tuple(p for p in found if photo_split(p) == split))

    def any_of(self, rng: Rng, *kinds: str) -> TextureKey:
        """A random texture of one of these kinds; ``photo`` becomes ``print`` without photos."""
        kind = kinds[rng.integers(len(kinds))]
        number = int(rng.integers(1 << 30))
        if kind == "photo" and self.photos:
            return TextureKey("photo", number % (len(self.photos) * 4))
        if self.pictures is not None and (found := self.pictures.in_place_of(kind, number)):
            picture, variant = found
            return TextureKey(kind, variant, picture)
        return TextureKey("print" if kind == "photo" else kind, number % VARIANTS)

    def tile_m(self, key: TextureKey, asked: tuple[float, float]) -> tuple[float, float]:
        """The least and greatest side of a texture's tile: a photographed one has its own."""
        if key.picture and self.pictures is not None:
            return self.pictures.tile_m(key.kind, key.picture)
        return asked

    def draw(self, key: TextureKey) -> NDArray[np.uint8]:
        """The texture, uint8 (S, S, 3), RGB; it tiles. S is SIDE_PX, or LARGE_PX of pictures."""
        if key.picture and self.pictures is not None:
            return self.pictures.texture(key.picture, key.number)
        if key.kind == "photo":
            return _photo_crop(self.photos[key.number // 4], key.number % 4)
        if self.models is not None and key.kind.startswith("model:"):
            return self.models.texture(key)
        if self.worlds is not None and key.kind.startswith("world:"):
            return self.worlds.texture(key)
        return _drawn(self.split, key.kind, key.number)


def photo_split(path: Path) -> SceneSplit:
    """The split that a photo's textures belong to."""
    return "test" if zlib.crc32(path.read_bytes()) % TEST_PHOTOS == 0 else "train"


@lru_cache(maxsize=2500)
def _drawn(split: SceneSplit, kind: str, number: int) -> NDArray[np.uint8]:
    seed = (SPLITS.index(split), zlib.crc32(kind.encode()), number)
    texture = PATTERNS[kind](np.random.default_rng(seed))
    return (np.clip(texture, 0, 1) * 255).astype(np.uint8)


@lru_cache(maxsize=800)
def _photo_crop(path: Path, number: int) -> NDArray[np.uint8]:
    """A square crop, mirrored to both sides so that it tiles."""
    from footprints_edge.inputs.images import decode

    image = decode(path).rgb
    rng = np.random.default_rng((zlib.crc32(image.tobytes()), number))
    side = int(min(image.shape[:2]) * rng.uniform(0.25, 0.8))
    top = int(rng.integers(0, image.shape[0] - side + 1))
    left = int(rng.integers(0, image.shape[1] - side + 1))
    crop = image[top : top + side, left : left + side]
    half = cv2.resize(crop, (SIDE_PX // 2, SIDE_PX // 2), interpolation=cv2.INTER_AREA)
    row = np.hstack([half, half[:, ::-1]])
    return np.vstack([row, row[::-1]])
