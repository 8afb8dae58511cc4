"""Cupboards and shelves."""

import numpy as np

from footprints_edge_models.scenes.assets.furniture.legs import four_legs
from footprints_edge_models.scenes.assets.furniture.tabletop import on_top
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, box, joined


def built_cabinet(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, laid: bool = True
) -> Thing:
    """A closed cupboard with doors or drawers, and what is on it."""
    rng = palette.rng
    body, knob = palette.panel(), palette.metal()
    front = body if rng.random() < 0.7 else palette.panel()
    lift = float(rng.choice([0.0, 0.06, 0.12]))
    parts = [box(body, (width_m, depth_m, height_m - lift), (0, 0, lift))]
    if lift > 0.1:
        parts += four_legs(knob, width_m, depth_m, lift, 0.035, 0.03)
    elif lift:
        parts.append(box(palette.dark(), (width_m - 0.04, depth_m - 0.08, lift), (0, 0.03, 0)))
    parts += fronts(front, knob, width_m, height_m - lift, -depth_m / 2, lift, rng)
    if laid and height_m < 1.5 and rng.random() < 0.75:
        parts += on_top(palette, width_m * 0.9, depth_m * 0.7, height_m, 3 * width_m)
    elif rng.random() < 0.3:
        parts += on_top(palette, width_m * 0.9, depth_m * 0.7, height_m, 2)
    return joined("cabinet", parts)


cabinet = or_model(
    "cabinet",
    "dresser",
    "chest",
    "wardrobe",
    "cupboard",
    "drawers",
    "filing",
    "bedside",
    "fireplace",
    "tv stand",
    "piano",
    "radiator",
)(built_cabinet)
"""A cabinet, or a 3D model of one."""


def fitted_cupboard(palette: Palette, width_m: float, depth_m: float, height_m: float) -> Thing:
    """A built-in wardrobe or a wall of office cupboards: doors from a plinth to the top."""
    rng = palette.rng
    door, knob = palette.panel(), palette.metal()
    plinth = float(rng.choice([0.0, 0.05, 0.09]))
    parts = [box(palette.dark(), (width_m, depth_m - 0.03, height_m), (0, 0.015, 0))]
    columns = max(1, round(width_m / rng.uniform(0.4, 0.75)))
    low = plinth
    upper = height_m - plinth - float(rng.choice([0.0, 0.45]))  # some have small doors above
    for tall in (upper, height_m - plinth - upper):
        wide = width_m / columns
        for index in range(columns if tall else 0):
            x = (index + 0.5) * wide - width_m / 2
            panel = (wide - 0.006, 0.03, tall - 0.006)
            parts.append(box(door, panel, (x, 0.015 - depth_m / 2, low + 0.003)))
            side = wide * (0.4 if index % 2 == 0 else -0.4)
            at = (x + side, -depth_m / 2 - 0.012, low + min(tall * 0.5, 1.0))
            parts.append(box(knob, (0.016, 0.024, float(rng.choice([0.03, 0.15]))), at))
        low += tall
    sides = [(sx * (width_m / 2 - 0.004), 0.0, 0.0) for sx in (-1, 1)]
    parts += [box(door, (0.012, depth_m - 0.03, height_m), at) for at in sides]
    return joined("cupboard", parts)


def fronts(
    front: Material,
    knob: Material,
    width_m: float,
    height_m: float,
    y: float,
    z: float,
    rng: np.random.Generator,
) -> list[ThingPart]:
    """Doors or drawers with handles on a front at ``y``."""
    columns = max(1, round(width_m / rng.uniform(0.4, 0.65)))
    rows = max(1, round(height_m / rng.uniform(0.22, 0.9)))
    wide, tall = width_m / columns, height_m / rows
    parts = []
    for row in range(rows):
        for index in range(columns):
            x, low = (index + 0.5) * wide - width_m / 2, z + row * tall
            parts.append(
                box(front, (wide - 0.012, 0.018, tall - 0.012), (x, y - 0.006, low + 0.006))
            )
            if tall < 0.4:
                parts.append(
                    box(
                        knob, (min(0.14, wide * 0.4), 0.02, 0.014), (x, y - 0.03, low + tall * 0.65)
                    )
                )
            else:
                side = wide * (0.4 if index % 2 == 0 else -0.4)
                parts.append(box(knob, (0.014, 0.02, 0.14), (x + side, y - 0.03, low + tall * 0.5)))
    return parts


@or_model("bookcase", "shelves", "shelf", "living room")
def shelf(palette: Palette, width_m: float, depth_m: float, height_m: float) -> Thing:
    """Open shelves with books and boxes."""
    rng = palette.rng
    board = palette.panel()
    rows = max(2, round(height_m / rng.uniform(0.3, 0.42)))
    parts = [box(board, (0.025, depth_m, height_m), (sx * width_m / 2, 0, 0)) for sx in (-1, 1)]
    if rng.random() < 0.8:
        parts.append(box(board, (width_m, 0.012, height_m), (0, depth_m / 2 - 0.006, 0)))
    for row in range(rows + 1):
        z = 0.04 + row * (height_m - 0.06) / rows
        parts.append(box(board, (width_m, depth_m, 0.022), (0, 0, z)))
        if row == rows:
            break
        x = -width_m / 2 + 0.04
        while x < width_m / 2 - 0.15:
            run = float(min(rng.uniform(0.12, 0.6), width_m / 2 - 0.02 - x))
            tall = (height_m / rows) * rng.uniform(0.5, 0.85)
            at = (x + run / 2, depth_m * rng.uniform(-0.15, 0.05), z + 0.022)
            dice = rng.random()
            if dice < 0.55:
                parts.append(box(palette.of("books", tile_m=0.3), (run, depth_m * 0.6, tall), at))
            elif dice < 0.75:
                carton = palette.of("plain", "fabric", "print", "wood", tile_m=0.4)
                parts.append(box(carton, (run * 0.8, depth_m * 0.7, tall * 0.9), at))
            x += run + 0.02
    return joined("shelf", parts)
