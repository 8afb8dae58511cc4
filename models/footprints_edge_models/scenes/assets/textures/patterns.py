"""The procedural patterns by name. A new pattern takes a row in ``PATTERNS``."""

from collections.abc import Callable

from footprints_edge_models.scenes.assets.textures.building import (
    asphalt,
    bricks,
    concrete,
    paving,
    plaster,
    siding,
)
from footprints_edge_models.scenes.assets.textures.fabrics import (
    checks,
    fabric,
    ornament,
    stripes,
    wallpaper,
)
from footprints_edge_models.scenes.assets.textures.floors import (
    carpet,
    herringbone,
    marble,
    parquet,
    planks,
    terrazzo,
    tiles,
    wood,
)
from footprints_edge_models.scenes.assets.textures.nature import bark, clouds, grass, leaf, soil
from footprints_edge_models.scenes.assets.textures.noise import Rng, Texture
from footprints_edge_models.scenes.assets.textures.objects import (
    blank,
    books,
    hair,
    metal,
    paint,
    plain,
    print_,
    skin,
)

PATTERNS: dict[str, Callable[[Rng], Texture]] = {
    function.__name__.rstrip("_"): function
    for function in (
        planks, wood, parquet, herringbone, tiles, carpet, fabric, stripes, checks, ornament,
        concrete, asphalt, paving, bricks, siding, plaster, wallpaper, grass, soil, leaf, bark,
        marble, terrazzo, plain, metal, print_, books, paint, skin, hair, blank, clouds,
    )
}  # fmt: skip
