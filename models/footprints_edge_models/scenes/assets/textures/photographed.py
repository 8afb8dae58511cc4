"""The pictures of a pack of assets: photographed textures by class, and panoramas.

A photographed texture takes the place of a procedural one of a fitting kind, most of the time. It
is varied: less or more contrast and colour, and painted walls in the colours that walls have.
"""

import zlib
from functools import cached_property, lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.pack import PackEntry
from footprints_edge_models.scenes.assets.pack_part import PackPart
from footprints_edge_models.scenes.assets.textures.building import plaster_colour
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX, Texture, as_texture, noise

PHOTOGRAPHED_SHARE = 0.75
"""Share of textures that are photographed, of the kinds that have photographs."""
VARIANTS = 8
"""In how many ways one photograph is varied."""
LARGE_PX = 2 * SIDE_PX
"""The side of textures whose photograph is large enough."""

Range = tuple[float, float]

CLASSES: dict[str, dict[str, Range]] = {
    "planks": {"woodfloor": (1.0, 2.0), "planks": (1.0, 2.0)},
    "parquet": {"woodfloor": (1.0, 2.0)},
    "herringbone": {"woodfloor": (1.0, 2.0), "brick_floor": (1.0, 2.0)},
    "wood": {"wood": (0.6, 1.6), "woodfloor": (1.0, 2.0)},
    "tiles": {"tiles": (1.0, 2.0), "travertine": (1.0, 2.0)},
    "carpet": {"carpet": (0.5, 1.0), "fabric": (0.4, 0.8)},
    "marble": {"marble": (1.0, 2.0), "granite": (0.8, 1.6), "travertine": (1.0, 2.0)},
    "terrazzo": {"terrazzo": (0.8, 1.6), "granite": (0.8, 1.6)},
    "concrete": {"concrete": (1.5, 3.0)},
    "asphalt": {"asphalt": (2.0, 4.0), "concrete": (2.5, 4.0)},
    "paving": {"pavingstones": (1.0, 2.2), "brick_floor": (1.2, 2.2)},
    "bricks": {"bricks": (1.2, 2.2), "brick_wall": (1.5, 2.5)},
    "siding": {"woodsiding": (1.5, 2.5)},
    "plaster": {"plaster": (1.5, 3.0), "wallpaper": (1.0, 2.0), "paint": (1.5, 3.0)},
    "wallpaper": {"wallpaper": (0.6, 1.2), "fabric": (0.5, 1.0)},
    "grass": {"grass": (1.5, 3.0), "moss": (1.5, 3.0)},
    "soil": {"ground": (2.0, 4.0), "gravel": (1.5, 3.0)},
    "fabric": {"fabric": (0.3, 0.6)},
}
"""For a procedural kind the classes that may stand for it, and the sides of a tile in metres."""
PAINTED = frozenset({"plaster", "wallpaper", "paint"})
"""Classes whose photograph gives the relief, not the colour."""
GRAINED = frozenset({"wood", "woodfloor", "planks", "woodsiding"})
"""Classes that are turned so that their grain runs along x, as that of procedural ones does."""
_DULL_ABOVE = {
    "asphalt": 0.08, "concrete": 0.12, "gravel": 0.18, "pavingstones": 0.22, "grass": 0.6,
}  # fmt: skip
"""Textures of a higher mean saturation are paler than photographed: few roads are so loud."""
_OTHERS_DULL_ABOVE = 0.3
_CLOSE = frozenset({"forest"})
"""Panoramas of what stands close around the camera: no background of a wide place."""


class PackPictures(PackPart):
    """The textures and panoramas of a pack that belong to one split."""

    @cached_property
    def _entries(self) -> dict[str, PackEntry]:
        return {entry.key: entry for entry in self._pack.of("texture", self.split)}

    @cached_property
    def _of_class(self) -> dict[str, list[PackEntry]]:
        """Those of PAINTED classes and small ones stand once, large ones often: they are better."""
        found: dict[str, list[PackEntry]] = {}
        for entry in self._entries.values():
            often = 4 if entry.key.startswith("polyhaven") else 1
            found.setdefault(entry.category, []).extend([entry] * often)
        return found

    @cached_property
    def panoramas(self) -> tuple[str, ...]:
        """Keys of the panoramas taken in the open."""
        entries = self._pack.of("panorama", self.split)
        return tuple(
            entry.key
            for entry in entries
            if entry.category in {"outdoor", "sky"} and entry.key not in _CLOSE
        )

    def in_place_of(self, kind: str, number: int) -> tuple[str, int] | None:
        """A texture for a procedural kind: its key and its variant; None to keep that one.

        Args:
            kind: The procedural kind.
            number: A random number, at least 0 and below 2 ** 30.
        """
        number, dice = divmod(number, 1000)
        classes = [name for name in CLASSES.get(kind, ()) if name in self._of_class]
        if not classes or dice >= PHOTOGRAPHED_SHARE * 1000:
            return None
        number, variant = divmod(number, VARIANTS)
        number, which = divmod(number, len(classes))
        entries = self._of_class[classes[which]]
        return entries[number % len(entries)].key, variant

    def tile_m(self, kind: str, key: str) -> Range:
        """The least and the greatest side of a texture's tile in place of a procedural kind."""
        return CLASSES[kind][self._entries[key].category]

    def texture(self, key: str, variant: int) -> NDArray[np.uint8]:
        """A variant of a texture, RGB, uint8 (S, S, 3), S being SIDE_PX or LARGE_PX; it tiles."""
        return self._keep((key, variant), lambda: self._drawn(key, variant), _MOST_DRAWN)

    def _drawn(self, key: str, variant: int) -> NDArray[np.uint8]:
        entry = self._entries[key]
        rng = np.random.default_rng((zlib.crc32(key.encode()), variant))
        picture = _tile(self._pack.picture(entry), rng)
        if entry.category in GRAINED and _grain_is_upright(picture):
            picture = np.ascontiguousarray(picture.transpose(1, 0, 2))
        return _varied(picture, entry.category, rng)

    def panorama(self, key: str) -> NDArray[np.uint8]:
        """A panorama, RGB, uint8 (H, 2 H, 3); see ``asset_files.pack``. The caller keeps it."""
        entries = {entry.key: entry for entry in self._pack.of("panorama", self.split)}
        return self._pack.picture(entries[key])


_MOST_DRAWN = 400


# bytes are handed to OpenCV: on floats of this size each step takes ten times as long


def _tile(picture: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A square that tiles. A small one gets the grain that its size has lost."""
    picture = _without_margin(picture)
    large = min(picture.shape[:2]) >= LARGE_PX
    side = LARGE_PX if large else SIDE_PX
    tile = _as_bytes(cv2.resize(picture, (side, side), interpolation=cv2.INTER_CUBIC))
    for axis in (0, 1):
        if _seam(tile, axis) > 2.5:
            tile = _faded(tile, axis)
    if large:
        return tile
    sharp = as_texture(tile)
    soft = cv2.GaussianBlur(sharp, (0, 0), 2, borderType=cv2.BORDER_REPLICATE)
    strength = cv2.GaussianBlur(cv2.transform(cv2.absdiff(sharp, soft), _THIRDS), (0, 0), 4)
    shift = rng.integers(SIDE_PX, size=2)
    grain = np.roll(_grain(int(rng.integers(VARIANTS))), shift, axis=(0, 1)) * strength
    return _as_bytes(cv2.add(sharp, cv2.merge([grain] * 3)))


_THIRDS = np.full((1, 3), 1 / 3, np.float32)


@lru_cache(maxsize=VARIANTS)
def _grain(number: int) -> Texture:
    return noise(np.random.default_rng(number), 0.3) * np.float32(0.7)


def _as_bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    """The values, 0 to 255, rounded."""
    return np.asarray(cv2.convertScaleAbs(cv2.max(values, 0)), np.uint8)


def _without_margin(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Without the white rows and columns at the ends that some sheets have."""
    for _ in range(2):
        least = np.minimum(np.minimum(picture[..., 0], picture[..., 1]), picture[..., 2])
        blank = (least > 235).mean(axis=1) > 0.9
        while len(blank) > SIDE_PX // 4 and blank.any() and not blank.all() and (
            blank[-3:].any() or blank[:3].any()
        ):  # fmt: skip
            inner = slice(1, None) if blank[:3].any() else slice(None, -1)
            picture, blank = picture[inner], blank[inner]
        picture = picture.transpose(1, 0, 2)
    return np.ascontiguousarray(picture)


def _seam(tile: NDArray[np.uint8], axis: int) -> float:
    """The step over the edge of a tile, in steps between its inner rows."""
    steps = cv2.absdiff(tile, np.roll(tile, -1, axis=axis))
    rows = cv2.reduce(steps, 1 - axis, cv2.REDUCE_AVG, dtype=cv2.CV_32F).reshape(-1, 3).mean(axis=1)
    return float(rows[-1] / max(np.median(rows[:-1]), 0.25))


def _faded(tile: NDArray[np.uint8], axis: int) -> NDArray[np.uint8]:
    """The last eighth fades into what comes before the first row, so that no seam shows."""
    tile = np.moveaxis(tile, axis, 0)
    side, over = len(tile), len(tile) // 8
    share = as_texture(np.linspace(0, 1, over))[:, None, None]
    kept = tile[over:].copy()
    kept[-over:] = kept[-over:] * (1 - share) + tile[:over] * share + np.float32(0.5)
    wide = cv2.resize(kept, (tile.shape[1], side), interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(np.moveaxis(np.asarray(wide, np.uint8), 0, axis))


def _grain_is_upright(tile: NDArray[np.uint8]) -> bool:
    along_x = cv2.absdiff(tile[:, 1:], tile[:, :-1]).mean()
    return bool(along_x > cv2.absdiff(tile[1:], tile[:-1]).mean())


def _varied(tile: NDArray[np.uint8], category: str, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Less or more contrast and colour; all of it is linear in a pixel's colour."""
    mean = np.array(cv2.mean(tile)[:3])
    contrast = float(rng.uniform(0.7, 1.4))
    if category in PAINTED:
        relief = contrast * float(rng.choice([0.05, 0.12, 0.25]))
        paint = plaster_colour(rng)[:, None] * 255
        linear = paint * np.full((1, 3), relief / (3 * max(mean.mean(), 1.0)))
        constant = paint * (1 - relief)
    else:
        some = tile[::4, ::4].reshape(-1, 3)
        loud = float(np.ptp(some, axis=1).mean() / max(float(mean.max()), 0.05 * 255))
        dull = _DULL_ABOVE.get(category, _OTHERS_DULL_ABOVE)
        colour = float(rng.uniform(0.45, 1.0)) * min(1.0, dull / max(loud, 1e-3))
        bright = float(np.exp(rng.normal(0, 0.15)))
        paler = colour * np.eye(3) + (1 - colour) / 3
        linear = bright * contrast * paler
        constant = (bright * (1 - contrast) * paler @ mean)[:, None]
    return np.asarray(cv2.transform(tile, np.hstack([linear, constant])), np.uint8)
