"""Four legs, as tables, chairs, sofas and cupboards have them."""

from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.things import ThingPart, box


def four_legs(
    material: Material,
    width_m: float,
    depth_m: float,
    height_m: float,
    leg_m: float,
    inset_m: float,
) -> list[ThingPart]:
    """Four square legs below a rectangle, ``inset_m`` from its sides."""
    x, y = width_m / 2 - inset_m - leg_m / 2, depth_m / 2 - inset_m - leg_m / 2
    return [
        box(material, (leg_m, leg_m, height_m), (sx * x, sy * y, 0))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]
