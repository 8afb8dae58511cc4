"""People built from rounded parts: standing, walking, sitting, riding. They look along -y."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.shapes import convex_hull_2d
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    blob,
    column,
    cushion,
    joined,
    joint,
    rod,
)
from footprints_edge_models.scenes.vectors import offset


@dataclass(frozen=True)
class _Clothes:
    skin: Material
    hair: Material
    top: Material
    legs: Material
    shoes: Material
    sleeves: Material

    @classmethod
    def drawn(cls, palette: Palette) -> "_Clothes":
        rng = palette.rng
        skin, top = palette.of("skin", value=0.1), palette.cloth()
        jeans = palette.of("fabric", tile_m=0.3, value=0.3)
        return cls(
            skin,
            palette.of("hair", value=0.3, tile_m=0.3),
            top,
            palette.cloth() if rng.random() < 0.6 else jeans,
            palette.of("plain", "fabric", value=0.4),
            top if rng.random() < 0.75 else skin,
        )


def _limb(
    material: Material,
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    wide_m: float,
    top: float,
) -> list[ThingPart]:
    knob = wide_m * top
    return [
        rod(material, start, end, wide_m, top=top, sides=10),
        joint(material, knob, end),
    ]


def _trunk(
    palette: Palette, clothes: _Clothes, hips: NDArray[np.float64], size: float, lean: float
) -> list[ThingPart]:
    """Torso, neck, head and hair above the hips; returns the shoulders' height with them."""
    rng = palette.rng
    broad = size * rng.uniform(0.9, 1.2)
    forward = offset(0, -np.sin(lean), np.cos(lean))
    chest = hips + forward * 0.28 * size
    shoulders = hips + forward * 0.5 * size
    head = hips + forward * 0.62 * size + offset(0, -0.02, 0)
    parts = [
        cushion(
            clothes.top,
            (0.34 * broad, 0.24 * size, 0.36 * size),
            hips - offset(0, 0, 0.06),
            squareness=0.7,
            lean=lean,
        ),
        cushion(
            clothes.top,
            (0.43 * broad, 0.25 * size, 0.34 * size),
            chest - offset(0, 0, 0.06),
            squareness=0.7,
            lean=lean,
        ),
        rod(clothes.skin, shoulders - offset(0, 0, 0.05), head, 0.11 * size),
        blob(clothes.skin, (0.165 * size, 0.2 * size, 0.24 * size), head - offset(0, 0, 0.02)),
        blob(
            clothes.hair,
            (0.185 * size, 0.2 * size, 0.18 * size),
            head + offset(0, 0.025, 0.06 * size),
        ),
    ]
    if rng.random() < 0.3:
        parts.append(
            blob(
                clothes.hair,
                (0.2 * size, 0.14 * size, 0.32 * size),
                head + offset(0, 0.07, -0.12 * size),
            )
        )
    return parts


def _arms(
    palette: Palette,
    clothes: _Clothes,
    hips: NDArray[np.float64],
    size: float,
    lean: float,
    swing: float,
    reach: float,
) -> list[ThingPart]:
    rng = palette.rng
    shoulders = hips + offset(0, -np.sin(lean), np.cos(lean)) * 0.5 * size
    parts = []
    for side in (-1, 1):
        start = shoulders + offset(side * 0.21 * size, 0, 0)
        bend = reach * rng.uniform(0.2, 1)
        angle = side * swing + bend * 0.4
        elbow = start + size * 0.3 * offset(side * 0.12, -np.sin(angle), -np.cos(angle))
        angle += bend * 1.2 + 0.15
        hand = elbow + size * 0.26 * offset(-side * 0.08 * bend, -np.sin(angle), -np.cos(angle))
        parts += _limb(clothes.top, start, elbow, 0.105 * size, 0.85)
        parts += _limb(clothes.sleeves, elbow, hand, 0.085 * size, 0.75)
        parts.append(joint(clothes.skin, 0.09, hand - offset(0, 0, 0.03)))
    return parts


def _leg(
    clothes: _Clothes,
    hip: NDArray[np.float64],
    knee: NDArray[np.float64],
    ankle: NDArray[np.float64],
    size: float,
    toe: float = -1,
) -> list[ThingPart]:
    parts = _limb(clothes.legs, hip, knee, 0.17 * size, 0.75)
    parts += _limb(clothes.legs, knee, ankle, 0.125 * size, 0.7)
    parts.append(
        cushion(
            clothes.shoes, (0.1, 0.27, 0.1), ankle + offset(0, toe * 0.06, -0.09), squareness=0.7
        )
    )
    return parts


@or_model(" female ", " male ", " boy ", " girl ", "person ")
def standing(palette: Palette) -> Thing:
    """Someone who stands or walks; the footprint is the hull of the feet."""
    rng = palette.rng
    clothes = _Clothes.drawn(palette)
    size = float(rng.normal(1, 0.06)) if rng.random() < 0.9 else float(rng.uniform(0.55, 0.8))
    hips = offset(0, 0, 0.92 * size)
    stride = float(rng.choice([0.05, 0.3, 0.5])) * rng.uniform(0.5, 1)
    parts, feet = [], []
    for side in (-1, 1):
        angle = side * stride
        hip = hips + offset(side * 0.095 * size, 0, 0)
        knee = hip + 0.43 * size * offset(0, -np.sin(angle + 0.1), -np.cos(angle + 0.1))
        bend = angle - 0.15 - max(0.0, -angle) * 0.6
        ankle = knee + 0.41 * size * offset(0, -np.sin(bend), -np.cos(bend))
        ankle[2] = max(ankle[2], 0.09)
        parts += _leg(clothes, hip, knee, ankle, size)
        feet += [ankle + offset(dx, dy, 0) for dx in (-0.06, 0.06) for dy in (-0.2, 0.09)]
    if rng.random() < 0.12:
        parts.append(column(clothes.legs, 0.6 * size, 0.75 * size, (0, 0, 0.2 * size), top=0.5))
    lean = float(rng.normal(0.03, 0.04))
    parts += _trunk(palette, clothes, hips, size, lean)
    parts += _arms(palette, clothes, hips, size, lean, -stride * 0.8, float(rng.beta(1, 3)))
    if rng.random() < 0.25:
        parts.append(cushion(palette.cloth(), (0.3, 0.18, 0.45), hips + offset(0, 0.2, 0.05)))
    outline = convex_hull_2d(np.array(feet)[:, :2])
    return joined("person", parts, outlines=(outline,))


def seated_parts(palette: Palette, seat_m: float, *, reach: float = 0.7) -> list[ThingPart]:
    """Someone on a seat of this height, hips at the origin."""
    clothes = _Clothes.drawn(palette)
    rng = palette.rng
    size = float(rng.normal(1, 0.05))
    hips = offset(0, 0.05, seat_m + 0.1)
    parts = []
    for side in (-1, 1):
        hip = hips + offset(side * 0.1, 0, -0.02)
        knee = hip + offset(side * 0.05, -0.44 * size, 0.02)
        ankle = np.array([knee[0], knee[1] + rng.normal(0.03, 0.08), max(0.09, seat_m - 0.35)])
        parts += _leg(clothes, hip, knee, ankle, size)
    lean = float(rng.normal(0.1, 0.1))
    parts += _trunk(palette, clothes, hips, size, lean)
    parts += _arms(palette, clothes, hips, size, lean, 0.0, reach)
    return parts


def rider_parts(palette: Palette, seat_m: float, bars: tuple[float, float]) -> list[ThingPart]:
    """Someone riding, hips above the origin; hands at (y, z) ``bars``, feet halfway down."""
    clothes = _Clothes.drawn(palette)
    hips = offset(0, 0.0, seat_m + 0.08)
    parts = []
    for side, lift in ((-1, 0.05), (1, 0.28)):
        hip = hips + offset(side * 0.09, 0, 0)
        ankle = offset(side * 0.12, -0.2, seat_m * 0.25 + lift)
        knee = (hip + ankle) / 2 + offset(side * 0.06, -0.24, 0.12)
        parts += _leg(clothes, hip, knee, ankle, 1.0)
    lean = 0.35
    parts += _trunk(palette, clothes, hips, 1.0, lean)
    shoulders = hips + offset(0, -np.sin(lean), np.cos(lean)) * 0.5
    for side in (-1, 1):
        hand = np.array([side * 0.25, *bars])
        start = shoulders + offset(side * 0.2, 0, 0)
        elbow = (start + hand) / 2 + offset(side * 0.06, 0.03, -0.08)
        parts += _limb(clothes.top, start, elbow, 0.105, 0.85)
        parts += _limb(clothes.sleeves, elbow, hand, 0.085, 0.75)
    if palette.rng.random() < 0.6:
        head = hips + offset(0, -np.sin(lean), np.cos(lean)) * 0.62
        parts.append(
            blob(
                palette.of("plain", "paint", gloss=0.1),
                (0.25, 0.28, 0.22),
                head + offset(0, 0, 0.05),
            )
        )
    return parts
