"""What fills the openings of walls: doors, windows, curtains, blinds."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import Thing, box, joined, rod
from footprints_edge_models.scenes.layout.floor_plans import FloorPlan, Opening, Wall
from footprints_edge_models.scenes.layout.rooms.room import Room, place_of
from footprints_edge_models.scenes.layout.rooms.walls import wall_box


def hang_door(
    palette: Palette,
    wall: Wall,
    hole: Opening,
    plan: FloorPlan,
    rooms: list[Room],
    things: list[Thing],
    frame: Material,
    leaf: Material,
) -> None:
    """Put a frame, and mostly a door leaf, shut or ajar, into an opening."""
    rng = palette.rng
    jambs = [
        wall_box(wall, frame, at - 0.03, at + 0.03, 0, plan.thickness_m + 0.03, 0, hole.top)
        for at in (hole.start, hole.end)
    ]
    things.append(joined("door frame", jambs, is_wall=True))
    lintel = wall_box(
        wall,
        frame,
        hole.start,
        hole.end,
        0,
        plan.thickness_m + 0.03,
        hole.top - 0.03,
        hole.top + 0.05,
    )
    things.append(joined("door frame", [lintel], is_wall=True))
    wide = hole.end - hole.start - 0.08
    parts = [box(leaf, (wide, 0.04, hole.top - 0.05), (wide / 2, 0, 0.01))]
    if rng.random() < 0.4:
        parts += [
            box(leaf, (wide * 0.65, 0.055, tall), (wide / 2, 0, z))
            for z, tall in ((0.15, 0.7), (1.0, 0.9))
        ]
    for y in (-0.05, 0.05):
        parts.append(rod(palette.metal(), (wide - 0.07, y, 1.02), (wide - 0.2, y, 1.02), 0.025))
    dice = rng.random()
    if dice < 0.25:
        swing = 0.0
    elif dice < 0.55:
        return  # no leaf at all
    else:
        swing = float(rng.uniform(0.5, 1.9)) * rng.choice([-1, 1])
    door = joined("door", parts, is_wall=True)
    base = 0.0 if wall.along_x else np.pi / 2
    at = hole.start + 0.04
    x, y = (at, wall.position) if wall.along_x else (wall.position, at)
    if rng.random() < 0.5 and swing:
        at = hole.end - 0.04
        x, y = (at, wall.position) if wall.along_x else (wall.position, at)
        base += np.pi
    things.append(door.at(x, y, 0.0, base + swing))
    if swing:
        place = place_of(door, x, y, base + swing).grown(0.05)
        for room in rooms:
            room.taken.append(place)


def glaze(
    palette: Palette,
    wall: Wall,
    hole: Opening,
    plan: FloorPlan,
    things: list[Thing],
    frame: Material,
    *,
    curtains: bool,
) -> None:
    """Put a window into an opening, with a sill and curtains or a blind."""
    rng = palette.rng
    thick = 0.06
    parts = [
        wall_box(wall, frame, at - 0.04, at + 0.04, 0, thick, hole.bottom, hole.top)
        for at in (hole.start + 0.04, hole.end - 0.04)
    ]
    parts += [
        wall_box(wall, frame, hole.start, hole.end, 0, thick, z, z + 0.08)
        for z in (hole.bottom, hole.top - 0.08)
    ]
    for index in range(1, round((hole.end - hole.start) / 0.9) + 1):
        at = hole.start + index * (hole.end - hole.start) / (
            round((hole.end - hole.start) / 0.9) + 1
        )
        parts.append(wall_box(wall, frame, at - 0.03, at + 0.03, 0, thick, hole.bottom, hole.top))
    sill = wall.inside * (plan.thickness_m / 2 + 0.08)
    if hole.bottom > 0.3:
        parts.append(
            wall_box(
                wall,
                frame,
                hole.start - 0.05,
                hole.end + 0.05,
                sill,
                0.2,
                hole.bottom - 0.03,
                hole.bottom,
            )
        )
    things.append(joined("window", parts, is_wall=True))
    if curtains:
        cloth = palette.of("fabric", "plaster", "stripes", "ornament", "checks", tile_m=(0.4, 1.0))
        drawn = float(rng.uniform(0.1, 0.35))
        folds = []
        low = 0.03 if rng.random() < 0.6 else hole.bottom - 0.1
        for start, end in (
            (hole.start - 0.2, hole.start - 0.2 + drawn),
            (hole.end + 0.2 - drawn, hole.end + 0.2),
        ):
            for at in np.arange(start, end, 0.06):
                depth = wall.inside * (plan.thickness_m / 2 + 0.1 + 0.03 * rng.random())
                folds.append(
                    wall_box(
                        wall, cloth, at, at + 0.065, depth, 0.04, max(low, 0.03), hole.top + 0.12
                    )
                )
        things.append(joined("curtain", folds))
    elif rng.random() < 0.3:
        slat = palette.of("blank", "metal", "wood")
        drop = float(rng.uniform(0.2, 1)) * (hole.top - hole.bottom)
        inner = wall.inside * (plan.thickness_m / 2 + 0.03)
        rows = [
            wall_box(wall, slat, hole.start, hole.end, inner, 0.035, z, z + 0.006)
            for z in np.arange(hole.top - drop, hole.top, 0.045)
        ]
        things.append(joined("blind", rows))
