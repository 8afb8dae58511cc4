"""Furniture of rooms at work and in public: offices, corridors, halls, stores."""

import numpy as np

from footprints_edge_models.scenes.assets.furniture import (
    clutter,
    equipment,
    kitchen,
    plants,
    seating,
    storage,
    tables,
)
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.people import seated_parts, standing
from footprints_edge_models.scenes.assets.things import box, column, extended, joined, placement
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.rooms.arrangements import (
    lay_rug,
    near_middle,
    table_group,
)
from footprints_edge_models.scenes.layout.rooms.room import Room


def furnish_office(palette: Palette, room: Room) -> None:
    """Furnish an office or a study."""
    rng = palette.rng
    area = room.inside.width * room.inside.depth
    for _ in range(max(1, round(area / rng.uniform(5, 10)))):
        made = tables.desk(palette)
        placed: tuple[float, float, float] | None
        if rng.random() < 0.65 or area < 14:
            placed = room.put_at_wall(made, rng)
        else:
            x, y = near_middle(room, rng)
            yaw = float(rng.choice([0, np.pi / 2, np.pi, -np.pi / 2]))
            placed = (x, y, yaw) if room.put(made, x, y, yaw, 0.25) else None
        if placed is not None:
            x, y, yaw = placed
            ahead = placement(0, 0, 0, yaw)[:2, :2] @ np.array(
                [rng.normal(0, 0.15), -rng.uniform(0.4, 0.9)]
            )
            thing = seating.office_chair(palette) if rng.random() < 0.8 else seating.chair(palette)
            turn = yaw + np.pi + float(rng.normal(0, 0.5))
            if rng.random() < 0.12:
                thing = extended(thing, "person", seated_parts(palette, 0.5))
            room.things.append(thing.at(x + ahead[0], y + ahead[1], 0.0, turn))
            room.taken.append(
                Rect(x + ahead[0] - 0.3, y + ahead[1] - 0.3, x + ahead[0] + 0.3, y + ahead[1] + 0.3)
            )
    for _ in range(int(rng.integers(1, 4))):
        dice = rng.random()
        if dice < 0.5:
            thing = storage.cabinet(
                palette, float(rng.uniform(0.5, 1.8)), 0.45, float(rng.uniform(0.7, 2.0))
            )
        elif dice < 0.8:
            thing = storage.shelf(
                palette, float(rng.uniform(0.7, 2)), 0.32, float(rng.uniform(0.8, 2.1))
            )
        else:
            thing = equipment.machine(palette)
        room.put_at_wall(thing, rng)
    for make, share in (
        (plants.plant, 0.5),
        (equipment.whiteboard, 0.3),
        (lambda p: seating.sofa(p, 1), 0.2),
    ):
        if rng.random() < share:
            room.put_at_wall(make(palette), rng, gap_m=0.05)


def furnish_meeting(palette: Palette, room: Room) -> None:
    """Furnish a meeting room."""
    rng = palette.rng
    inside = room.inside
    wide = float(np.clip(inside.width - 2.0, 0.9, rng.uniform(1.6, 4.5)))
    deep = float(np.clip(inside.depth - 2.0, 0.8, rng.uniform(0.9, 1.6)))
    table_group(palette, room, wide, deep, office=rng.random() < 0.6)
    for make in (equipment.whiteboard, plants.plant, equipment.television):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng)


def furnish_corridor(palette: Palette, room: Room) -> None:
    """Furnish a corridor."""
    rng = palette.rng
    for _ in range(rng.poisson(1.2)):
        dice = rng.random()
        if dice < 0.4:
            thing = storage.cabinet(
                palette, float(rng.uniform(0.5, 1.4)), 0.38, float(rng.uniform(0.7, 1.9))
            )
        elif dice < 0.6:
            thing = plants.plant(palette)
        elif dice < 0.8:
            thing = seating.chair(palette)
        else:
            thing = equipment.machine(palette)
        room.put_at_wall(thing, rng)
    if rng.random() < 0.3:
        lay_rug(palette, room, *near_middle(room, rng), 3.0, 0.9)


def furnish_hall(palette: Palette, room: Room) -> None:
    """Furnish a hall with columns."""
    rng = palette.rng
    inside = room.inside
    shaft = palette.of("concrete", "plaster", "marble", "tiles", tile_m=1.0)
    wide = float(rng.uniform(0.3, 0.7))
    round_ = rng.random() < 0.5
    step_x, step_y = rng.uniform(2.5, 5, 2)
    for x in np.arange(inside.x0 + step_x / 2, inside.x1, step_x):
        for y in np.arange(inside.y0 + step_y / 2, inside.y1, step_y):
            part = (
                column(shaft, wide, 4.6, (0, 0, 0))
                if round_
                else box(shaft, (wide, wide, 4.6), (0, 0, 0))
            )
            plinth = box(
                palette.of("marble", "concrete"), (wide + 0.06, wide + 0.06, 0.25), (0, 0, 0)
            )
            if rng.random() < 0.8:
                room.put(joined("column", [part, plinth]), float(x), float(y), 0.0)
    for _ in range(rng.poisson(3)):
        room.put_anywhere(seating.sofa(palette, int(rng.integers(1, 4))), rng, margin_m=0.2)
    for _ in range(rng.poisson(2)):
        table_group(palette, room, float(rng.uniform(0.7, 1.2)), float(rng.uniform(0.7, 1.2)))
    for _ in range(rng.poisson(3)):
        room.put_anywhere(standing(palette), rng, margin_m=0.1)
    for make in (
        lambda p: kitchen.counter(p, 2.5, island=True),
        plants.plant,
        plants.plant,
        equipment.machine,
    ):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng, gap_m=0.3)


def furnish_store(palette: Palette, room: Room) -> None:
    """Furnish a store room."""
    rng = palette.rng
    for _ in range(3):
        room.put_at_wall(
            storage.shelf(palette, float(rng.uniform(0.7, 1.5)), 0.4, float(rng.uniform(1, 2))),
            rng,
        )
    for _ in range(5):
        room.put_at_wall(clutter.clutter(palette), rng)
    room.put_at_wall(equipment.machine(palette), rng)
