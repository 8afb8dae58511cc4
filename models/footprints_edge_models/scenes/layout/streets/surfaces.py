"""Materials of outdoor ground."""

from footprints_edge_models.scenes.assets.materials import Material, Palette


def road_surface(palette: Palette) -> Material:
    """Asphalt, or seldom soil, concrete or setts."""
    if palette.rng.random() < 0.85:
        return palette.of(
            "asphalt", tile_m=(1.5, 4.0), gloss=float(palette.rng.choice([0, 0, 0.03, 0.12]))
        )
    return palette.of("soil", "concrete", "paving", tile_m=(1.5, 3.0))


def pavement_surface(palette: Palette) -> Material:
    """Slabs, asphalt, concrete, bricks or tiles."""
    return palette.of(
        "paving", "paving", "asphalt", "concrete", "bricks", "tiles", tile_m=(0.9, 2.5)
    )


def verge_surface(palette: Palette) -> Material:
    """Grass, soil or slabs."""
    return palette.of("grass", "grass", "soil", "paving", tile_m=(1.5, 4.0))
