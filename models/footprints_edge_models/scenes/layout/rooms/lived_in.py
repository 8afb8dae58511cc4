"""Rooms as full as real ones: beds that fill a picture, cupboards from wall to wall, rows of seats.

Of scenes with 3D models alone: rooms without keep their furniture, byte for byte.
"""

from collections.abc import Callable

import numpy as np

from footprints_edge_models.scenes.assets.furniture import (
    beds,
    equipment,
    kitchen,
    seating,
    storage,
    tables,
)
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Thing, placement
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.rooms.arrangements import lay_rug, near_middle
from footprints_edge_models.scenes.layout.rooms.home_rooms import furnish_living
from footprints_edge_models.scenes.layout.rooms.room import YAWS, Room
from footprints_edge_models.scenes.layout.rooms.work_rooms import furnish_corridor, furnish_office

Placed = tuple[float, float, float]
"""x, y and yaw of what stands in a room."""

_SMALL = {"bathroom": 0.35, "kitchen": 0.35, "store": 0.1, "study": 0.2}
_MIDDLE = {
    "bedroom": 0.38, "kitchen": 0.2, "living": 0.16, "office": 0.08, "dining": 0.06,
    "meeting": 0.05, "seats": 0.04, "bathroom": 0.03,
}  # fmt: skip
_LARGE = {
    "living": 0.24, "office": 0.18, "seats": 0.16, "bedroom": 0.12, "shop": 0.1, "dining": 0.08,
    "hall": 0.06, "kitchen": 0.06,
}  # fmt: skip


def draw_kind(rect: Rect, rng: np.random.Generator) -> str:
    """A room's use, by its size."""
    area, narrow = rect.width * rect.depth, min(rect.width, rect.depth)
    if narrow < 2.5 and area > 8:
        return "corridor" if rng.random() < 0.7 else "kitchen"
    shares = _SMALL if area < 8 else _MIDDLE if area < 24 else _LARGE
    return str(rng.choice(list(shares), p=list(shares.values())))


def furnish_bedroom(palette: Palette, room: Room) -> None:
    """A bed between bedside tables, an armchair, a desk, cupboards along a wall."""
    rng = palette.rng
    bed = beds.covered_bed(palette) if rng.random() < 0.5 else beds.bed(palette)
    placed = room.put_at_wall(bed, rng, tries=20)
    if placed is not None:
        _beside_bed(palette, room, bed, placed)
        if rng.random() < 0.4:
            lay_rug(palette, room, *placed[:2], *(float(v) for v in rng.uniform(1.8, 3.2, 2)))
    if rng.random() < 0.6:
        _cupboards(palette, room)
    if rng.random() < 0.5:
        _easy_chair(palette, room)
    if rng.random() < 0.5:
        _desk(palette, room)
    if rng.random() < 0.5:
        wide, tall = float(rng.uniform(0.8, 1.6)), float(rng.uniform(0.7, 1.1))
        room.put_at_wall(storage.cabinet(palette, wide, 0.48, tall), rng)


def furnish_kitchen(palette: Palette, room: Room) -> None:
    """Worktops from wall to wall along one wall or two, a fridge, a table with chairs."""
    rng = palette.rng
    first = int(rng.integers(4))
    second = (first + int(rng.choice([1, 2, 3], p=[0.35, 0.3, 0.35]))) % 4
    for side in (first, second) if rng.random() < 0.65 else (first,):
        room.run_along_wall(
            side, lambda wide: kitchen.counter(palette, wide), 0.64, float(rng.uniform(1.8, 4.8))
        )
    room.put_at_wall(kitchen.fridge(palette), rng, tries=12)
    area = room.inside.width * room.inside.depth
    if area > 14 and rng.random() < 0.3:
        island = kitchen.counter(palette, float(rng.uniform(1.2, 2.4)), island=True)
        room.put(island, *near_middle(room, rng), YAWS[first], 0.5)
    elif area > 8 and rng.random() < 0.6:
        table_with_chairs(
            palette, room, float(rng.uniform(0.7, 1.8)), float(rng.uniform(0.7, 0.95))
        )


def furnish_full_living(palette: Palette, room: Room) -> None:
    """A living room with easy chairs, and shelves or cupboards along a wall."""
    rng = palette.rng
    furnish_living(palette, room)
    for _ in range(int(rng.integers(0, 3))):
        _easy_chair(palette, room)
    if rng.random() < 0.4:
        tall = float(rng.uniform(0.8, 2.2))
        room.run_along_wall(
            int(rng.integers(4)),
            lambda wide: storage.shelf(palette, wide, 0.32, tall),
            0.36,
            float(rng.uniform(1.2, 3.5)),
            past_windows=False,
        )


def furnish_full_office(palette: Palette, room: Room) -> None:
    """An office, half of them with cupboards from wall to wall."""
    if palette.rng.random() < 0.5:
        _cupboards(palette, room)
    furnish_office(palette, room)


def furnish_full_corridor(palette: Palette, room: Room) -> None:
    """A corridor, some with cupboards or lockers along it."""
    if palette.rng.random() < 0.3:
        _cupboards(palette, room)
    furnish_corridor(palette, room)


def furnish_full_dining(palette: Palette, room: Room) -> None:
    """Tables amid sets of chairs that are alike, as in a dining room or a café."""
    rng = palette.rng
    area = room.inside.width * room.inside.depth
    for _ in range(max(1, round(area / rng.uniform(7, 16)))):
        table_with_chairs(
            palette, room, float(rng.uniform(0.7, 2.2)), float(rng.uniform(0.7, 1.05))
        )
    if rng.random() < 0.6:
        wide, tall = float(rng.uniform(0.9, 2.2)), float(rng.uniform(0.75, 1.2))
        room.put_at_wall(storage.cabinet(palette, wide, 0.45, tall), rng)


def furnish_seats(palette: Palette, room: Room) -> None:
    """Rows of equal chairs, as in a lecture room or a waiting room; some rows with desks."""
    rng = palette.rng
    side = int(rng.integers(4))
    chair = seating.office_chair(palette) if rng.random() < 0.15 else seating.chair(palette)
    with_desks = rng.random() < 0.35
    desk = tables.built_table(palette, float(rng.uniform(0.7, 1.4)), 0.5, 0.73, laid=0.3)
    chair_m = float(np.ptp([corner[0] for corner in chair.extent]))
    beside_m = (float(rng.uniform(0.75, 1.6)) if with_desks else chair_m) + float(
        rng.choice([0.03, 0.1, 0.4])
    )
    behind_m = float(rng.uniform(1.3, 1.7) if with_desks else rng.uniform(0.8, 1.2))
    margin = float(rng.uniform(0.5, 1.2))
    along, back = np.meshgrid(
        np.arange(margin, room.span_m(side) - margin, beside_m),
        np.arange(0.6, room.span_m(side + 1) - 1.5, behind_m),
    )
    kept = rng.random(along.shape) > 0.05
    for a, b in zip(along[kept][:40], back[kept][:40], strict=True):
        x, y = room.at_wall(side, float(a), float(b))
        jitter = rng.normal(0, 0.02, 3)
        placed = (x + float(jitter[0]), y + float(jitter[1]), YAWS[side] + float(jitter[2]))
        if room.put(chair, *placed, 0.0) and with_desks:
            _put_beside(room, desk, placed, 0.0, 0.55)
    for make in (equipment.whiteboard, equipment.television):
        if rng.random() < 0.4:
            room.put_at_wall(make(palette), rng)


def furnish_shop(palette: Palette, room: Room) -> None:
    """Racks in rows with aisles between them, tables with goods, a counter."""
    rng = palette.rng
    side = int(rng.integers(4))
    wide, tall = float(rng.uniform(0.9, 1.6)), float(rng.uniform(1.1, 2.0))
    rack = storage.shelf(palette, wide, 0.4, tall)
    low, high = rack.extent
    aisle_m = float(rng.uniform(1.1, 2.2))
    deep_m = float(high[1] - low[1])
    for back in np.arange(1.0, room.span_m(side + 1) - 1.4, 2 * deep_m + aisle_m):
        for along in np.arange(0.9 + wide / 2, room.span_m(side) - 0.9, float(high[0] - low[0])):
            if rng.random() < 0.12:
                continue
            for ahead, turn in ((0.0, 0.0), (deep_m + 0.01, np.pi)):
                x, y = room.at_wall(side, float(along), float(back) + ahead)
                room.put(rack, x, y, YAWS[side] + turn, -0.002)
    for _ in range(rng.poisson(2)):
        room.put_anywhere(tables.table(palette, 1.3, 0.8, float(rng.uniform(0.5, 0.9))), rng)
    room.put_at_wall(kitchen.counter(palette, 2.0, island=True), rng, gap_m=0.8)


def table_with_chairs(palette: Palette, room: Room, width_m: float, depth_m: float) -> None:
    """A table somewhere in the room with chairs of one kind around it, pushed in or pulled out."""
    rng = palette.rng
    table = tables.table(palette, width_m, depth_m, float(rng.uniform(0.71, 0.77)))
    chair = seating.chair(palette, palette.main_wood(), None)
    low, high = table.extent
    half_x, half_y = (float(v) for v in (high - low)[:2] / 2)
    for _ in range(12):
        x, y = (
            float(rng.uniform(room.inside.x0, room.inside.x1)),
            float(rng.uniform(room.inside.y0, room.inside.y1)),
        )
        yaw = float(rng.choice(YAWS)) + float(rng.choice([0.0, rng.normal(0, 0.2)]))
        if not room.put(table, x, y, yaw, 0.5):
            continue
        for quarter in range(4):
            across, away = (half_x, half_y) if quarter % 2 == 0 else (half_y, half_x)
            count = int(2 * across / 0.6)
            for index in range(count):
                if rng.random() < 0.12:
                    continue
                out = away + float(rng.choice([-0.1, 0.1, 0.35], p=[0.4, 0.4, 0.2]))
                along = (index + 0.5) * 2 * across / count - across
                turn = yaw + YAWS[quarter]
                offset = placement(0, 0, 0, turn)[:2, :2] @ np.array([along, out])
                pose = turn + float(rng.normal(0, 0.1))
                # under the table's edge: what it takes overlaps the table's
                room.things.append(chair.at(x + offset[0], y + offset[1], 0.0, pose))
        return


def _beside_bed(palette: Palette, room: Room, bed: Thing, placed: Placed) -> None:
    """Bedside tables, and sometimes a bench at the foot."""
    rng = palette.rng
    low, high = bed.extent
    table = storage.cabinet(
        palette, float(rng.uniform(0.38, 0.6)), 0.4, float(rng.uniform(0.4, 0.65))
    )
    least, most = table.extent
    gap = float(rng.uniform(0.03, 0.2))
    for right in (float(high[0] - least[0]) + gap, float(low[0] - most[0]) - gap):
        if rng.random() < 0.85:
            _put_beside(room, table, placed, right, float(most[1] - high[1]))
    if rng.random() < 0.25:
        bench = storage.built_cabinet(palette, 1.1, 0.42, 0.45, laid=False)
        _put_beside(room, bench, placed, 0.0, 0.35 - float(low[1]))


def _easy_chair(palette: Palette, room: Room) -> None:
    """An armchair, often turned from its corner, some with a footstool."""
    rng = palette.rng
    placed = room.put_at_wall(
        seating.sofa(palette, 1), rng, gap_m=float(rng.uniform(0.03, 0.5)), tries=12
    )
    if placed is not None and rng.random() < 0.5:
        stool = seating.footstool(palette)
        _put_beside(room, stool, placed, float(rng.normal(0, 0.1)), float(rng.uniform(0.75, 1.0)))


def _desk(palette: Palette, room: Room) -> None:
    """A desk at a wall with its chair."""
    rng = palette.rng
    placed = room.put_at_wall(tables.desk(palette), rng, tries=12)
    if placed is not None:
        chair = seating.office_chair(palette) if rng.random() < 0.7 else seating.chair(palette)
        turn = np.pi + float(rng.normal(0, 0.6))
        _put_beside(
            room, chair, placed, float(rng.normal(0, 0.15)), float(rng.uniform(0.6, 1.0)), turn
        )


def _cupboards(palette: Palette, room: Room) -> None:
    """Cupboards from the floor, from wall to wall if it is free."""
    rng = palette.rng
    deep, tall = float(rng.uniform(0.38, 0.66)), float(rng.uniform(1.7, 2.35))
    room.run_along_wall(
        int(rng.integers(4)),
        lambda wide: storage.fitted_cupboard(palette, wide, deep, tall),
        deep + 0.05,
        float(rng.uniform(1.2, 5.0)),
        past_windows=False,
    )


def _put_beside(
    room: Room, thing: Thing, placed: Placed, right_m: float, ahead_m: float, turn: float = 0.0
) -> bool:
    """Place a thing beside another: to its right, and ahead of it."""
    x, y, yaw = placed
    step = placement(0, 0, 0, yaw)[:2, :2] @ np.array([right_m, -ahead_m])
    return room.put(thing, x + float(step[0]), y + float(step[1]), yaw + turn, 0.0)


LIVED_IN: dict[str, Callable[[Palette, Room], None]] = {
    "bedroom": furnish_bedroom,
    "kitchen": furnish_kitchen,
    "living": furnish_full_living,
    "office": furnish_full_office,
    "corridor": furnish_full_corridor,
    "dining": furnish_full_dining,
    "seats": furnish_seats,
    "shop": furnish_shop,
}
"""By kind of room; the others are furnished as in ``furnishing.FURNISHERS``."""
