"""A room while it is furnished: what stands where, and what is still free."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from footprints_edge_models.scenes.assets.things import Patch, Thing, placement, rectangle
from footprints_edge_models.scenes.layout.floor_plans import Rect

YAWS = (0.0, np.pi / 2, np.pi, -np.pi / 2)
"""Of things with their backs to a wall, by the number of the wall's side."""


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
            yaw = YAWS[side]
            back = float(high[1]) + gap_m
            left, right = -float(low[0]), float(high[0])
            span = self.span_m(side)
            if left + right + 0.1 > span:
                continue
            along = float(rng.uniform(left + 0.03, span - right - 0.03))
            if rng.random() < 0.3:
                along = left + 0.03
            x, y = self.at_wall(side, along, back)
            if self.put(thing, x, y, yaw, 0.0):
                return x, y, yaw
        return None

    def span_m(self, side: int) -> float:
        """Length of a wall; sides are numbered anticlockwise from the one at the greatest y."""
        return self.inside.width if side % 2 == 0 else self.inside.depth

    def at_wall(self, side: int, along_m: float, back_m: float) -> tuple[float, float]:
        """The point so far along a wall, and so far from it.

        What stands there, turned by ``YAWS[side]``, has its back to the wall; its +x is along it.
        """
        room = self.inside
        return (
            (room.x0 + along_m, room.y1 - back_m),
            (room.x0 + back_m, room.y0 + along_m),
            (room.x1 - along_m, room.y0 + back_m),
            (room.x1 - back_m, room.y1 - along_m),
        )[side]

    def longest_free(self, side: int, depth_m: float, *, past_windows: bool) -> tuple[float, float]:
        """Start and length of the longest stretch along a wall that is free so far into the room.

        Args:
            side: the wall.
            depth_m: how far.
            past_windows: whether it may go on below windows.
        """
        step = 0.1
        best, start, at = (0.0, 0.0), 0.0, 0.0
        while at + step <= self.span_m(side):
            corners = [
                self.at_wall(side, along, back)
                for along, back in ((at + 0.01, 0.01), (at + step - 0.01, depth_m))
            ]
            (x0, x1), (y0, y1) = (sorted(values) for values in zip(*corners, strict=True))
            place = Rect(x0, y0, x1, y1)
            open_wall = any(place.meets(hole) for hole in self.openings)
            free = self.is_free(place) and (past_windows or not open_wall)
            at += step
            if not free:
                start = at
            elif at - start > best[1]:
                best = (start, at - start)
        return best

    def run_along_wall(
        self,
        side: int,
        make: Callable[[float], Thing],
        depth_m: float,
        most_m: float,
        *,
        past_windows: bool = True,
    ) -> None:
        """Place one thing along the longest free stretch of a wall, at its beginning.

        Args:
            side: the wall.
            make: makes it, as wide as it is asked for.
            depth_m: how far from the wall it reaches.
            most_m: its greatest width.
            past_windows: whether it may stand below windows.
        """
        start, length = self.longest_free(side, depth_m, past_windows=past_windows)
        wide = min(length - 0.06, most_m)
        if wide < 0.8:
            return
        thing = make(wide)
        low, high = thing.extent
        x, y = self.at_wall(side, start + 0.02 - float(low[0]), float(high[1]) + 0.01)
        self.put(thing, x, y, YAWS[side], 0.0)

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
