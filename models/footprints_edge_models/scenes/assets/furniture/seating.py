"""Chairs, stools, office chairs, sofas."""

import numpy as np

from footprints_edge_models.scenes.assets.furniture.legs import four_legs
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    blob,
    box,
    column,
    cushion,
    joined,
    rod,
)


@or_model(" chair ", " folding chair", " class seat")
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
        parts += four_legs(frame, wide, deep, high - slab, leg, 0.0)
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
) -> list[ThingPart]:
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


@or_model(" armchair ", " chair ")
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


@or_model("sofa", "couch", "armchair")
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
        parts += four_legs(palette.main_wood(), wide, deep, lift + 0.05, 0.05, 0.05)
    return joined("sofa" if seats > 1 else "armchair", parts)


def footstool(palette: Palette) -> Thing:
    """A soft stool to an armchair, on short legs."""
    wide, deep, high = (float(v) for v in palette.rng.uniform((0.45, 0.4, 0.34), (0.8, 0.6, 0.46)))
    lift = float(palette.rng.choice([0.02, 0.1]))
    parts = [cushion(palette.cloth(), (wide, deep, high - lift), (0, 0, lift), squareness=0.15)]
    parts += four_legs(palette.main_wood(), wide, deep, lift + 0.03, 0.05, 0.04)
    return joined("footstool", parts)
