"""Furniture of rooms at home."""

import numpy as np

from footprints_edge_models.scenes.assets.furniture import (
    bathroom,
    beds,
    equipment,
    kitchen,
    plants,
    seating,
    storage,
    tables,
)
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import placement
from footprints_edge_models.scenes.layout.rooms.arrangements import (
    lay_rug,
    near_middle,
    table_group,
)
from footprints_edge_models.scenes.layout.rooms.room import Room


def furnish_bathroom(palette: Palette, room: Room) -> None:
    """Furnish a bathroom."""
    rng = palette.rng
    if rng.random() < 0.75:
        room.put_at_wall(bathroom.tub(palette), rng)
    for make in (bathroom.basin, bathroom.toilet):
        room.put_at_wall(make(palette), rng, tries=14)
    if rng.random() < 0.5:
        room.put_at_wall(storage.cabinet(palette, 0.4, 0.35, float(rng.uniform(0.8, 1.8))), rng)
    if rng.random() < 0.6:
        lay_rug(
            palette,
            room,
            *near_middle(room, rng),
            float(rng.uniform(0.5, 1.0)),
            float(rng.uniform(0.4, 0.7)),
        )


def furnish_kitchen(palette: Palette, room: Room) -> None:
    """Furnish a kitchen."""
    rng = palette.rng
    for _ in range(int(rng.integers(1, 4))):
        room.put_at_wall(kitchen.counter(palette, float(rng.uniform(1.2, 3.2))), rng)
    room.put_at_wall(kitchen.fridge(palette), rng)
    if rng.random() < 0.3:
        room.put_anywhere(
            kitchen.counter(palette, float(rng.uniform(1.2, 2.4)), island=True), rng, margin_m=0.6
        )
    if rng.random() < 0.8:
        table_group(palette, room, float(rng.uniform(0.8, 2.0)), float(rng.uniform(0.7, 1.0)))


def furnish_living(palette: Palette, room: Room) -> None:
    """Furnish a living room."""
    rng = palette.rng
    wide, tall = float(rng.uniform(0.7, 2.2)), float(rng.uniform(0.8, 2.3))
    for _ in range(int(rng.integers(1, 3))):
        seats = int(rng.integers(1, 5))
        placed = room.put_at_wall(
            seating.sofa(palette, seats), rng, gap_m=float(rng.choice([0.03, 0.6]))
        )
        if placed is None:
            continue
        x, y, yaw = placed
        ahead = placement(0, 0, 0, yaw)[:2, :2] @ np.array([0, -1.15])
        if rng.random() < 0.7:
            low = tables.table(
                palette,
                float(rng.uniform(0.7, 1.3)),
                float(rng.uniform(0.5, 0.8)),
                float(rng.uniform(0.36, 0.5)),
            )
            room.put(low, x + ahead[0], y + ahead[1], yaw, 0.02)
        if rng.random() < 0.6:
            size = (2.4, 1.7) if abs(np.sin(yaw)) < 0.5 else (1.7, 2.4)
            lay_rug(palette, room, x + ahead[0], y + ahead[1], *size)
    if rng.random() < 0.6:
        room.put_at_wall(equipment.television(palette), rng)
    if rng.random() < 0.7:
        room.put_at_wall(storage.shelf(palette, wide, 0.3, tall), rng)
    for _ in range(int(rng.integers(0, 3))):
        room.put_at_wall(
            storage.cabinet(
                palette, float(rng.uniform(0.6, 1.6)), 0.42, float(rng.uniform(0.7, 1.9))
            ),
            rng,
        )
    for make in (plants.plant, equipment.floor_lamp, plants.plant):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng, gap_m=0.1)
    if room.inside.width * room.inside.depth > 20 and rng.random() < 0.6:
        table_group(palette, room, float(rng.uniform(0.9, 2.2)), float(rng.uniform(0.8, 1.1)))
    elif rng.random() < 0.5:
        room.put_anywhere(seating.chair(palette), rng)


def furnish_bedroom(palette: Palette, room: Room) -> None:
    """Furnish a bedroom."""
    rng = palette.rng
    placed = room.put_at_wall(beds.bed(palette), rng, tries=16)
    if placed is not None and rng.random() < 0.6:
        lay_rug(
            palette,
            room,
            placed[0],
            placed[1],
            float(rng.uniform(1.8, 3)),
            float(rng.uniform(1.8, 3)),
        )
    for _ in range(2):
        room.put_at_wall(storage.cabinet(palette, 0.45, 0.4, float(rng.uniform(0.4, 0.6))), rng)
    room.put_at_wall(
        storage.cabinet(palette, float(rng.uniform(0.9, 2.2)), 0.58, float(rng.uniform(1.8, 2.2))),
        rng,
    )
    for make in (
        tables.desk,
        seating.office_chair,
        plants.plant,
        lambda p: storage.cabinet(p, 1.0, 0.45, 0.85),
    ):
        if rng.random() < 0.45:
            room.put_at_wall(make(palette), rng)


def furnish_dining(palette: Palette, room: Room) -> None:
    """Furnish a dining room."""
    rng = palette.rng
    count = max(1, round(room.inside.width * room.inside.depth / rng.uniform(8, 18)))
    for _ in range(count):
        table_group(palette, room, float(rng.uniform(0.75, 2.2)), float(rng.uniform(0.75, 1.1)))
    for _ in range(2):
        room.put_at_wall(
            storage.cabinet(
                palette, float(rng.uniform(0.8, 2.0)), 0.45, float(rng.uniform(0.75, 1.8))
            ),
            rng,
        )
    if rng.random() < 0.5:
        room.put_at_wall(plants.plant(palette), rng)
