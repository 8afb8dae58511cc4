"""The shell of an interior: its walls with doors, windows and skirting boards."""

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, joined
from footprints_edge_models.scenes.layout.floor_plans import FloorPlan, Rect
from footprints_edge_models.scenes.layout.rooms.lighting import window_light
from footprints_edge_models.scenes.layout.rooms.openings import glaze, hang_door
from footprints_edge_models.scenes.layout.rooms.room import Room
from footprints_edge_models.scenes.layout.rooms.walls import rooms_along, solid_stretches, wall_box
from footprints_edge_models.scenes.layout.scene import Lamp, Sky


def build_walls(
    palette: Palette,
    plan: FloorPlan,
    rooms: list[Room],
    papers: list[Material],
    things: list[Thing],
    lamps: list[Lamp],
    sky: Sky,
    *,
    day: bool,
) -> None:
    """Add a plan's walls, doors and windows to ``things`` and its daylight to ``lamps``."""
    rng = palette.rng
    frame, skirting = palette.of("blank", "plaster", "wood"), palette.of("blank", "wood", "plaster")
    leaf = palette.of("wood", "plain", "plaster", "blank", gloss=0.04)
    skirting_m = float(rng.choice([0.0, 0.06, 0.1, 0.14]))
    has_curtains = rng.random() < 0.45
    for wall in plan.walls:
        for side in (-1, 1):
            parts: list[ThingPart] = []
            if wall.inside and side != wall.inside:
                continue
            # one leaf of the wall for each side; it takes the paper of the room there
            for start, end, low, high in solid_stretches(wall, plan.height_m):
                for lower, upper, room_index in rooms_along(wall, side, start, end, rooms):
                    half = plan.thickness_m / 2 * (1 if not wall.inside else 2)
                    offset = side * half / 2 if not wall.inside else 0.0
                    material = papers[room_index]
                    parts.append(wall_box(wall, material, lower, upper, offset, half, low, high))
                    if low == 0 and skirting_m and high > 0.5:
                        away = side * (plan.thickness_m / 2 + 0.006)
                        parts.append(
                            wall_box(wall, skirting, lower, upper, away, 0.012, 0, skirting_m)
                        )
            things.append(joined("wall", parts, is_wall=True))
        for opening in wall.openings:
            if opening.is_door:
                hang_door(palette, wall, opening, plan, rooms, things, frame, leaf)
            elif opening.bottom > 0 or wall.inside:
                glaze(palette, wall, opening, plan, things, frame, curtains=has_curtains)
                if day:
                    lamps.append(window_light(wall, opening, sky))
            middle = (opening.start + opening.end) / 2
            x, y = (middle, wall.position) if wall.along_x else (wall.position, middle)
            reach = max(0.5, (opening.end - opening.start) / 2 + 0.05)
            place = Rect(x - reach, y - reach, x + reach, y + reach)
            for room in rooms:
                room.openings.append(place)
                if not wall.inside:
                    room.taken.append(place)
