"""Furnished rooms: a floor plan with walls, doors, windows, light and furniture."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from footprints_edge_models.scenes.assets import furniture
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.people import seated_parts, standing
from footprints_edge_models.scenes.assets.things import (
    Part,
    Patch,
    Thing,
    blob,
    box,
    column,
    joined,
    placement,
    rectangle,
    rod,
)
from footprints_edge_models.scenes.layout.plans import Opening, Plan, Rect, Wall, draw_plan
from footprints_edge_models.scenes.layout.scene import Lamp, Scene, Sky, Standpoint
from footprints_edge_models.scenes.layout.skies import draw_sky

CROWDED = 0.75
"""Share of rooms with clutter on their floors."""


@dataclass
class Room:
    """A room while it is furnished.

    Attributes:
        inside: its floor, up to the walls.
        kind: what it is for.
        taken: where things stand, or doors need space.
        openings: where its walls have doors and windows.
        things: what stands there.
        rugs: walkable patches on its floor.
    """

    inside: Rect
    kind: str
    taken: list[Rect] = field(default_factory=list)
    openings: list[Rect] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    rugs: list[Patch] = field(default_factory=list)

    def is_free(self, place: Rect) -> bool:
        """Whether a place lies inside and nothing stands there."""
        room = self.inside
        fits = (
            place.x0 >= room.x0
            and place.y0 >= room.y0
            and place.x1 <= room.x1
            and place.y1 <= room.y1
        )
        return fits and not any(place.meets(other) for other in self.taken)

    def put(self, thing: Thing, x: float, y: float, yaw: float, margin_m: float = 0.02) -> bool:
        """Stands a thing somewhere, if there is room for it."""
        place = _place_of(thing, x, y, yaw).grown(margin_m)
        if not self.is_free(place):
            return False
        self.taken.append(place)
        self.things.append(thing.at(x, y, 0.0, yaw))
        return True

    def put_at_wall(
        self, thing: Thing, rng: np.random.Generator, *, gap_m: float = 0.02, tries: int = 8
    ) -> tuple[float, float, float] | None:
        """Stands a thing with its back to a wall; returns x, y and yaw."""
        low, high = thing.extent
        for _ in range(tries):
            side = int(rng.integers(4))
            yaw = (0.0, np.pi / 2, np.pi, -np.pi / 2)[side]
            room = self.inside
            back = float(high[1]) + gap_m
            left, right = -float(low[0]), float(high[0])
            span = room.width if side % 2 == 0 else room.depth
            if left + right + 0.1 > span:
                continue
            along = float(rng.uniform(left + 0.03, span - right - 0.03))
            if rng.random() < 0.3:
                along = left + 0.03
            x, y = (
                (room.x0 + along, room.y1 - back),
                (room.x0 + back, room.y0 + along),
                (room.x1 - along, room.y0 + back),
                (room.x1 - back, room.y1 - along),
            )[side]
            if self.put(thing, x, y, float(yaw), 0.0):
                return x, y, float(yaw)
        return None

    def put_anywhere(
        self, thing: Thing, rng: np.random.Generator, *, margin_m: float = 0.05
    ) -> None:
        """Stands a thing at a random place, turned at random."""
        for _ in range(6):
            x = float(rng.uniform(self.inside.x0, self.inside.x1))
            y = float(rng.uniform(self.inside.y0, self.inside.y1))
            if self.put(thing, x, y, float(rng.uniform(-np.pi, np.pi)), margin_m):
                return


def _place_of(thing: Thing, x: float, y: float, yaw: float) -> Rect:
    low, high = thing.extent
    corners = rectangle(low[0], low[1], high[0], high[1]) @ placement(0, 0, 0, yaw)[:2, :2].T
    least, most = (op(corners, axis=0) + np.array((x, y)) for op in (np.min, np.max))
    return Rect(float(least[0]), float(least[1]), float(most[0]), float(most[1]))


def draw_rooms(palette: Palette) -> Scene:
    """A furnished floor plan."""
    rng = palette.rng
    plan = draw_plan(rng)
    half = plan.thickness_m / 2
    rooms = [Room(rect.grown(-half), _kind(rect, rng)) for rect in plan.rooms]
    day = rng.random() < 0.85
    sky = draw_sky(palette, bright=2.5 if day else 0.12)
    common_floor = palette.floor()
    things: list[Thing] = []
    ground: list[Patch] = []
    ceiling = (
        palette.of("blank", "blank", "plaster", "tiles", tile_m=(1.2, 2.4))
        if rng.random() < 0.8
        else palette.of("wood", "concrete", "planks")
    )
    floors = []
    for room, rect in zip(rooms, plan.rooms, strict=True):
        tiled = room.kind in {"bathroom", "kitchen"} and rng.random() < 0.6
        floor = (
            palette.floor("tiles", "tiles", "marble", "terrazzo", "planks")
            if tiled
            else common_floor
            if rng.random() < 0.7
            else palette.floor()
        )
        floors.append(floor)
        ground.append(Patch(rectangle(rect.x0, rect.y0, rect.x1, rect.y1), 0.0, floor))
    outer = plan.walls[-4:]
    x1, y1 = outer[0].end, outer[2].end
    things.append(
        joined(
            "ceiling",
            [box(ceiling, (x1 + 1, y1 + 1, 0.2), (x1 / 2, y1 / 2, plan.height_m))],
            outlines=(),
            is_wall=True,
        )
    )
    if rng.random() < 0.15:
        beam = palette.wood()
        parts = [
            box(beam, (x1, 0.15, 0.18), (x1 / 2, y, plan.height_m - 0.18))
            for y in np.arange(0.8, y1, float(rng.uniform(0.9, 2)))
        ]
        things.append(joined("beam", parts, outlines=()))
    papers = [_wall_material(palette, room) for room in rooms]
    lamps: list[Lamp] = []
    _build_walls(palette, plan, rooms, papers, things, lamps, sky, day=day)
    for room in rooms:
        _furnish(palette, room)
        things += room.things
        ground += room.rugs
        lights = _light(palette, room, plan.height_m, on=not day or rng.random() < 0.7)
        things += lights[0]
        lamps += lights[1]
    ambient = float(rng.uniform(0.12, 0.4))
    warm = float(rng.uniform(0.9, 1.06))
    points = tuple(
        Standpoint(
            r.inside.x0 + 0.35,
            r.inside.y0 + 0.35,
            r.inside.x1 - 0.35,
            r.inside.y1 - 0.35,
            r.inside.width * r.inside.depth,
        )
        for r in rooms
    )
    return Scene(
        "rooms",
        tuple(ground),
        tuple(things),
        tuple(lamps),
        sky,
        (ambient * warm, ambient, ambient / warm),
        points,
    )


def _kind(rect: Rect, rng: np.random.Generator) -> str:
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


def _build_walls(
    palette: Palette,
    plan: Plan,
    rooms: list[Room],
    papers: list[Material],
    things: list[Thing],
    lamps: list[Lamp],
    sky: Sky,
    *,
    day: bool,
) -> None:
    rng = palette.rng
    frame, skirting = palette.of("blank", "plaster", "wood"), palette.of("blank", "wood", "plaster")
    leaf = palette.of("wood", "plain", "plaster", "blank", gloss=0.04)
    skirting_m = float(rng.choice([0.0, 0.06, 0.1, 0.14]))
    has_curtains = rng.random() < 0.45
    for wall in plan.walls:
        for side in (-1, 1):
            parts: list[Part] = []
            if wall.inside and side != wall.inside:
                continue
            # one leaf of the wall for each side; it takes the paper of the room there
            for start, end, low, high in _pieces(wall, plan.height_m):
                for lower, upper, room_index in _rooms_along(wall, side, start, end, rooms):
                    half = plan.thickness_m / 2 * (1 if not wall.inside else 2)
                    offset = side * half / 2 if not wall.inside else 0.0
                    material = papers[room_index]
                    parts.append(_wall_box(wall, material, lower, upper, offset, half, low, high))
                    if low == 0 and skirting_m and high > 0.5:
                        away = side * (plan.thickness_m / 2 + 0.006)
                        parts.append(
                            _wall_box(wall, skirting, lower, upper, away, 0.012, 0, skirting_m)
                        )
            things.append(joined("wall", parts, is_wall=True))
        for opening in wall.openings:
            if opening.is_door:
                _hang_door(palette, wall, opening, plan, rooms, things, frame, leaf)
            elif opening.bottom > 0 or wall.inside:
                _glaze(palette, wall, opening, plan, things, frame, curtains=has_curtains)
                if day:
                    lamps.append(_window_light(wall, opening, sky))
            middle = (opening.start + opening.end) / 2
            x, y = (middle, wall.position) if wall.along_x else (wall.position, middle)
            reach = max(0.5, (opening.end - opening.start) / 2 + 0.05)
            place = Rect(x - reach, y - reach, x + reach, y + reach)
            for room in rooms:
                room.openings.append(place)
                if not wall.inside:
                    room.taken.append(place)


def _pieces(wall: Wall, height_m: float) -> list[tuple[float, float, float, float]]:
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


def _rooms_along(
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


def _wall_box(
    wall: Wall,
    material: Material,
    start: float,
    end: float,
    offset: float,
    thick: float,
    low: float,
    high: float,
) -> Part:
    middle, length = (start + end) / 2, end - start
    if wall.along_x:
        return box(material, (length, thick, high - low), (middle, wall.position + offset, low))
    return box(
        material, (length, thick, high - low), (wall.position + offset, middle, low), np.pi / 2
    )


def _hang_door(
    palette: Palette,
    wall: Wall,
    hole: Opening,
    plan: Plan,
    rooms: list[Room],
    things: list[Thing],
    frame: Material,
    leaf: Material,
) -> None:
    rng = palette.rng
    jambs = [
        _wall_box(wall, frame, at - 0.03, at + 0.03, 0, plan.thickness_m + 0.03, 0, hole.top)
        for at in (hole.start, hole.end)
    ]
    things.append(joined("door frame", jambs, is_wall=True))
    lintel = _wall_box(
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
        place = _place_of(door, x, y, base + swing).grown(0.05)
        for room in rooms:
            room.taken.append(place)


def _glaze(
    palette: Palette,
    wall: Wall,
    hole: Opening,
    plan: Plan,
    things: list[Thing],
    frame: Material,
    *,
    curtains: bool,
) -> None:
    rng = palette.rng
    thick = 0.06
    parts = [
        _wall_box(wall, frame, at - 0.04, at + 0.04, 0, thick, hole.bottom, hole.top)
        for at in (hole.start + 0.04, hole.end - 0.04)
    ]
    parts += [
        _wall_box(wall, frame, hole.start, hole.end, 0, thick, z, z + 0.08)
        for z in (hole.bottom, hole.top - 0.08)
    ]
    for index in range(1, round((hole.end - hole.start) / 0.9) + 1):
        at = hole.start + index * (hole.end - hole.start) / (
            round((hole.end - hole.start) / 0.9) + 1
        )
        parts.append(_wall_box(wall, frame, at - 0.03, at + 0.03, 0, thick, hole.bottom, hole.top))
    sill = wall.inside * (plan.thickness_m / 2 + 0.08)
    if hole.bottom > 0.3:
        parts.append(
            _wall_box(
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
                    _wall_box(
                        wall, cloth, at, at + 0.065, depth, 0.04, max(low, 0.03), hole.top + 0.12
                    )
                )
        things.append(joined("curtain", folds))
    elif rng.random() < 0.3:
        slat = palette.of("blank", "metal", "wood")
        drop = float(rng.uniform(0.2, 1)) * (hole.top - hole.bottom)
        inner = wall.inside * (plan.thickness_m / 2 + 0.03)
        rows = [
            _wall_box(wall, slat, hole.start, hole.end, inner, 0.035, z, z + 0.006)
            for z in np.arange(hole.top - drop, hole.top, 0.045)
        ]
        things.append(joined("blind", rows))


def _window_light(wall: Wall, hole: Opening, sky: Sky) -> Lamp:
    middle, wide, tall = (hole.start + hole.end) / 2, hole.end - hole.start, hole.top - hole.bottom
    z = (hole.top + hole.bottom) / 2
    inner = wall.position + wall.inside * 0.2
    strength = 0.35 * wide * tall
    red, green, blue = (float(strength * c) for c in sky.horizon)
    power = (red, green, blue)
    if wall.along_x:
        return Lamp((middle, inner, z), (wide, 0.02, tall), power)
    return Lamp((inner, middle, z), (0.02, wide, tall), power)


def _light(
    palette: Palette, room: Room, height_m: float, *, on: bool
) -> tuple[list[Thing], list[Lamp]]:
    """Lamps at the ceiling."""
    rng = palette.rng
    inside = room.inside
    columns, rows = (
        max(1, round(inside.width / rng.uniform(2.5, 4.5))),
        max(1, round(inside.depth / rng.uniform(2.5, 4.5))),
    )
    warm = float(rng.uniform(0.0, 0.35))
    colour = np.array([1.0 + warm * 0.4, 1.0, 1.0 - warm * 0.8])
    style = rng.integers(4)
    things, lamps = [], []
    for index in range(columns * rows):
        x = inside.x0 + (index % columns + 0.5) * inside.width / columns
        y = inside.y0 + (index // columns + 0.5) * inside.depth / rows
        glowing = palette.white(glow=2.5 if on else 0.0)
        if style == 0:
            part, z = box(glowing, (0.6, 0.6, 0.03), (x, y, height_m - 0.03)), height_m - 0.08
        elif style == 1:
            part, z = box(glowing, (0.14, 1.2, 0.06), (x, y, height_m - 0.06)), height_m - 0.12
        elif style == 2:
            part, z = column(glowing, 0.2, 0.03, (x, y, height_m - 0.03)), height_m - 0.08
        else:
            drop = float(rng.uniform(0.3, 0.9)) if height_m > 2.6 else 0.3
            z = height_m - drop
            part = blob(glowing, (0.3, 0.3, 0.22), (x, y, z))
            things.append(
                joined(
                    "lamp cord",
                    [rod(palette.dark(), (x, y, z + 0.2), (x, y, height_m), 0.01)],
                    outlines=(),
                )
            )
            z -= 0.05
        things.append(joined("ceiling lamp", [part], outlines=()))
        if on:
            share = 3.2 * (inside.width * inside.depth / (columns * rows)) / 9
            red, green, blue = (float(c) for c in colour * share)
            lamps.append(Lamp((x, y, z), (0.5, 0.5, 0.02), (red, green, blue)))
    return things, lamps


def _furnish(palette: Palette, room: Room) -> None:
    rng = palette.rng
    FURNISHERS[room.kind](palette, room)
    if room.kind not in {"corridor", "bathroom", "store"}:
        _line_walls(palette, room)
    _hang(palette, room)
    if rng.random() < CROWDED:
        area = room.inside.width * room.inside.depth
        for _ in range(rng.poisson(min(6.0, 0.33 * area))):
            thing = furniture.clutter(palette)
            if rng.random() < 0.6:
                room.put_at_wall(thing, rng, gap_m=float(rng.uniform(0.01, 0.15)))
            else:
                room.put_anywhere(thing, rng)
    if rng.random() < 0.25:
        for _ in range(rng.poisson(1.2)):
            room.put_anywhere(standing(palette), rng, margin_m=0.1)


def _line_walls(palette: Palette, room: Room) -> None:
    """Furniture that any room may have along its walls."""
    rng = palette.rng
    for _ in range(rng.poisson(0.13 * room.inside.width * room.inside.depth)):
        dice = rng.random()
        wide = float(rng.uniform(0.4, 1.6))
        if dice < 0.4:
            thing = furniture.cabinet(palette, wide, 0.42, float(rng.uniform(0.5, 2.0)))
        elif dice < 0.6:
            thing = furniture.shelf(palette, wide, 0.3, float(rng.uniform(0.8, 2.1)))
        elif dice < 0.75:
            thing = furniture.plant(palette)
        elif dice < 0.87:
            thing = furniture.chair(palette)
        else:
            thing = furniture.table(palette, wide, 0.5, float(rng.uniform(0.5, 0.8)))
        room.put_at_wall(thing, rng)


def _hang(palette: Palette, room: Room) -> None:
    """Pictures, boards and shelves on the walls."""
    rng = palette.rng
    inside = room.inside
    for _ in range(rng.poisson(2.5)):
        wide, tall = float(rng.uniform(0.25, 1.3)), float(rng.uniform(0.25, 1.0))
        z = float(rng.uniform(1.1, 1.6))
        face = palette.of(
            "photo",
            "photo",
            "print",
            "print",
            "blank",
            "plain",
            tile_m=float(max(wide, tall) * 1.0),
        )
        parts = [box(face, (wide, 0.012, tall), (0, -0.014, z))]
        if rng.random() < 0.7:
            parts.append(
                box(
                    palette.of("wood", "plain", "blank"),
                    (wide + 0.06, 0.02, tall + 0.06),
                    (0, -0.005, z - 0.03),
                )
            )
        thing = joined("picture", parts, outlines=())
        side = int(rng.integers(4))
        across = inside.width if side % 2 == 0 else inside.depth
        if across < wide + 0.4:
            continue
        along = float(rng.uniform(0.2 + wide / 2, across - 0.2 - wide / 2))
        x, y = (
            (inside.x0 + along, inside.y1),
            (inside.x0, inside.y0 + along),
            (inside.x1 - along, inside.y0),
            (inside.x1, inside.y1 - along),
        )[side]
        place = Rect(x - wide / 2, y - wide / 2, x + wide / 2, y + wide / 2)
        if not any(place.meets(hole) for hole in room.openings):
            room.things.append(thing.at(x, y, 0.0, (0.0, np.pi / 2, np.pi, -np.pi / 2)[side]))


def _rug(palette: Palette, room: Room, x: float, y: float, width_m: float, depth_m: float) -> None:
    inside = room.inside.grown(-0.05)
    x0, x1 = max(x - width_m / 2, inside.x0), min(x + width_m / 2, inside.x1)
    y0, y1 = max(y - depth_m / 2, inside.y0), min(y + depth_m / 2, inside.y1)
    if x1 - x0 > 0.3 and y1 - y0 > 0.3:
        cloth = palette.of(
            "carpet", "ornament", "stripes", "checks", "fabric", tile_m=(0.4, 1.8), value=0.25
        )
        height = float(palette.rng.uniform(0.004, 0.012))
        room.rugs.append(Patch(rectangle(x0, y0, x1, y1), height, cloth))


def _around(
    palette: Palette,
    room: Room,
    x: float,
    y: float,
    width_m: float,
    depth_m: float,
    make: Callable[[], Thing],
) -> None:
    """Chairs along the sides of a table, some pulled out, some turned, some taken."""
    rng = palette.rng
    for side in range(4):
        across = width_m if side % 2 == 0 else depth_m
        away = (depth_m if side % 2 == 0 else width_m) / 2
        yaw = (0.0, np.pi / 2, np.pi, -np.pi / 2)[side]
        count = int(across / 0.62)
        if rng.random() < 0.15:
            continue
        for index in range(count):
            if rng.random() < 0.2:
                continue
            along = (index + 0.5) * across / count - across / 2
            out = (
                away
                + float(rng.choice([0.0, 0.12, 0.3], p=[0.55, 0.25, 0.2]))
                + rng.normal(0, 0.03)
            )
            turn = float(rng.normal(0, 0.1 if out < away + 0.2 else 0.5))
            offset = placement(0, 0, 0, yaw)[:2, :2] @ np.array([along, out])
            thing = make()
            if rng.random() < 0.08:
                sitting = tuple(seated_parts(palette, 0.45))
                thing = joined("person", [*thing.parts, *sitting])
            room.things.append(thing.at(x + offset[0], y + offset[1], 0.0, yaw + turn))


def _table_group(
    palette: Palette, room: Room, width_m: float, depth_m: float, *, office: bool = False
) -> None:
    """A table with chairs somewhere in the room."""
    rng = palette.rng
    made = furniture.table(palette, width_m, depth_m, float(rng.uniform(0.71, 0.77)))
    wood = palette.main_wood()
    cloth = palette.cloth() if rng.random() < 0.5 else None

    def seat() -> Thing:
        return furniture.office_chair(palette) if office else furniture.chair(palette, wood, cloth)

    for _ in range(10):
        x = float(rng.uniform(room.inside.x0, room.inside.x1))
        y = float(rng.uniform(room.inside.y0, room.inside.y1))
        place = Rect(x - width_m / 2, y - depth_m / 2, x + width_m / 2, y + depth_m / 2).grown(0.45)
        if room.is_free(place):
            if rng.random() < 0.3:
                _rug(palette, room, x, y, width_m + 1.2, depth_m + 1.2)
            room.taken.append(place)
            room.things.append(made.at(x, y))
            _around(palette, room, x, y, width_m, depth_m, seat)
            return


def _bathroom(palette: Palette, room: Room) -> None:
    rng = palette.rng
    if rng.random() < 0.75:
        room.put_at_wall(furniture.tub(palette), rng)
    for make in (furniture.basin, furniture.toilet):
        room.put_at_wall(make(palette), rng, tries=14)
    if rng.random() < 0.5:
        room.put_at_wall(furniture.cabinet(palette, 0.4, 0.35, float(rng.uniform(0.8, 1.8))), rng)
    if rng.random() < 0.6:
        _rug(
            palette,
            room,
            *_middle(room, rng),
            float(rng.uniform(0.5, 1.0)),
            float(rng.uniform(0.4, 0.7)),
        )


def _middle(room: Room, rng: np.random.Generator) -> tuple[float, float]:
    inside = room.inside
    return (
        float(inside.x0 + inside.width * rng.uniform(0.3, 0.7)),
        float(inside.y0 + inside.depth * rng.uniform(0.3, 0.7)),
    )


def _kitchen(palette: Palette, room: Room) -> None:
    rng = palette.rng
    for _ in range(int(rng.integers(1, 4))):
        room.put_at_wall(furniture.counter(palette, float(rng.uniform(1.2, 3.2))), rng)
    room.put_at_wall(furniture.fridge(palette), rng)
    if rng.random() < 0.3:
        room.put_anywhere(
            furniture.counter(palette, float(rng.uniform(1.2, 2.4)), island=True), rng, margin_m=0.6
        )
    if rng.random() < 0.8:
        _table_group(palette, room, float(rng.uniform(0.8, 2.0)), float(rng.uniform(0.7, 1.0)))


def _living(palette: Palette, room: Room) -> None:
    rng = palette.rng
    wide, tall = float(rng.uniform(0.7, 2.2)), float(rng.uniform(0.8, 2.3))
    for _ in range(int(rng.integers(1, 3))):
        seats = int(rng.integers(1, 5))
        placed = room.put_at_wall(
            furniture.sofa(palette, seats), rng, gap_m=float(rng.choice([0.03, 0.6]))
        )
        if placed is None:
            continue
        x, y, yaw = placed
        ahead = placement(0, 0, 0, yaw)[:2, :2] @ np.array([0, -1.15])
        if rng.random() < 0.7:
            low = furniture.table(
                palette,
                float(rng.uniform(0.7, 1.3)),
                float(rng.uniform(0.5, 0.8)),
                float(rng.uniform(0.36, 0.5)),
            )
            room.put(low, x + ahead[0], y + ahead[1], yaw, 0.02)
        if rng.random() < 0.6:
            size = (2.4, 1.7) if abs(np.sin(yaw)) < 0.5 else (1.7, 2.4)
            _rug(palette, room, x + ahead[0], y + ahead[1], *size)
    if rng.random() < 0.6:
        room.put_at_wall(furniture.television(palette), rng)
    if rng.random() < 0.7:
        room.put_at_wall(furniture.shelf(palette, wide, 0.3, tall), rng)
    for _ in range(int(rng.integers(0, 3))):
        room.put_at_wall(
            furniture.cabinet(
                palette, float(rng.uniform(0.6, 1.6)), 0.42, float(rng.uniform(0.7, 1.9))
            ),
            rng,
        )
    for make in (furniture.plant, furniture.floor_lamp, furniture.plant):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng, gap_m=0.1)
    if room.inside.width * room.inside.depth > 20 and rng.random() < 0.6:
        _table_group(palette, room, float(rng.uniform(0.9, 2.2)), float(rng.uniform(0.8, 1.1)))
    elif rng.random() < 0.5:
        room.put_anywhere(furniture.chair(palette), rng)


def _bedroom(palette: Palette, room: Room) -> None:
    rng = palette.rng
    placed = room.put_at_wall(furniture.bed(palette), rng, tries=16)
    if placed is not None and rng.random() < 0.6:
        _rug(
            palette,
            room,
            placed[0],
            placed[1],
            float(rng.uniform(1.8, 3)),
            float(rng.uniform(1.8, 3)),
        )
    for _ in range(2):
        room.put_at_wall(furniture.cabinet(palette, 0.45, 0.4, float(rng.uniform(0.4, 0.6))), rng)
    room.put_at_wall(
        furniture.cabinet(
            palette, float(rng.uniform(0.9, 2.2)), 0.58, float(rng.uniform(1.8, 2.2))
        ),
        rng,
    )
    for make in (
        furniture.desk,
        furniture.office_chair,
        furniture.plant,
        lambda p: furniture.cabinet(p, 1.0, 0.45, 0.85),
    ):
        if rng.random() < 0.45:
            room.put_at_wall(make(palette), rng)


def _office(palette: Palette, room: Room) -> None:
    rng = palette.rng
    area = room.inside.width * room.inside.depth
    for _ in range(max(1, round(area / rng.uniform(5, 10)))):
        made = furniture.desk(palette)
        placed: tuple[float, float, float] | None
        if rng.random() < 0.65 or area < 14:
            placed = room.put_at_wall(made, rng)
        else:
            x, y = _middle(room, rng)
            yaw = float(rng.choice([0, np.pi / 2, np.pi, -np.pi / 2]))
            placed = (x, y, yaw) if room.put(made, x, y, yaw, 0.25) else None
        if placed is not None:
            x, y, yaw = placed
            ahead = placement(0, 0, 0, yaw)[:2, :2] @ np.array(
                [rng.normal(0, 0.15), -rng.uniform(0.4, 0.9)]
            )
            thing = (
                furniture.office_chair(palette) if rng.random() < 0.8 else furniture.chair(palette)
            )
            turn = yaw + np.pi + float(rng.normal(0, 0.5))
            if rng.random() < 0.12:
                thing = joined("person", [*thing.parts, *seated_parts(palette, 0.5)])
            room.things.append(thing.at(x + ahead[0], y + ahead[1], 0.0, turn))
            room.taken.append(
                Rect(x + ahead[0] - 0.3, y + ahead[1] - 0.3, x + ahead[0] + 0.3, y + ahead[1] + 0.3)
            )
    for _ in range(int(rng.integers(1, 4))):
        dice = rng.random()
        if dice < 0.5:
            thing = furniture.cabinet(
                palette, float(rng.uniform(0.5, 1.8)), 0.45, float(rng.uniform(0.7, 2.0))
            )
        elif dice < 0.8:
            thing = furniture.shelf(
                palette, float(rng.uniform(0.7, 2)), 0.32, float(rng.uniform(0.8, 2.1))
            )
        else:
            thing = furniture.machine(palette)
        room.put_at_wall(thing, rng)
    for make, share in (
        (furniture.plant, 0.5),
        (furniture.whiteboard, 0.3),
        (lambda p: furniture.sofa(p, 1), 0.2),
    ):
        if rng.random() < share:
            room.put_at_wall(make(palette), rng, gap_m=0.05)


def _meeting(palette: Palette, room: Room) -> None:
    rng = palette.rng
    inside = room.inside
    wide = float(np.clip(inside.width - 2.0, 0.9, rng.uniform(1.6, 4.5)))
    deep = float(np.clip(inside.depth - 2.0, 0.8, rng.uniform(0.9, 1.6)))
    _table_group(palette, room, wide, deep, office=rng.random() < 0.6)
    for make in (furniture.whiteboard, furniture.plant, furniture.television):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng)


def _dining(palette: Palette, room: Room) -> None:
    rng = palette.rng
    tables = max(1, round(room.inside.width * room.inside.depth / rng.uniform(8, 18)))
    for _ in range(tables):
        _table_group(palette, room, float(rng.uniform(0.75, 2.2)), float(rng.uniform(0.75, 1.1)))
    for _ in range(2):
        room.put_at_wall(
            furniture.cabinet(
                palette, float(rng.uniform(0.8, 2.0)), 0.45, float(rng.uniform(0.75, 1.8))
            ),
            rng,
        )
    if rng.random() < 0.5:
        room.put_at_wall(furniture.plant(palette), rng)


def _corridor(palette: Palette, room: Room) -> None:
    rng = palette.rng
    for _ in range(rng.poisson(1.2)):
        dice = rng.random()
        if dice < 0.4:
            thing = furniture.cabinet(
                palette, float(rng.uniform(0.5, 1.4)), 0.38, float(rng.uniform(0.7, 1.9))
            )
        elif dice < 0.6:
            thing = furniture.plant(palette)
        elif dice < 0.8:
            thing = furniture.chair(palette)
        else:
            thing = furniture.machine(palette)
        room.put_at_wall(thing, rng)
    if rng.random() < 0.3:
        _rug(palette, room, *_middle(room, rng), 3.0, 0.9)


def _hall(palette: Palette, room: Room) -> None:
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
        room.put_anywhere(furniture.sofa(palette, int(rng.integers(1, 4))), rng, margin_m=0.2)
    for _ in range(rng.poisson(2)):
        _table_group(palette, room, float(rng.uniform(0.7, 1.2)), float(rng.uniform(0.7, 1.2)))
    for _ in range(rng.poisson(3)):
        room.put_anywhere(standing(palette), rng, margin_m=0.1)
    for make in (
        lambda p: furniture.counter(p, 2.5, island=True),
        furniture.plant,
        furniture.plant,
        furniture.machine,
    ):
        if rng.random() < 0.5:
            room.put_at_wall(make(palette), rng, gap_m=0.3)


def _store(palette: Palette, room: Room) -> None:
    rng = palette.rng
    for _ in range(3):
        room.put_at_wall(
            furniture.shelf(palette, float(rng.uniform(0.7, 1.5)), 0.4, float(rng.uniform(1, 2))),
            rng,
        )
    for _ in range(5):
        room.put_at_wall(furniture.clutter(palette), rng)
    room.put_at_wall(furniture.machine(palette), rng)


FURNISHERS: dict[str, Callable[[Palette, Room], None]] = {
    "bathroom": _bathroom, "kitchen": _kitchen, "living": _living, "bedroom": _bedroom,
    "office": _office, "study": _office, "meeting": _meeting, "dining": _dining,
    "corridor": _corridor, "hall": _hall, "store": _store,
}  # fmt: skip
