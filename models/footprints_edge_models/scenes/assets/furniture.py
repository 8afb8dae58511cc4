"""Furniture and what stands on it. Every maker gives a thing whose front looks along -y."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.shapes import lathe
from footprints_edge_models.scenes.assets.things import (
    Part,
    Thing,
    blob,
    box,
    column,
    cushion,
    foliage,
    joined,
    rod,
    shifted,
)


def _legs(
    material: Material,
    width_m: float,
    depth_m: float,
    height_m: float,
    leg_m: float,
    inset_m: float,
) -> list[Part]:
    x, y = width_m / 2 - inset_m - leg_m / 2, depth_m / 2 - inset_m - leg_m / 2
    return [
        box(material, (leg_m, leg_m, height_m), (sx * x, sy * y, 0))
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def table(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, laid: float = 0.7
) -> Thing:
    """A table on four legs, a pedestal, two side frames or trestles, with things on it."""
    rng = palette.rng
    top = palette.table_top()
    legs = top if rng.random() < 0.4 else palette.metal() if rng.random() < 0.6 else palette.panel()
    thick = float(rng.uniform(0.02, 0.06))
    under = height_m - thick
    parts: list[Part]
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
            parts += _legs(legs, width_m, depth_m, under, leg, float(rng.choice([0, 0.02, 0.08])))
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


def on_top(palette: Palette, width_m: float, depth_m: float, z: float, count: float) -> list[Part]:
    """Small things on a surface: books, boxes, cups, bowls, papers, plants, bottles."""
    rng = palette.rng
    parts: list[Part] = []
    for _ in range(rng.poisson(count)):
        x, y = (rng.random(2) - 0.5) * (width_m, depth_m)
        yaw = float(rng.uniform(-3, 3))
        dice = rng.random()
        if dice < 0.3:
            for layer in range(int(rng.integers(1, 4))):
                cover = palette.of("print", "plain", "photo", tile_m=0.25, value=0.2)
                size = (rng.uniform(0.13, 0.24), rng.uniform(0.18, 0.32), 0.025)
                parts.append(box(cover, size, (x, y, z + layer * 0.025), yaw + layer * 0.2))
        elif dice < 0.45:
            paper = palette.of("print", "plaster", tile_m=0.3)
            parts.append(box(paper, (0.21, 0.297, 0.004), (x, y, z), yaw))
        elif dice < 0.62:
            cup = palette.of("plain", "plaster", gloss=0.08)
            wide = float(rng.uniform(0.06, 0.11))
            parts.append(column(cup, wide, rng.uniform(0.07, 0.13), (x, y, z), top=1.15, sides=10))
        elif dice < 0.72:
            bottle = palette.of("plain", "metal", gloss=0.15)
            parts.append(column(bottle, 0.075, 0.18, (x, y, z), sides=10))
            parts.append(column(bottle, 0.03, 0.09, (x, y, z + 0.18), sides=8))
        elif dice < 0.84:
            carton = palette.of("print", "plain", "photo", "wood", tile_m=0.4)
            parts.append(box(carton, rng.uniform(0.08, 0.35, 3) * (1, 1, 0.7), (x, y, z), yaw))
        elif dice < 0.92:
            bowl = palette.of("plain", "wood", "metal", gloss=0.08)
            parts.append(column(bowl, 0.14, 0.09, (x, y, z), top=1.7, sides=12))
            for _ in range(int(rng.integers(0, 6))):
                fruit = palette.of("plain", value=0.2)
                dx, dy = rng.normal(0, 0.05, 2)
                parts.append(blob(fruit, (0.08, 0.08, 0.08), (x + dx, y + dy, z + 0.06)))
        else:
            parts += shifted(potted(palette, float(rng.uniform(0.15, 0.45))), x, y, z)
    return parts


def potted(palette: Palette, height_m: float) -> list[Part]:
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


def plant(palette: Palette) -> Thing:
    """A plant that stands on the floor."""
    return joined("plant", potted(palette, float(palette.rng.uniform(0.6, 1.9))))


def monitor(palette: Palette, z: float) -> list[Part]:
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


def desk(palette: Palette) -> Thing:
    """A desk with what is on and under it."""
    rng = palette.rng
    width_m, depth_m = float(rng.uniform(1.1, 1.9)), float(rng.uniform(0.6, 0.9))
    z = float(rng.uniform(0.7, 0.78))
    parts = list(table(palette, width_m, depth_m, z, laid=0.8).parts)
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


def chair(palette: Palette, wood: Material | None = None, cloth: Material | None = None) -> Thing:
    """A chair on four legs, a cantilever or a stool."""
    rng = palette.rng
    frame = wood or palette.main_wood()
    seat = cloth or frame
    wide, deep, high = rng.uniform(0.4, 0.5), rng.uniform(0.4, 0.5), rng.uniform(0.43, 0.48)
    back = float(rng.uniform(0.35, 0.6))
    dice = rng.random()
    if dice < 0.12:
        return _bar_stool(palette, frame, seat)
    slab = 0.03 if cloth is None else 0.07
    make = box if cloth is None else cushion
    parts = [make(seat, (wide, deep, slab), (0, 0, high - slab))]
    leg = float(rng.uniform(0.022, 0.05))
    if dice < 0.8:
        parts += _legs(frame, wide, deep, high - slab, leg, 0.0)
        if rng.random() < 0.5:
            for sx in (-1, 1):
                parts.append(
                    box(frame, (leg * 0.7, deep - leg, 0.025), (sx * (wide - leg) / 2, 0, 0.2))
                )
    else:  # a cantilever: two bent tubes
        tube = palette.metal()
        for sx in (-1, 1):
            x = sx * wide / 2
            parts.append(rod(tube, (x, deep / 2, 0.013), (x, -deep / 2, 0.013), 0.025))
            parts.append(rod(tube, (x, -deep / 2, 0.013), (x, -deep / 2, high), 0.025))
        parts.append(rod(tube, (-wide / 2, deep / 2, 0.013), (wide / 2, deep / 2, 0.013), 0.025))
    parts += _chair_back(rng, frame, seat, (wide, deep, high), leg, back, soft=cloth is not None)
    if rng.random() < 0.15:
        for sx in (-1, 1):
            parts.append(box(frame, (0.04, deep, 0.03), (sx * wide / 2, 0, high + 0.2)))
            parts.append(box(frame, (0.03, 0.03, 0.2), (sx * wide / 2, -deep / 2 + 0.03, high)))
    return joined("chair", parts)


def _chair_back(
    rng: np.random.Generator,
    frame: Material,
    seat: Material,
    size: tuple[float, float, float],
    leg: float,
    back: float,
    *,
    soft: bool,
) -> list[Part]:
    """A back on two posts: a panel, boards across, or rods."""
    wide, deep, high = size
    make = cushion if soft else box
    slab = 0.07 if soft else 0.03
    y = deep / 2 - leg / 2
    posts = (leg, leg, back + slab)
    parts = [box(frame, posts, (sx * (wide - leg) / 2, y, high - slab), 0, -0.08) for sx in (-1, 1)]
    y += 0.02
    style = rng.random()
    if style < 0.4:
        panel = (wide, 0.03 + slab * 0.4, back * 0.5)
        return [*parts, make(seat, panel, (0, y, high + back * 0.45), 0)]
    if style < 0.7:
        rows = range(int(rng.integers(2, 5)))
        boards = [(0, y, high + back * (0.3 + 0.22 * row)) for row in rows]
        return parts + [box(frame, (wide, 0.02, 0.05), at) for at in boards]
    rods = [(x, y, high) for x in np.linspace(-wide / 2, wide / 2, 7)[1:-1]]
    parts.append(box(frame, (wide, 0.025, 0.07), (0, y, high + back - 0.06)))
    return parts + [box(frame, (0.02, 0.02, back), at) for at in rods]


def _bar_stool(palette: Palette, frame: Material, seat: Material) -> Thing:
    high = float(palette.rng.uniform(0.6, 0.78))
    parts = [column(seat, 0.36, 0.06, (0, 0, high))]
    for angle in np.arange(4) * np.pi / 2 + 0.78:
        foot = (0.2 * np.cos(angle), 0.2 * np.sin(angle), 0)
        parts.append(rod(frame, foot, (foot[0] * 0.6, foot[1] * 0.6, high), 0.03))
    return joined("stool", parts)


def office_chair(palette: Palette) -> Thing:
    """A swivel chair on a star of five feet."""
    rng = palette.rng
    dark = palette.dark()
    cloth = palette.cloth() if rng.random() < 0.5 else dark
    parts = []
    turn = rng.random() * 6
    for angle in np.arange(5) * 2 * np.pi / 5 + turn:
        tip = (0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.06)
        parts.append(rod(dark, (0, 0, 0.12), tip, 0.045))
        parts.append(blob(dark, (0.06, 0.06, 0.06), (tip[0], tip[1], 0)))
    parts.append(column(palette.metal(), 0.05, 0.3, (0, 0, 0.1)))
    parts.append(cushion(cloth, (0.5, 0.48, 0.1), (0, 0, 0.42)))
    tall = float(rng.uniform(0.45, 0.75))
    parts.append(cushion(cloth, (0.46, 0.09, tall), (0, 0.24, 0.55), lean=-0.12))
    parts.append(box(dark, (0.06, 0.04, 0.3), (0, 0.27, 0.4)))
    if rng.random() < 0.7:
        for sx in (-1, 1):
            parts.append(box(dark, (0.06, 0.26, 0.03), (sx * 0.27, 0, 0.66)))
            parts.append(box(dark, (0.03, 0.05, 0.22), (sx * 0.27, 0, 0.45)))
    return joined("office chair", parts)


def sofa(palette: Palette, seats: int) -> Thing:
    """An armchair or a sofa."""
    rng = palette.rng
    cloth = palette.cloth()
    seat_m, deep = float(rng.uniform(0.55, 0.75)), float(rng.uniform(0.8, 1.0))
    arm, back = float(rng.uniform(0.12, 0.25)), float(rng.uniform(0.35, 0.5))
    wide = seats * seat_m + 2 * arm
    lift = float(rng.choice([0.02, 0.08, 0.14]))
    base = 0.42 - lift
    round_ = float(rng.uniform(0.12, 0.35))
    parts = [cushion(cloth, (wide, deep, base * 0.7), (0, 0, lift), squareness=0.12)]
    for index in range(seats):
        x = (index - (seats - 1) / 2) * seat_m
        parts.append(
            cushion(cloth, (seat_m, deep * 0.75, 0.2), (x, -deep * 0.1, 0.28), squareness=round_)
        )
        parts.append(
            cushion(
                cloth, (seat_m, 0.22, back), (x, deep * 0.28, 0.42), lean=-0.15, squareness=round_
            )
        )
        if rng.random() < 0.4:
            pillow = palette.cloth()
            yaw = float(rng.normal(0, 0.4))
            parts.append(cushion(pillow, (0.42, 0.15, 0.4), (x, deep * 0.08, 0.45), yaw, lean=-0.3))
    parts.append(
        cushion(
            cloth, (wide, 0.22, 0.42 + back * 0.8), (0, deep / 2 - 0.1, lift), squareness=round_
        )
    )
    for sx in (-1, 1):
        x = sx * (wide - arm) / 2
        parts.append(cushion(cloth, (arm, deep, 0.6 - lift), (x, 0, lift), squareness=round_))
    if lift > 0.05:
        parts += _legs(palette.main_wood(), wide, deep, lift + 0.05, 0.05, 0.05)
    return joined("sofa" if seats > 1 else "armchair", parts)


def bed(palette: Palette) -> Thing:
    """A bed; its head at +y."""
    rng = palette.rng
    wide, long_ = float(rng.choice([0.9, 1.0, 1.4, 1.6, 1.8])), float(rng.uniform(1.95, 2.1))
    frame = palette.main_wood()
    cover, sheet = palette.cloth(), palette.of("plaster", "fabric", "stripes", tile_m=0.5)
    lift = float(rng.choice([0.0, 0.1, 0.2]))
    z = lift + 0.22
    parts = [box(frame, (wide + 0.06, long_ + 0.04, 0.22), (0, 0, lift))]
    parts += _legs(frame, wide, long_, lift + 0.01, 0.07, 0.0)
    parts.append(cushion(sheet, (wide, long_, 0.24), (0, 0, z), squareness=0.12))
    share = float(rng.uniform(0.6, 0.9))
    parts.append(
        cushion(
            cover,
            (wide + 0.1, long_ * share, 0.3),
            (0, -long_ * (1 - share) / 2, z - 0.03),
            squareness=0.15,
        )
    )
    for index in range(1 if wide < 1.2 else 2):
        x = 0.0 if wide < 1.2 else (index - 0.5) * wide * 0.5
        parts.append(
            cushion(
                sheet,
                (min(wide * 0.45, 0.7), 0.42, 0.15),
                (x, long_ * 0.37, z + 0.2),
                squareness=0.4,
            )
        )
        if rng.random() < 0.5:
            parts.append(
                cushion(
                    palette.cloth(),
                    (0.45, 0.2, 0.4),
                    (x, long_ * 0.27, z + 0.22),
                    lean=-0.5,
                    squareness=0.4,
                )
            )
    if rng.random() < 0.85:
        head = palette.cloth() if rng.random() < 0.3 else frame
        parts.append(
            box(head, (wide + 0.1, 0.06, rng.uniform(0.8, 1.25)), (0, long_ / 2 + 0.04, 0))
        )
    if rng.random() < 0.3:
        parts.append(
            box(frame, (wide + 0.1, 0.05, rng.uniform(0.4, 0.65)), (0, -long_ / 2 - 0.04, 0))
        )
    return joined("bed", parts)


def cabinet(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, laid: bool = True
) -> Thing:
    """A closed cupboard with doors or drawers, and what is on it."""
    rng = palette.rng
    body, knob = palette.panel(), palette.metal()
    front = body if rng.random() < 0.7 else palette.panel()
    lift = float(rng.choice([0.0, 0.06, 0.12]))
    parts = [box(body, (width_m, depth_m, height_m - lift), (0, 0, lift))]
    if lift > 0.1:
        parts += _legs(knob, width_m, depth_m, lift, 0.035, 0.03)
    elif lift:
        parts.append(box(palette.dark(), (width_m - 0.04, depth_m - 0.08, lift), (0, 0.03, 0)))
    parts += _fronts(front, knob, width_m, height_m - lift, -depth_m / 2, lift, rng)
    if laid and height_m < 1.5 and rng.random() < 0.75:
        parts += on_top(palette, width_m * 0.9, depth_m * 0.7, height_m, 3 * width_m)
    elif rng.random() < 0.3:
        parts += on_top(palette, width_m * 0.9, depth_m * 0.7, height_m, 2)
    return joined("cabinet", parts)


def _fronts(
    front: Material,
    knob: Material,
    width_m: float,
    height_m: float,
    y: float,
    z: float,
    rng: np.random.Generator,
) -> list[Part]:
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


def counter(palette: Palette, width_m: float, *, island: bool = False) -> Thing:
    """A run of kitchen cupboards with a worktop; wall cupboards above it unless an island."""
    rng = palette.rng
    front, knob = palette.panel(), palette.metal()
    work = palette.of("marble", "wood", "concrete", "plain", gloss=0.08)
    deep = 0.6 if not island else float(rng.uniform(0.7, 1.1))
    parts = [
        box(palette.dark(), (width_m, deep - 0.08, 0.1), (0, 0.03, 0)),
        box(front, (width_m, deep - 0.03, 0.76), (0, 0.01, 0.1)),
        box(work, (width_m + 0.02, deep + 0.02, 0.04), (0, 0, 0.86)),
    ]
    parts += _fronts(front, knob, width_m, 0.76, -deep / 2, 0.1, rng)
    parts += on_top(palette, width_m * 0.9, deep * 0.6, 0.9, 4 * width_m)
    if rng.random() < 0.6:
        x = rng.uniform(-0.3, 0.3) * width_m
        parts.append(box(palette.dark(), (0.58, 0.5, 0.012), (x, 0, 0.9)))
        if not island:
            oven = palette.of("metal", "plain", gloss=0.2)
            parts.append(box(oven, (0.58, 0.02, 0.6), (x, -deep / 2 - 0.01, 0.16)))
    if not island:
        splash = palette.of("tiles", "tiles", "plain", tile_m=(0.3, 0.8), gloss=0.1)
        parts.append(box(splash, (width_m, 0.01, 0.55), (0, deep / 2 - 0.005, 0.9)))
        if rng.random() < 0.8:
            tall = float(rng.uniform(0.55, 0.8))
            parts.append(box(front, (width_m, 0.34, tall), (0, deep / 2 - 0.17, 1.45)))
            parts += _fronts(front, knob, width_m, tall, deep / 2 - 0.34, 1.45, rng)
    return joined("counter", parts)


def fridge(palette: Palette) -> Thing:
    """A fridge, or a tall oven."""
    rng = palette.rng
    body = palette.of("plain", "metal", "plaster", gloss=0.12)
    tall = float(rng.uniform(1.4, 2.0))
    parts = [
        box(body, (0.6, 0.62, tall), (0, 0, 0.02)),
        box(palette.dark(), (0.56, 0.55, 0.03), (0, 0.02, 0)),
    ]
    for z, part in ((0.05, 0.58), (0.62, 0.36)):
        parts.append(box(body, (0.58, 0.04, tall * part), (0, -0.33, tall * z + 0.02)))
        parts.append(
            box(palette.metal(), (0.02, 0.03, 0.4 * part), (0.24, -0.36, tall * (z + part / 2)))
        )
    return joined("fridge", parts)


def tub(palette: Palette) -> Thing:
    """A bath."""
    white = palette.white()
    side = palette.of("tiles", "plain", "plaster", tile_m=0.5, gloss=0.1)
    long_, wide, high = 1.7, 0.75, 0.56
    parts = [
        box(side, (long_, wide, high - 0.12), (0, 0, 0)),
        box(white, (long_, 0.08, 0.12), (0, wide / 2 - 0.04, high - 0.12)),
        box(white, (long_, 0.08, 0.12), (0, -wide / 2 + 0.04, high - 0.12)),
        box(white, (0.1, wide, 0.12), (long_ / 2 - 0.05, 0, high - 0.12)),
        box(white, (0.1, wide, 0.12), (-long_ / 2 + 0.05, 0, high - 0.12)),
        box(white, (long_ - 0.2, wide - 0.16, 0.01), (0, 0, high - 0.12)),
    ]
    if palette.rng.random() < 0.4:
        curtain = palette.of("stripes", "checks", "fabric", "plaster", "ornament", tile_m=0.6)
        for x in np.arange(-long_ / 2, long_ / 2 * palette.rng.uniform(-0.6, 1), 0.07):
            yaw = float(palette.rng.normal(0, 0.4))
            parts.append(box(curtain, (0.09, 0.015, 1.6), (x, -wide / 2 - 0.02, 0.36), yaw))
    return joined("bath", parts)


_BOWL = lathe([(0.26, 0), (0.2, 0.12), (0.24, 0.3), (0.42, 0.7), (0.5, 0.95), (0.47, 1.0)])


def toilet(palette: Palette) -> Thing:
    """A toilet."""
    white = palette.white()
    matrix = np.array([[0.38, 0, 0, 0], [0, 0.52, 0, -0.08], [0, 0, 0.4, 0]])
    parts = [
        Part(_BOWL, matrix, white),
        cushion(white, (0.38, 0.5, 0.04), (0, -0.08, 0.4), squareness=0.7),
        box(white, (0.38, 0.17, 0.4), (0, 0.26, 0.38)),
        box(white, (0.2, 0.25, 0.38), (0, 0.18, 0)),
    ]
    return joined("toilet", parts)


def basin(palette: Palette) -> Thing:
    """A basin on a cupboard or a pedestal, with a mirror's frame above."""
    rng = palette.rng
    white = palette.white()
    wide = float(rng.uniform(0.5, 1.4))
    if rng.random() < 0.6:
        parts = list(cabinet(palette, wide, 0.48, 0.8, laid=False).parts)
        parts.append(
            box(palette.of("marble", "plain", "wood"), (wide + 0.03, 0.5, 0.03), (0, 0, 0.8))
        )
        parts += on_top(palette, wide * 0.9, 0.3, 0.83, 3)
    else:
        parts = [column(white, 0.16, 0.78, (0, 0.08, 0), top=1.2)]
        wide = 0.55
    parts.append(cushion(white, (0.5, 0.42, 0.14), (0, 0, 0.78), squareness=0.6))
    parts.append(rod(palette.metal(), (0, 0.18, 0.9), (0, 0.1, 1.05), 0.03))
    mirror = palette.of("metal", gloss=0.85, sharpness=1.0)
    parts.append(box(mirror, (wide, 0.02, rng.uniform(0.6, 0.9)), (0, 0.23, 1.1)))
    return joined("basin", parts)


def clutter(palette: Palette) -> Thing:
    """Something small on the floor: a box, a bag, a bin, a pile, shoes, a toy, a suitcase."""
    makers = (_carton, _bin, _bag, _suitcase, _clothes, _shoes, _ball)
    share = (0.3, 0.15, 0.15, 0.12, 0.14, 0.08, 0.06)
    return makers[int(palette.rng.choice(len(makers), p=share))](palette)


def _carton(palette: Palette) -> Thing:
    rng = palette.rng
    card = palette.of("plain", "print", "fabric", "wood", "photo", tile_m=0.5)
    size = rng.uniform(0.15, 0.6, 3)
    parts = [box(card, size, (0, 0, 0))]
    if rng.random() < 0.4:
        second = palette.of("print", "plain", "wood")
        parts.append(box(second, size * 0.7, (0, 0, size[2]), 0.3))
    return joined("box", parts)


def _bin(palette: Palette) -> Thing:
    made = palette.of("plain", "metal", gloss=0.05)
    high = float(palette.rng.uniform(0.25, 0.6))
    return joined("bin", [column(made, 0.26, high, (0, 0, 0), top=1.2)])


def _bag(palette: Palette) -> Thing:
    rng = palette.rng
    cloth = palette.cloth()
    wide, high = float(rng.uniform(0.3, 0.5)), float(rng.uniform(0.25, 0.45))
    parts = [cushion(cloth, (wide, 0.22, high), (0, 0, 0), squareness=0.4)]
    for sy in (-1, 1):
        for sx in (-1, 1):
            start = (sx * wide / 4, sy * 0.07, high - 0.03)
            parts.append(rod(cloth, start, (0, sy * 0.05, high + 0.18), 0.02))
    return joined("bag", parts)


def _suitcase(palette: Palette) -> Thing:
    shell, handle = palette.of("plain", "fabric", gloss=0.05), palette.dark()
    tall = float(palette.rng.uniform(0.5, 0.72))
    parts = [cushion(shell, (0.42, 0.26, tall - 0.04), (0, 0, 0.04), squareness=0.2)]
    parts += [rod(handle, (x, 0.1, tall), (x, 0.1, tall + 0.3), 0.015) for x in (-0.1, 0.1)]
    return joined("suitcase", parts)


def _clothes(palette: Palette) -> Thing:
    size = palette.rng.uniform(0.2, 0.7, 3) * (1, 1, 0.35)
    parts = [cushion(palette.cloth(), size, (0, 0, 0), squareness=0.7)]
    parts.append(cushion(palette.cloth(), size * 0.6, (size[0] * 0.3, 0, 0), squareness=0.8))
    return joined("clothes", parts)


def _shoes(palette: Palette) -> Thing:
    rng = palette.rng
    shoe = palette.of("plain", "fabric")
    parts = [
        cushion(shoe, (0.1, 0.27, 0.1), (sx * 0.08, rng.normal(0, 0.04), 0), squareness=0.7)
        for sx in (-1, 1)
    ]
    return joined("shoes", parts)


def _ball(palette: Palette) -> Thing:
    wide = float(palette.rng.uniform(0.1, 0.6))
    return joined("ball", [blob(palette.of("plain", "stripes"), (wide, wide, wide), (0, 0, 0))])


def floor_lamp(palette: Palette) -> Thing:
    """A standing lamp."""
    rng = palette.rng
    metal = palette.metal()
    tall = float(rng.uniform(1.3, 1.8))
    shade = palette.of("fabric", "plaster", glow=float(rng.choice([0, 0.8])))
    return joined(
        "lamp",
        [
            column(metal, 0.28, 0.03, (0, 0, 0)),
            rod(metal, (0, 0, 0), (0, 0, tall), 0.03),
            column(shade, 0.42, 0.3, (0, 0, tall - 0.1), top=0.7),
        ],
    )


def television(palette: Palette) -> Thing:
    """A low board with a television."""
    rng = palette.rng
    wide = float(rng.uniform(1.2, 2.0))
    low = float(rng.uniform(0.4, 0.6))
    parts = list(cabinet(palette, wide, 0.42, low, laid=False).parts)
    screen = float(rng.uniform(0.9, 1.3))
    parts.append(box(palette.dark(), (screen, 0.04, screen * 0.58), (0, 0.05, low + 0.08)))
    parts.append(box(palette.glass(), (screen * 0.97, 0.01, screen * 0.55), (0, 0.025, low + 0.1)))
    parts.append(box(palette.dark(), (0.4, 0.2, 0.08), (0, 0.05, low)))
    return joined("television", parts)


def whiteboard(palette: Palette) -> Thing:
    """A board on two feet, or a screen that divides a room."""
    rng = palette.rng
    wide, tall = float(rng.uniform(1.0, 1.8)), float(rng.uniform(0.9, 1.3))
    face = palette.of("plaster", "fabric", "print", tile_m=1.5)
    parts = [box(face, (wide, 0.03, tall), (0, 0, 1.9 - tall))]
    for sx in (-1, 1):
        x = sx * wide * 0.45
        parts.append(rod(palette.metal(), (x, 0, 0.03), (x, 0, 1.9), 0.04))
        parts.append(rod(palette.metal(), (x, -0.3, 0.03), (x, 0.3, 0.03), 0.04))
    return joined("board", parts)


def machine(palette: Palette) -> Thing:
    """A copier, a washing machine, a vending machine."""
    rng = palette.rng
    body = palette.of("plain", "plaster", "metal", gloss=0.05)
    size = (
        float(rng.uniform(0.5, 0.9)),
        float(rng.uniform(0.5, 0.75)),
        float(rng.uniform(0.8, 1.8)),
    )
    parts = [
        box(body, size, (0, 0, 0.03)),
        box(palette.dark(), (size[0] * 0.9, size[1] * 0.8, 0.04), (0, 0, 0)),
    ]
    parts.append(
        box(palette.dark(), (size[0] * 0.6, 0.02, size[2] * 0.3), (0, -size[1] / 2, size[2] * 0.5))
    )
    parts.append(
        box(
            palette.of("print", "plain"),
            (size[0] * 0.8, 0.02, 0.12),
            (0, -size[1] / 2, size[2] * 0.88),
        )
    )
    return joined("machine", parts)
