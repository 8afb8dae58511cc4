"""A room while it is furnished: what stands where, and what is still free."""

from dataclasses import dataclass, field

import numpy as np

from footprints_edge_models.scenes.assets.things import Patch, Thing, placement, rectangle
from footprints_edge_models.scenes.layout.floor_plans import Rect


@dataclass
class Room:
    """A room while it is furnished.

    Attributes:
        inside: its floor, up to the walls.
        kind: its use, a key of ``furnishing.FURNISHERS``.
        taken: places where things stand, or where doors need space.
        openings: places of doors and windows.
        things: things placed in it.
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
        """Place a thing, if there is room for it."""
        place = place_of(thing, x, y, yaw).grown(margin_m)
        if not self.is_free(place):
            return False
        self.taken.append(place)
        self.things.append(thing.at(x, y, 0.0, yaw))
        return True

    def put_at_wall(
        self, thing: Thing, rng: np.random.Generator, *, gap_m: float = 0.02, tries: int = 8
    ) -> tuple[float, float, float] | None:
        """Place a thing with its back to a wall; returns x, y and yaw."""
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
        """Place a thing at a random place, turned at random."""
        for _ in range(6):
            x = float(rng.uniform(self.inside.x0, self.inside.x1))
            y = float(rng.uniform(self.inside.y0, self.inside.y1))
            if self.put(thing, x, y, float(rng.uniform(-np.pi, np.pi)), margin_m):
                return


def place_of(thing: Thing, x: float, y: float, yaw: float) -> Rect:
    """The axis-aligned rectangle that a placed thing covers."""
    low, high = thing.extent
    corners = rectangle(low[0], low[1], high[0], high[1]) @ placement(0, 0, 0, yaw)[:2, :2].T
    least, most = (op(corners, axis=0) + np.array((x, y)) for op in (np.min, np.max))
    return Rect(float(least[0]), float(least[1]), float(most[0]), float(most[1]))
