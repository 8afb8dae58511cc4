"""Floor plans: a rectangle divided into rooms, with doorways, windows and openings."""

from dataclasses import dataclass, field

import numpy as np

LEAST_SIDE_M = 2.3


@dataclass(frozen=True)
class Rect:
    """An axis-aligned rectangle, metres."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Along x."""
        return self.x1 - self.x0

    @property
    def depth(self) -> float:
        """Along y."""
        return self.y1 - self.y0

    def grown(self, margin_m: float) -> "Rect":
        """With its sides moved outwards."""
        return Rect(self.x0 - margin_m, self.y0 - margin_m, self.x1 + margin_m, self.y1 + margin_m)

    def meets(self, other: "Rect") -> bool:
        """Whether the two overlap."""
        return (
            self.x0 < other.x1 and other.x0 < self.x1 and self.y0 < other.y1 and other.y0 < self.y1
        )


@dataclass(frozen=True)
class Opening:
    """A hole in a wall: ``start`` to ``end`` along it, ``bottom`` to ``top`` above the floor."""

    start: float
    end: float
    bottom: float
    top: float
    is_door: bool


@dataclass(frozen=True)
class Wall:
    """A wall along x or y.

    Attributes:
        along_x: its direction.
        position: its y (or x).
        start: where it begins along its direction.
        end: where it ends.
        outer: whether outdoors is behind it; then ``inside`` says on which side the rooms are.
        inside: +1 where the rooms have greater y (or x), -1 where smaller, 0 for inner walls.
        openings: holes, in order.
    """

    along_x: bool
    position: float
    start: float
    end: float
    inside: int
    openings: tuple[Opening, ...]


@dataclass(frozen=True)
class FloorPlan:
    """Rooms up to the middle of their walls, and the walls."""

    rooms: tuple[Rect, ...]
    walls: tuple[Wall, ...]
    thickness_m: float
    height_m: float


@dataclass
class _Partition:
    along_x: bool
    position: float
    start: float
    end: float
    gaps: list[Opening] = field(default_factory=list)


def draw_plan(rng: np.random.Generator) -> FloorPlan:
    """One large hall, rooms along a corridor, or a flat."""
    height = float(rng.uniform(2.4, 3.2))
    dice = rng.random()
    splits: list[_Partition] = []
    if dice < 0.12:
        outer = Rect(0, 0, float(rng.uniform(7, 16)), float(rng.uniform(6, 14)))
        rooms = [outer]
        height = float(rng.uniform(2.7, 4.5))
    elif dice < 0.4:
        outer = Rect(0, 0, float(rng.uniform(9, 20)), float(rng.uniform(8.5, 13)))
        rooms = _along_corridor(outer, splits, rng)
    else:
        outer = Rect(0, 0, float(rng.uniform(6, 13)), float(rng.uniform(5, 11)))
        rooms = []
        _divide(outer, splits, rooms, float(rng.uniform(10, 32)), rng)
    _connect(rooms, splits, rng)
    walls = [
        Wall(s.along_x, s.position, s.start, s.end, 0, tuple(sorted(s.gaps, key=lambda o: o.start)))
        for s in splits
    ]
    lit = float(rng.uniform(0.3, 0.9))
    sill = float(rng.choice([0.05, 0.6, 0.9, 1.0], p=[0.15, 0.2, 0.35, 0.3]))
    for along_x, position, end, inside in (
        (True, outer.y0, outer.x1, 1),
        (True, outer.y1, outer.x1, -1),
        (False, outer.x0, outer.y1, 1),
        (False, outer.x1, outer.y1, -1),
    ):
        holes = _windows(end, lit, sill, height, rng)
        # no window where an inner wall ends
        ends = [s.position for s in splits if s.along_x != along_x]
        holes = [h for h in holes if all(not h.start - 0.2 < e < h.end + 0.2 for e in ends)]
        walls.append(Wall(along_x, position, 0.0, end, inside, tuple(holes)))
    return FloorPlan(tuple(rooms), tuple(walls), float(rng.uniform(0.08, 0.24)), height)


def _divide(
    rect: Rect,
    splits: list[_Partition],
    rooms: list[Rect],
    most_m2: float,
    rng: np.random.Generator,
) -> None:
    across = rect.width > rect.depth if rng.random() < 0.85 else rect.width <= rect.depth
    side = rect.width if across else rect.depth
    if rect.width * rect.depth < most_m2 * rng.uniform(0.6, 1.4) or side < 2 * LEAST_SIDE_M:
        rooms.append(rect)
        return
    cut = float(np.clip(rng.uniform(0.3, 0.7) * side, LEAST_SIDE_M, side - LEAST_SIDE_M))
    for half in _cut(rect, across, cut, splits):
        _divide(half, splits, rooms, most_m2, rng)


def _cut(rect: Rect, across: bool, cut: float, splits: list[_Partition]) -> tuple[Rect, Rect]:
    if across:
        x = rect.x0 + cut
        splits.append(_Partition(False, x, rect.y0, rect.y1))
        return Rect(rect.x0, rect.y0, x, rect.y1), Rect(x, rect.y0, rect.x1, rect.y1)
    y = rect.y0 + cut
    splits.append(_Partition(True, y, rect.x0, rect.x1))
    return Rect(rect.x0, rect.y0, rect.x1, y), Rect(rect.x0, y, rect.x1, rect.y1)


def _along_corridor(outer: Rect, splits: list[_Partition], rng: np.random.Generator) -> list[Rect]:
    wide = float(rng.uniform(1.3, 2.4))
    low, rest = _cut(outer, False, float(rng.uniform(2.8, outer.depth - wide - 2.8)), splits)
    corridor, high = _cut(rest, False, wide, splits)
    rooms = [corridor]
    for row in (low, high):
        left = row
        while left.width > 5.5:
            room, left = _cut(
                left, True, float(rng.uniform(2.6, min(6.5, left.width - 2.4))), splits
            )
            rooms.append(room)
        rooms.append(left)
    return rooms


def _connect(rooms: list[Rect], splits: list[_Partition], rng: np.random.Generator) -> None:
    """Doors and openings between neighbours, until every room can be reached."""
    group = list(range(len(rooms)))
    pairs = []
    for split in splits:
        for i, first in enumerate(rooms):
            for j, second in enumerate(rooms):
                if split.along_x:
                    beside = first.y1 == split.position == second.y0
                    start, end = max(first.x0, second.x0), min(first.x1, second.x1)
                else:
                    beside = first.x1 == split.position == second.x0
                    start, end = max(first.y0, second.y0), min(first.y1, second.y1)
                if beside and end - start > 1.5:
                    pairs.append((split, i, j, start + 0.25, end - 0.25))
    for index in rng.permutation(len(pairs)):
        split, i, j, start, end = pairs[index]
        if group[i] == group[j] and rng.random() > 0.3:
            continue
        group = [group[i] if g == group[j] else g for g in group]
        if rng.random() < 0.25:
            wide = float(rng.uniform(min(1.2, end - start), end - start))
            top, is_door = (9.0 if rng.random() < 0.3 else float(rng.uniform(2.1, 2.4))), False
        else:
            wide, top, is_door = min(float(rng.uniform(0.8, 1.0)), end - start), 2.05, True
        at = start + rng.random() * (end - start - wide)
        split.gaps.append(Opening(at, at + wide, 0.0, top, is_door))


def _windows(
    end: float, lit: float, sill: float, height: float, rng: np.random.Generator
) -> list[Opening]:
    holes = []
    at = float(rng.uniform(0.5, 1.5))
    while at < end - 1.6:
        wide = float(rng.uniform(0.8, 2.4))
        if at + wide < end - 0.4 and rng.random() < lit:
            top = min(height - 0.15, float(rng.uniform(2.0, 2.5)))
            holes.append(Opening(at, at + wide, sill, top, False))
        at += wide + float(rng.uniform(0.4, 2.0))
    return holes
