"""Walls: solid stretches between openings, one leaf for each room along them."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.things import ThingPart, box
from footprints_edge_models.scenes.layout.floor_plans import Wall
from footprints_edge_models.scenes.layout.rooms.room import Room


def solid_stretches(wall: Wall, height_m: float) -> list[tuple[float, float, float, float]]:
    """The stretches of a wall around its openings: start, end, bottom, top."""
    pieces, at = [], wall.start
    for hole in wall.openings:
        if hole.start > at:
            pieces.append((at, hole.start, 0.0, height_m))
        if hole.bottom > 0:
            pieces.append((hole.start, hole.end, 0.0, hole.bottom))
        if hole.top < height_m:
            pieces.append((hole.start, hole.end, hole.top, height_m))
        at = max(at, hole.end)
    if at < wall.end:
        pieces.append((at, wall.end, 0.0, height_m))
    return pieces


def rooms_along(
    wall: Wall, side: int, start: float, end: float, rooms: list[Room]
) -> list[tuple[float, float, int]]:
    """The stretches of a wall that bound one room each."""
    stretches = []
    for index, room in enumerate(rooms):
        inside = room.inside.grown(0.3)
        if wall.along_x:
            near, low, high = (inside.y0 if side > 0 else inside.y1), inside.x0, inside.x1
        else:
            near, low, high = (inside.x0 if side > 0 else inside.x1), inside.y0, inside.y1
        if abs(near + side * 0.3 - wall.position) < 0.25:
            lower, upper = max(start, low + 0.15), min(end, high - 0.15)
            # reach to the ends of the wall where only another wall follows
            lower = start if lower - start < 0.3 else lower
            upper = end if end - upper < 0.3 else upper
            if upper - lower > 0.005:
                stretches.append((lower, upper, index))
    return stretches


def wall_box(
    wall: Wall,
    material: Material,
    start: float,
    end: float,
    offset: float,
    thick: float,
    low: float,
    high: float,
) -> ThingPart:
    """A box along a wall, ``offset`` from its middle plane."""
    middle, length = (start + end) / 2, end - start
    if wall.along_x:
        return box(material, (length, thick, high - low), (middle, wall.position + offset, low))
    return box(
        material, (length, thick, high - low), (wall.position + offset, middle, low), np.pi / 2
    )
