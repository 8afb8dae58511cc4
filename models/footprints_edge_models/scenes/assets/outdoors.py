"""What stands along streets: trees, poles, signs, fences, walls, benches, bins, houses."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import (
    Part,
    Thing,
    blob,
    box,
    column,
    cushion,
    foliage,
    joined,
    rectangle,
    rod,
)

TALL_M = 1.2
"""A hedge, a fence of boards or a garden wall of this height hides what lies behind as a house
does."""


def tree(palette: Palette) -> Thing:
    """A tree; only its trunk takes ground."""
    rng = palette.rng
    tall = float(rng.uniform(3.5, 11))
    bark, leafage = palette.of("bark", tile_m=0.6), palette.leafage()
    trunk = float(rng.uniform(0.12, 0.3) + 0.015 * tall)
    bare = float(rng.uniform(0.25, 0.5)) * tall
    bare = max(bare, 1.6)
    parts = [rod(bark, (0, 0, -0.05), (0, 0, bare * 1.25), trunk, top=0.65, sides=9)]
    crown = tall * rng.uniform(0.3, 0.6)
    leafless = rng.random() < 0.15
    for _ in range(int(rng.integers(3, 7))):
        offset = rng.normal(0, 0.22, 3) * (crown, crown, (tall - bare) * 0.6)
        centre = np.array([0, 0, (bare + tall) / 2]) + offset
        parts.append(rod(bark, (0, 0, bare), centre, trunk * 0.5, top=0.3, sides=6))
        if leafless:
            for _ in range(6):
                tip = centre + rng.normal(0, 0.8, 3) + [0, 0, 0.5]
                parts.append(
                    rod(bark, centre * (0.6, 0.6, 1) - [0, 0, 0.3], tip, 0.05, top=0.3, sides=5)
                )
            continue
        size = np.array([crown, crown, (tall - bare) * 0.75]) * rng.uniform(0.6, 1)
        at = (centre[0], centre[1], max(centre[2] - size[2] / 2, bare * 0.75, 1.2))
        parts.append(foliage(leafage, size, at, int(rng.integers(100, 108)), 260, 0.16))
    return joined("tree", parts)


def conifer(palette: Palette) -> Thing:
    """A cypress or a fir with branches down to the ground."""
    rng = palette.rng
    tall, wide = float(rng.uniform(1.5, 6)), float(rng.uniform(0.7, 2.2))
    leafage = palette.leafage()
    parts = [rod(palette.of("bark"), (0, 0, 0), (0, 0, tall * 0.8), 0.15)]
    for index in range(4):
        share = 1 - index / 4.5
        parts.append(
            foliage(
                leafage,
                (wide * share, wide * share, tall * 0.42),
                (0, 0, tall * index * 0.19),
                110 + index,
                200,
                0.15,
            )
        )
    return joined("tree", parts)


def bush(palette: Palette) -> Thing:
    """A bush."""
    rng = palette.rng
    size = rng.uniform(0.5, 2.0, 3) * (1, 1, 0.7)
    parts = [
        foliage(
            palette.leafage(), size, (0, 0, -0.1 * size[2]), int(rng.integers(120, 126)), 300, 0.14
        )
    ]
    core = Material(palette.leafage().texture, 0.4, (0.5, 0.5, 0.5))
    parts.append(blob(core, size * 0.75, (0, 0, 0)))
    return joined("bush", parts)


def hedge(palette: Palette, length_m: float) -> Thing:
    """A clipped hedge along x."""
    rng = palette.rng
    deep, tall = float(rng.uniform(0.4, 0.8)), float(rng.uniform(0.5, 2.0))
    leafage = palette.leafage()
    parts = [cushion(leafage, (length_m, deep, tall), (0, 0, 0), squareness=0.1)]
    count = max(1, round(length_m / 1.2))
    for index in range(count):
        x = (index + 0.5 - count / 2) * length_m / count
        parts.append(
            foliage(leafage, (1.7, deep * 1.25, tall * 1.1), (x, 0, 0), 120 + index % 6, 300, 0.1)
        )
    outline = rectangle(-length_m / 2, -deep / 2, length_m / 2, deep / 2)
    return joined("hedge", parts, outlines=(outline,), is_wall=tall >= TALL_M)


def fence(palette: Palette, length_m: float) -> Thing:
    """A fence along x: boards, pickets, bars, rails or wire."""
    rng = palette.rng
    tall = float(rng.uniform(0.7, 2.0))
    made = palette.of("wood", "planks", "plaster", "metal", "paint", tile_m=0.7)
    style = rng.integers(4)
    parts: list[Part] = []
    posts = max(2, round(length_m / 2.2) + 1)
    parts += [
        box(made, (0.09, 0.09, tall + 0.05), (x, 0, 0))
        for x in np.linspace(-length_m / 2, length_m / 2, posts)
    ]
    if style == 0:
        parts.append(box(made, (length_m, 0.03, tall - 0.05), (0, 0, 0.05)))
    else:
        rails = (0.18, 0.85) if style != 3 else (0.3, 0.6, 0.9)
        parts += [box(made, (length_m, 0.04, 0.07), (0, 0, tall * share)) for share in rails]
        if style != 3:
            wide, gap = (0.08, 0.15) if style == 1 else (0.02, 0.12)
            parts += [
                box(made, (wide, 0.025, tall), (x, -0.03, 0.05))
                for x in np.arange(-length_m / 2, length_m / 2, gap)
            ]
    outline = rectangle(-length_m / 2, -0.06, length_m / 2, 0.06)
    is_wall = style == 0 and tall >= TALL_M
    return joined("fence", parts, outlines=(outline,), is_wall=is_wall)


def garden_wall(palette: Palette, length_m: float) -> Thing:
    """A wall along x."""
    rng = palette.rng
    tall = float(rng.uniform(0.4, 2.4))
    made = palette.of("bricks", "plaster", "concrete", "paving", tile_m=(0.8, 1.6))
    parts = [box(made, (length_m, 0.25, tall), (0, 0, 0))]
    parts.append(box(palette.of("concrete", "plaster"), (length_m, 0.33, 0.07), (0, 0, tall)))
    return joined("wall", parts, is_wall=tall >= TALL_M)


def barrier(palette: Palette, length_m: float) -> Thing:
    """A guard rail or concrete blocks."""
    rng = palette.rng
    if rng.random() < 0.5:
        metal = palette.of("metal", gloss=0.1)
        parts = [box(metal, (length_m, 0.06, 0.3), (0, 0, 0.45))]
        parts += [
            box(metal, (0.1, 0.1, 0.7), (x, 0.06, 0))
            for x in np.arange(-length_m / 2, length_m / 2 + 0.1, 2.0)
        ]
        return joined(
            "barrier", parts, outlines=(rectangle(-length_m / 2, -0.1, length_m / 2, 0.15),)
        )
    first, second = palette.of("concrete", "plaster"), palette.of("plain", "concrete", "paint")
    parts = []
    for index, x in enumerate(np.arange(-length_m / 2, length_m / 2, 1.0)):
        parts.append(box((first, second)[index % 2], (0.98, 0.4, 0.75), (x + 0.5, 0, 0)))
    return joined("barrier", parts)


def pole(palette: Palette) -> Thing:
    """A lamp post, a traffic light, a sign, a telegraph pole, a bollard."""
    rng = palette.rng
    metal = palette.of("metal", "paint", "concrete", gloss=0.05)
    style = rng.integers(5)
    if style == 0:
        tall = float(rng.uniform(4.5, 9))
        parts = [
            rod(metal, (0, 0, 0), (0, 0, tall), 0.16, top=0.6),
            column(metal, 0.24, 0.6, (0, 0, 0)),
        ]
        parts.append(rod(metal, (0, 0, tall), (0, -1.4, tall + 0.25), 0.08))
        parts.append(box(metal, (0.2, 0.6, 0.1), (0, -1.6, tall + 0.2)))
        return joined("lamp post", parts)
    if style == 1:
        parts = [
            column(metal, 0.12, 3.3, (0, 0, 0)),
            box(palette.dark(), (0.32, 0.25, 0.9), (0, -0.15, 2.3)),
        ]
        for index, colour in enumerate(((0.1, 0.5, 0.2), (0.6, 0.45, 0.1), (0.8, 0.1, 0.1))):
            lamp = Material(
                palette.of("blank").texture, 1.0, colour, glow=float(rng.choice([0, 1]))
            )
            parts.append(blob(lamp, (0.2, 0.06, 0.2), (0, -0.28, 2.38 + 0.27 * index)))
        return joined("traffic light", parts)
    if style == 2:
        tall = float(rng.uniform(1.8, 3))
        face = palette.of("print", "plain", "paint", tile_m=0.7)
        parts = [column(metal, 0.07, tall, (0, 0, 0))]
        if rng.random() < 0.5:
            parts.append(rod(face, (0, -0.05, tall - 0.3), (0, -0.08, tall - 0.3), 0.6, sides=18))
        else:
            parts.append(
                box(
                    face, (rng.uniform(0.4, 1), 0.03, rng.uniform(0.3, 0.8)), (0, -0.06, tall - 0.6)
                )
            )
        return joined("sign", parts)
    if style == 3:
        tall = float(rng.uniform(6, 9))
        wood = palette.of("bark", "concrete", "wood")
        parts = [
            rod(wood, (0, 0, 0), (0, 0, tall), 0.26, top=0.7),
            box(wood, (1.8, 0.1, 0.12), (0, 0, tall - 0.6)),
        ]
        return joined("pole", parts)
    parts = [column(metal, 0.14, rng.uniform(0.7, 1.1), (0, 0, 0))]
    return joined("bollard", parts)


def bench(palette: Palette) -> Thing:
    """A bench."""
    rng = palette.rng
    wood, metal = palette.wood(), palette.metal()
    wide = float(rng.uniform(1.3, 2.0))
    parts = [box(wood, (wide, 0.12, 0.04), (0, y, 0.43)) for y in (-0.2, -0.05, 0.1)]
    if rng.random() < 0.7:
        parts += [box(wood, (wide, 0.03, 0.12), (0, 0.22, z)) for z in (0.55, 0.73)]
    for side in (-1, 1):
        x = side * wide * 0.42
        parts.append(box(metal, (0.06, 0.06, 0.43), (x, -0.2, 0)))
        parts.append(box(metal, (0.06, 0.06, 0.85), (x, 0.19, 0)))
        parts.append(box(metal, (0.06, 0.45, 0.05), (x, 0, 0.38)))
    return joined("bench", parts)


def street_bin(palette: Palette) -> Thing:
    """A litter bin, a wheeled bin, a letter box, a cabinet, a planter."""
    rng = palette.rng
    style = rng.integers(4)
    made = palette.of("plain", "paint", "metal", gloss=0.05)
    if style == 0:
        return joined(
            "bin",
            [column(made, 0.45, 0.9, (0, 0, 0)), column(palette.dark(), 0.47, 0.08, (0, 0, 0.9))],
        )
    if style == 1:
        parts = [
            box(made, (0.55, 0.6, 0.95), (0, 0, 0.08)),
            box(made, (0.6, 0.68, 0.06), (0, 0, 1.03), 0, 0.05),
        ]
        parts += [box(palette.dark(), (0.08, 0.2, 0.2), (sx * 0.25, 0.25, 0)) for sx in (-1, 1)]
        return joined("bin", parts)
    if style == 2:
        return joined(
            "cabinet", [box(made, (rng.uniform(0.5, 1.2), 0.4, rng.uniform(0.9, 1.6)), (0, 0, 0))]
        )
    tub = palette.of("concrete", "wood", "plaster")
    wide = float(rng.uniform(0.5, 1.2))
    parts = [box(tub, (wide, wide, 0.5), (0, 0, 0))]
    parts.append(
        foliage(palette.leafage(), (wide * 1.1, wide * 1.1, 0.8), (0, 0, 0.3), 121, 420, 0.12)
    )
    return joined("planter", parts)


def house(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, shop: bool
) -> Thing:
    """A house whose front looks along -y from y = 0; it reaches back to y = depth_m."""
    rng = palette.rng
    wall = palette.of(
        "bricks", "plaster", "plaster", "siding", "concrete", "paving", tile_m=(1.2, 3.0)
    )
    trim, glass = palette.of("plaster", "concrete", "wood"), palette.glass()
    parts = [box(wall, (width_m, depth_m, height_m), (0, depth_m / 2, 0))]
    storey = float(rng.uniform(2.7, 3.6))
    storeys = max(1, int(height_m / storey))
    columns = max(1, round(width_m / rng.uniform(2.0, 3.6)))
    wide, tall = float(rng.uniform(0.8, 1.6)), float(rng.uniform(1.1, 1.8))
    door_column = int(rng.integers(columns))
    style = rng.random()
    for floor in range(storeys):
        for index in range(columns):
            x = (index + 0.5) * width_m / columns - width_m / 2
            z = floor * storey + 0.95
            if floor == 0 and shop:
                if index == 0:
                    front = (
                        palette.of("photo", "print", "plain", tile_m=2.5)
                        if rng.random() < 0.4
                        else glass
                    )
                    parts.append(box(front, (width_m * 0.9, 0.06, 2.1), (0, -0.02, 0.35)))
                    sign = palette.of("print", "plain", "paint", "photo", tile_m=2.0)
                    parts.append(box(sign, (width_m * 0.95, 0.15, 0.6), (0, -0.06, 2.55)))
                    if rng.random() < 0.4:
                        parts.append(
                            box(
                                palette.cloth(), (width_m * 0.9, 1.2, 0.06), (0, -0.6, 2.5), 0, 0.25
                            )
                        )
                continue
            if floor == 0 and index == door_column:
                leaf = palette.of("wood", "plain", "paint", "metal")
                parts.append(box(trim, (1.2, 0.08, 2.25), (x, -0.01, 0)))
                parts.append(box(leaf, (0.95, 0.06, 2.1), (x, -0.05, 0)))
                continue
            parts.append(box(trim, (wide + 0.2, 0.06, tall + 0.2), (x, -0.01, z - 0.1)))
            parts.append(box(glass, (wide, 0.04, tall), (x, -0.03, z)))
            if style < 0.6:
                parts.append(box(trim, (0.06, 0.05, tall), (x, -0.04, z)))
                parts.append(box(trim, (wide, 0.05, 0.06), (x, -0.04, z + tall / 2)))
            parts.append(box(trim, (wide + 0.3, 0.2, 0.08), (x, -0.06, z - 0.14)))
            if style > 0.85 and floor:
                parts.append(box(palette.metal(), (wide + 0.8, 0.9, 0.12), (x, -0.45, z - 0.9)))
                parts.append(box(palette.metal(), (wide + 0.8, 0.04, 0.9), (x, -0.88, z - 0.8)))
    if rng.random() < 0.5:
        parts.append(box(trim, (width_m, 0.3, 0.25), (0, -0.06, height_m - 0.25)))
    if rng.random() < 0.4:
        parts.append(box(palette.of("concrete", "paving"), (width_m, 0.08, 0.5), (0, -0.02, 0)))
    if height_m < 8 and rng.random() < 0.8:
        roof = palette.of("tiles", "bricks", "concrete", "siding", tile_m=(0.8, 2.0), value=0.2)
        rise = float(rng.uniform(0.25, 0.6)) * depth_m / 2
        parts.append(_gable(roof, width_m + 0.6, depth_m + 0.9, rise, height_m))
    if rng.random() < 0.3 and height_m < 9:
        garage = palette.of("siding", "plain", "plaster", tile_m=2.0)
        parts.append(box(garage, (2.6, 0.06, 2.2), (width_m / 2 - 1.7, -0.04, 0)))
    outline = rectangle(-width_m / 2, 0, width_m / 2, depth_m)
    return joined("building", parts, outlines=(outline,), is_wall=True)


def _gable(material: Material, width_m: float, depth_m: float, rise_m: float, z: float) -> Part:
    from footprints_edge_models.scenes.assets.shapes import loft

    profile = np.array([(-0.45, 0), (depth_m - 0.45, 0), (depth_m / 2 - 0.45, rise_m)])
    rings = [
        np.column_stack([np.full(3, x), profile + np.array((0, z))])
        for x in (-width_m / 2, width_m / 2)
    ]
    return Part(loft(rings), np.eye(3, 4), material)
