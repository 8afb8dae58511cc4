"""Plants in pots."""

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    column,
    foliage,
    joined,
    rod,
)


def potted(palette: Palette, height_m: float) -> list[ThingPart]:
    """A plant in a pot."""
    rng = palette.rng
    pot = palette.of("plain", "plaster", "concrete", "fabric", tile_m=0.4)
    wide = height_m * rng.uniform(0.22, 0.4)
    pot_m = height_m * rng.uniform(0.2, 0.4)
    crown = height_m * rng.uniform(0.5, 0.9)
    parts = [column(pot, wide * 0.8, pot_m, (0, 0, 0), top=1.25)]
    leafage = palette.leafage()
    variant = int(rng.integers(12))
    size = (crown, crown, height_m - pot_m * 0.9)
    parts.append(foliage(leafage, size, (0, 0, pot_m * 0.9), variant, 90, 0.3))
    parts.append(
        rod(palette.of("bark"), (0, 0, pot_m), (0, 0, height_m * 0.7), 0.02 + 0.02 * height_m)
    )
    return parts


@or_model("plant", "cactus", "bamboo")
def plant(palette: Palette) -> Thing:
    """A plant that stands on the floor."""
    return joined("plant", potted(palette, float(palette.rng.uniform(0.6, 1.9))))
