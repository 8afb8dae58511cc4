"""Furnished interiors: a floor plan with walls, doors, windows, light and furniture."""

from dataclasses import replace

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import Patch, Thing, box, joined, rectangle
from footprints_edge_models.scenes.layout.floor_plans import FloorPlan, Rect, draw_plan
from footprints_edge_models.scenes.layout.rooms import lived_in
from footprints_edge_models.scenes.layout.rooms.furnishing import furnish
from footprints_edge_models.scenes.layout.rooms.lighting import hang_lamps
from footprints_edge_models.scenes.layout.rooms.room import Room
from footprints_edge_models.scenes.layout.rooms.shell import build_walls
from footprints_edge_models.scenes.layout.scene import Lamp, Scene, Standpoint
from footprints_edge_models.scenes.layout.skies import draw_sky


def draw_rooms(palette: Palette) -> Scene:
    """A furnished floor plan."""
    rng = palette.rng
    plan = draw_plan(rng)
    half = plan.thickness_m / 2
    draw_kind = lived_in.draw_kind if palette.has_models else _draw_kind
    rooms = [Room(rect.grown(-half), draw_kind(rect, rng)) for rect in plan.rooms]
    day = rng.random() < 0.85
    sky = draw_sky(palette, bright=2.5 if day else 0.12)
    common_floor = palette.floor()
    ceiling = _ceiling_material(palette)
    ground = [
        Patch(
            rectangle(rect.x0, rect.y0, rect.x1, rect.y1),
            0.0,
            _floor_material(palette, room, common_floor),
        )
        for room, rect in zip(rooms, plan.rooms, strict=True)
    ]
    things = [_ceiling(plan, ceiling), *_beams(palette, plan)]
    papers = [_wall_material(palette, room) for room in rooms]
    lamps: list[Lamp] = []
    build_walls(palette, plan, rooms, papers, things, lamps, sky, day=day)
    for room in rooms:
        furnish(palette, room)
        things += room.things
        ground += room.rugs
        lights = hang_lamps(palette, room, plan.height_m, on=not day or rng.random() < 0.7)
        things += lights[0]
        lamps += lights[1]
    ambient = float(rng.uniform(0.12, 0.4))
    warm = float(rng.uniform(0.9, 1.06))
    return Scene(
        "rooms",
        tuple(ground),
        tuple(things),
        tuple(lamps),
        sky,
        (ambient * warm, ambient, ambient / warm),
        tuple(_standpoint(room, aimed=palette.has_models) for room in rooms),
    )


def _standpoint(room: Room, *, aimed: bool) -> Standpoint:
    """Where a camera may stand in a room, the more often the larger the room is.

    Those that are aimed look at its furniture, and stand in small rooms, too.
    """
    area = room.inside.width * room.inside.depth
    free = room.inside.grown(-0.35)
    place = Standpoint(free.x0, free.y0, free.x1, free.y1, area)
    return replace(place, weight=area**0.5, sights=_sights(room)) if aimed else place


def _sights(room: Room) -> tuple[tuple[float, float, float, float], ...]:
    """The furniture of a room: where it stands, half of its width and its height, up to 1.2 m."""
    found = []
    for thing in room.things:
        low, high = thing.extent
        half_m = float((high - low)[:2].max() / 2)
        if half_m > 0.2 and thing.outlines != ():
            x, y = (thing.pose[:, :3] @ ((low + high) / 2) + thing.pose[:, 3])[:2]
            found.append((float(x), float(y), min(half_m, 1.2), min(float(high[2]), 1.2)))
    return tuple(found)


def _ceiling(plan: FloorPlan, material: Material) -> Thing:
    width, depth = _extent(plan)
    slab = box(material, (width + 1, depth + 1, 0.2), (width / 2, depth / 2, plan.height_m))
    return joined("ceiling", [slab], outlines=(), is_wall=True)


def _beams(palette: Palette, plan: FloorPlan) -> list[Thing]:
    """Beams below the ceiling, in one interior of seven or so."""
    rng = palette.rng
    if rng.random() >= 0.15:
        return []
    width, depth = _extent(plan)
    beam = palette.wood()
    parts = [
        box(beam, (width, 0.15, 0.18), (width / 2, y, plan.height_m - 0.18))
        for y in np.arange(0.8, depth, float(rng.uniform(0.9, 2)))
    ]
    return [joined("beam", parts, outlines=())]


def _extent(plan: FloorPlan) -> tuple[float, float]:
    """Length of a plan along x and y; the last four walls are the outer ones."""
    outer = plan.walls[-4:]
    return outer[0].end, outer[2].end


def _draw_kind(rect: Rect, rng: np.random.Generator) -> str:
    area, narrow = rect.width * rect.depth, min(rect.width, rect.depth)
    if narrow < 2.5 and area > 8:
        return "corridor"
    if area < 8:
        return str(rng.choice(["bathroom", "kitchen", "store", "study"], p=[0.5, 0.2, 0.15, 0.15]))
    if area < 24:
        return str(
            rng.choice(
                ["bedroom", "kitchen", "living", "office", "dining", "bathroom", "meeting"],
                p=[0.22, 0.16, 0.18, 0.2, 0.1, 0.06, 0.08],
            )
        )
    return str(
        rng.choice(
            ["office", "living", "dining", "hall", "kitchen", "meeting"],
            p=[0.33, 0.27, 0.12, 0.13, 0.08, 0.07],
        )
    )


def _wall_material(palette: Palette, room: Room) -> Material:
    if room.kind in {"bathroom", "kitchen"} and palette.rng.random() < 0.4:
        return palette.of("tiles", "tiles", "marble", "plaster", tile_m=(0.5, 1.5), gloss=0.1)
    return palette.wall()


def _ceiling_material(palette: Palette) -> Material:
    if palette.rng.random() < 0.8:
        return palette.of("blank", "blank", "plaster", "tiles", tile_m=(1.2, 2.4))
    return palette.of("wood", "concrete", "planks")


def _floor_material(palette: Palette, room: Room, common: Material) -> Material:
    if room.kind in {"bathroom", "kitchen"} and palette.rng.random() < 0.6:
        return palette.floor("tiles", "tiles", "marble", "terrazzo", "planks")
    return common if palette.rng.random() < 0.7 else palette.floor()
