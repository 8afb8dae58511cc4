"""Tables and desks."""

from footprints_edge_models.scenes.assets.furniture.legs import four_legs
from footprints_edge_models.scenes.assets.furniture.tabletop import on_top
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    box,
    column,
    joined,
    shifted,
)


def built_table(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, laid: float = 0.7
) -> Thing:
    """A table on four legs, a pedestal, two side frames or trestles, with things on it."""
    rng = palette.rng
    top = palette.table_top()
    legs = top if rng.random() < 0.4 else palette.metal() if rng.random() < 0.6 else palette.panel()
    thick = float(rng.uniform(0.02, 0.06))
    under = height_m - thick
    parts: list[ThingPart]
    dice = rng.random()
    round_top = dice > 0.8 and abs(width_m - depth_m) < 0.5
    if round_top:
        side = (width_m + depth_m) / 2
        parts = [column(top, side, thick, (0, 0, under), sides=24)]
        parts += [column(legs, 0.09, under, (0, 0, 0)), column(legs, 0.5 * side, 0.03, (0, 0, 0))]
    else:
        parts = [box(top, (width_m, depth_m, thick), (0, 0, under))]
        leg = float(rng.uniform(0.03, 0.09))
        if dice < 0.55:
            parts += four_legs(
                legs, width_m, depth_m, under, leg, float(rng.choice([0, 0.02, 0.08]))
            )
            if rng.random() < 0.5:
                for sy in (-1, 1):
                    rail = (0, sy * (depth_m / 2 - 0.08), under - 0.09)
                    parts.append(box(legs, (width_m - 0.2, 0.025, 0.09), rail))
        else:
            for sx in (-1, 1):
                x = sx * (width_m / 2 - 0.12)
                parts.append(box(legs, (0.06, depth_m * 0.85, 0.03), (x, 0, 0)))
                parts.append(box(legs, (0.07, 0.09, under - 0.03), (x, 0, 0.03)))
                parts.append(box(legs, (0.06, depth_m * 0.7, 0.03), (x, 0, under - 0.03)))
            if rng.random() < 0.5:
                parts.append(box(legs, (width_m - 0.24, 0.03, 0.25), (0, depth_m / 3, under - 0.3)))
    if rng.random() < laid:
        parts += on_top(palette, width_m * 0.85, depth_m * 0.8, height_m, float(rng.uniform(2, 9)))
    return joined("table", parts)


table = or_model(" table ", " desk ", " glass table", " coffee table")(built_table)
"""A table, or a 3D model of one."""


def monitor(palette: Palette, z: float) -> list[ThingPart]:
    """A screen on its foot, facing -y."""
    rng = palette.rng
    dark = palette.dark()
    wide = float(rng.uniform(0.45, 0.75))
    tall = wide * 0.58
    parts = [
        box(dark, (0.24, 0.18, 0.015), (0, 0, z)),
        box(dark, (0.05, 0.03, 0.2), (0, 0.03, z)),
        box(dark, (wide, 0.035, tall), (0, 0, z + 0.12)),
    ]
    if rng.random() < 0.5:
        screen = palette.of("print", "photo", tile_m=wide, glow=0.5)
        parts.append(box(screen, (wide * 0.96, 0.01, tall * 0.93), (0, -0.018, z + 0.13)))
    else:
        parts.append(box(palette.glass(), (wide * 0.96, 0.01, tall * 0.93), (0, -0.018, z + 0.13)))
    return parts


@or_model(" desk ", " desk table", " wooden table", " table ")
def desk(palette: Palette) -> Thing:
    """A desk with what is on and under it."""
    rng = palette.rng
    width_m, depth_m = float(rng.uniform(1.1, 1.9)), float(rng.uniform(0.6, 0.9))
    z = float(rng.uniform(0.7, 0.78))
    parts = list(built_table(palette, width_m, depth_m, z, laid=0.8).parts)
    for index in range(int(rng.integers(0, 3))):
        x = (-0.3 + 0.6 * index) * width_m / 2
        parts += shifted(monitor(palette, z), x, depth_m * 0.2)
    if rng.random() < 0.7:
        parts.append(box(palette.dark(), (0.44, 0.14, 0.02), (0, -depth_m * 0.2, z)))
    if rng.random() < 0.5:
        front = palette.panel()
        x = (width_m / 2 - 0.28) * rng.choice([-1, 1])
        parts.append(box(front, (0.42, depth_m * 0.8, 0.58), (x, 0, 0.05)))
        for row in range(3):
            parts.append(box(front, (0.38, 0.02, 0.16), (x, -depth_m * 0.4, 0.08 + row * 0.185)))
    if rng.random() < 0.4:
        modesty = palette.panel()
        parts.append(box(modesty, (width_m - 0.1, 0.02, 0.35), (0, depth_m / 2 - 0.1, 0.36)))
    if rng.random() < 0.35:
        x = -0.3 * width_m
        parts.append(box(palette.dark(), (0.2, 0.45, 0.44), (x, 0, 0.02)))
    if rng.random() < 0.25:
        screen = palette.cloth()
        parts.append(box(screen, (width_m, 0.04, 0.45), (0, depth_m / 2 - 0.02, z)))
    return joined("desk", parts)
