"""Materials, and the palette of one scene: what its floors, tables and cars are made of."""

from dataclasses import dataclass

import numpy as np

from footprints_edge_models.scenes.assets.textures.building import plaster_colour
from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary


@dataclass(frozen=True)
class Material:
    """A surface.

    Attributes:
        texture: its pattern.
        tile_m: side of one repeat of the pattern.
        tint: factors on the pattern's colours.
        gloss: share of light mirrored when seen from above, 0 to 1.
        sharpness: how clear the mirrored picture is, 0 to 1.
        glow: light that it gives, in units of a white wall in ordinary light.
    """

    texture: TextureKey
    tile_m: float = 1.0
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    gloss: float = 0.0
    sharpness: float = 0.3
    glow: float = 0.0


FLOORS = {
    "planks": (0.5, 1.3), "parquet": (0.6, 1.6), "herringbone": (0.5, 1.2), "tiles": (0.4, 1.6),
    "carpet": (0.3, 0.9), "marble": (0.6, 2.0), "terrazzo": (0.4, 1.2), "concrete": (1.0, 3.0),
    "stripes": (0.3, 1.0), "checks": (0.4, 1.2), "plain": (1.0, 1.0), "photo": (0.5, 2.0),
}  # fmt: skip
"""Kinds of indoor floor, and the range of their repeats in metres."""
_OFTEN = (
    ("planks",) * 9 + ("tiles",) * 7 + ("carpet",) * 7 + ("parquet", "concrete", "terrazzo") * 2
)
WOODEN = {"planks": (0.3, 0.9), "wood": (0.4, 1.2), "parquet": (0.5, 1.0)}


class Palette:
    """Draws materials for one scene; those of one role are alike within it."""

    def __init__(self, library: TextureLibrary, rng: np.random.Generator) -> None:
        self.library = library
        self.rng = rng
        self.last_models: dict[str, object] = {}
        self._main_wood = self.wood()
        self._main_metal = self.of("metal", gloss=0.25)

    @property
    def has_models(self) -> bool:
        """Whether the scene is furnished from a pack of assets; others stay as they are."""
        return self.library.models is not None

    def of(
        self,
        *kinds: str,
        tile_m: float | tuple[float, float] = (0.4, 1.2),
        value: float = 0.1,
        hue: float = 0.03,
        gloss: float = 0.0,
        sharpness: float = 0.3,
        glow: float = 0.0,
    ) -> Material:
        """A material of one of these kinds of texture; ``value`` and ``hue`` spread its tint."""
        rng = self.rng
        texture = self.library.any_of(rng, *kinds)
        tint = np.exp(rng.normal(0, value) + rng.normal(0, hue, 3))
        if not isinstance(tile_m, float):
            tile_m = float(rng.uniform(*self.library.tile_m(texture, tile_m)))
        red, green, blue = (float(min(factor, 1.6)) for factor in tint)
        return Material(texture, tile_m, (red, green, blue), gloss, sharpness, glow)

    def among(self, kinds: dict[str, tuple[float, float]], gloss: float = 0.0) -> Material:
        """A material of one of these kinds, its repeat within the kind's range."""
        kind = list(kinds)[self.rng.integers(len(kinds))]
        return self.of(kind, tile_m=kinds[kind], gloss=gloss, sharpness=float(self.rng.random()))

    def floor(self, *preferred: str) -> Material:
        """An indoor floor, in one of five rooms glossy, in one of three a little."""
        dice = self.rng.random()
        gloss = self.rng.uniform(0.08, 0.35) if dice < 0.2 else 0.04 if dice < 0.5 else 0.0
        kinds = preferred or (*_OFTEN, *FLOORS)
        kind = kinds[self.rng.integers(len(kinds))]
        made = self.among({kind: FLOORS[kind]}, float(gloss))
        return made if made.texture.kind != "carpet" else self.of("carpet", tile_m=made.tile_m)

    def wood(self) -> Material:
        """Furniture wood: among the same boards as floors are made of."""
        return self.among(WOODEN, gloss=float(self.rng.choice([0, 0.03, 0.08])))

    def main_wood(self) -> Material:
        """The wood that most furniture of the scene shares."""
        return self._main_wood if self.rng.random() < 0.6 else self.wood()

    def panel(self) -> Material:
        """A front of furniture: wood, lacquer, metal."""
        if self.rng.random() < 0.5:
            return self.main_wood()
        return self.of("plain", "plain", "metal", "plaster", gloss=float(self.rng.choice([0, 0.1])))

    def table_top(self) -> Material:
        """A table top: wood as of floors, lacquer, stone, seldom cloth."""
        dice = self.rng.random()
        if dice < 0.65:
            return self.main_wood()
        if dice < 0.85:
            return self.of("plain", "plaster", gloss=0.06)
        return self.of("marble", "tiles", "fabric", "checks", "concrete", "terrazzo", gloss=0.05)

    def metal(self) -> Material:
        """The metal of legs and handles."""
        return self._main_metal

    def cloth(self) -> Material:
        """Upholstery, clothes, bags."""
        kinds = ("plain", "carpet", "stripes", "checks", "ornament")
        return self.of(*("fabric",) * 3, *kinds, tile_m=(0.15, 0.6), value=0.3, hue=0.08)

    def wall(self) -> Material:
        """An indoor wall; half of those of rooms with models are painted, as smooth as most are."""
        if self.has_models and self.rng.random() < 0.5:
            red, green, blue = (float(value) for value in (plaster_colour(self.rng) / 0.8) ** 2.2)
            return Material(TextureKey("blank", 2), 2.0, (red, green, blue))
        if self.rng.random() < 0.8:
            return self.of("plaster", tile_m=(1.5, 3.0))
        return self.of(
            "wallpaper", "bricks", "concrete", "planks", "tiles", "photo", tile_m=(0.8, 2.5)
        )

    def dark(self) -> Material:
        """Rubber, screens, black plastic."""
        tint = float(self.rng.uniform(0.06, 0.2))
        return Material(TextureKey("blank", 0), 1.0, (tint, tint, tint), 0.05)

    def glass(self) -> Material:
        """A window seen from outside, a screen."""
        tint = float(self.rng.uniform(0.08, 0.25))
        return Material(TextureKey("blank", 1), 1.0, (tint, tint, tint * 1.1), 0.18, 1.0)

    def white(self, glow: float = 0.0) -> Material:
        """White lacquer, porcelain; with ``glow`` a lamp."""
        return Material(TextureKey("blank", 2), 1.0, (1.1, 1.1, 1.1), 0.06, 0.8, glow)

    def leafage(self) -> Material:
        """Leaves."""
        return self.of("leaf", tile_m=(0.3, 0.8), value=0.25, hue=0.08)
