"""Where in a world something can be put: on free ground, clear of everything."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.world_plan import STOREY_M
from footprints_edge_models.scenes.assets.things import Thing, placement, rectangle
from footprints_edge_models.scenes.assets.worlds import MOST_LOADED, LoadedWorld
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.rendering.raycast import Triangles

_STEP_M = 0.15
_LEVEL_M = 0.04
"""Ground below a thing is as level as this."""
_DOWN = np.array([[0, 0, -1]], np.float32)


@lru_cache(maxsize=MOST_LOADED)
def _traced(world: LoadedWorld) -> tuple[Triangles, Triangles]:
    """Everything in a world, and its floors."""
    corners, _ = world.floor_triangles
    return Triangles(np.concatenate([corners, world.thing_triangles])), Triangles(corners)


@dataclass
class FreeGround:
    """Free ground of a world while things are put there.

    Attributes:
        world: the world.
        solids: its floors and things as they stand in its file.
        floors: its floors alone.
        taken: places where things were put.
    """

    world: LoadedWorld
    solids: Triangles = field(repr=False)
    floors: Triangles = field(repr=False)
    taken: list[Rect] = field(default_factory=list)

    @classmethod
    def of(cls, world: LoadedWorld) -> "FreeGround":
        """All free ground of a world."""
        return cls(world, *_traced(world))

    def level_m(self, points: NDArray[np.floating], near_m: float) -> NDArray[np.float32]:
        """Height of the floor at (N, 2), nan where there is none about ``near_m`` high."""
        above = np.column_stack([points, np.full(len(points), near_m + STOREY_M)])
        hits = self.floors.first_hits(above.astype(np.float32), _DOWN)
        level = (near_m + STOREY_M - hits.distance).astype(np.float32)
        return np.where(np.abs(level - near_m) < STOREY_M, level, np.float32(np.nan))

    def floor_at(self, x: float, y: float, near_m: float) -> str:
        """Name of the floor at a place; empty if there is none."""
        above = np.array([[x, y, near_m + STOREY_M]], np.float32)
        triangle = int(self.floors.first_hits(above, _DOWN).triangle[0])
        return (
            "" if triangle < 0 else self.world.floors[self.world.floor_triangles[1][triangle]].name
        )

    def put(
        self, thing: Thing, x: float, y: float, yaw: float, near_m: float, margin_m: float = 0.05
    ) -> Thing | None:
        """The thing in its place, if all of it fits on level, free ground.

        Args:
            thing: in its own axes.
            x: where to.
            y: where to.
            yaw: how it is turned, radians.
            near_m: about how high the floor is.
            margin_m: how far it stays away from everything.
        """
        low, high = thing.extent
        own = rectangle(
            low[0] - margin_m, low[1] - margin_m, high[0] + margin_m, high[1] + margin_m
        )
        corners = own @ placement(0, 0, 0, yaw)[:2, :2].T + (x, y)
        least, most = corners.min(axis=0), corners.max(axis=0)
        place = Rect(float(least[0]), float(least[1]), float(most[0]), float(most[1]))
        if any(place.meets(other) for other in self.taken):
            return None
        level = float(self.level_m(np.array([[x, y]]), near_m)[0])
        if not np.isfinite(level) or not self._is_free(corners, level, float(high[2])):
            return None
        self.taken.append(place)
        placed = thing.at(x, y, level, yaw)
        return Thing(
            placed.label,
            placed.parts,
            placed.outlines,
            placed.is_wall,
            placed.asset,
            level,
            placed.pose,
        )

    def _is_free(self, corners: NDArray[np.float64], level_m: float, height_m: float) -> bool:
        """Whether a rectangle (4, 2) is level ground, and the space above it is empty."""
        across, along = corners[1] - corners[0], corners[3] - corners[0]
        counts = [
            int(np.clip(np.ceil(np.linalg.norm(side) / _STEP_M), 1, 24)) + 1
            for side in (across, along)
        ]
        s, t = (each.ravel() for each in np.meshgrid(*(np.linspace(0, 1, n) for n in counts)))
        points = corners[0] + s[:, None] * across + t[:, None] * along
        top_m = level_m + max(height_m, 0.1)
        above = np.column_stack([points, np.full(len(points), top_m)]).astype(np.float32)
        fall_m = self.solids.distances(above, np.repeat(_DOWN, len(above), axis=0))
        if (np.abs(top_m - fall_m - level_m) > _LEVEL_M).any():
            return False
        # thin walls are missed from above: look along the sides, and across
        for height in (0.08, 0.4, 1.0, 1.7):
            if height > height_m + 0.1:
                break
            ring = np.column_stack([corners, np.full(4, level_m + height)]).astype(np.float32)
            starts = np.concatenate([ring, ring[[0, 1]]])
            ways = np.concatenate([np.roll(ring, -1, axis=0), ring[[2, 3]]]) - starts
            if self.solids.blocked(starts, ways, np.ones(len(starts), np.float32)).any():
                return False
        return True
