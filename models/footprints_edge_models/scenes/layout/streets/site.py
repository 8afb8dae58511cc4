"""A stretch of outdoors while it is built: ground, things, what is still free."""

from dataclasses import dataclass, field

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import Patch, Thing, placement, rectangle
from footprints_edge_models.scenes.layout.floor_plans import Rect

REACH_M = 95.0
"""The ground ends here, beyond what a network's depth range of 100 m can tell."""


@dataclass
class Site:
    """A stretch of outdoors while it is built."""

    palette: Palette
    ground: list[Patch] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    taken: list[Rect] = field(default_factory=list)

    def lay(
        self, x0: float, y0: float, x1: float, y1: float, height_m: float, material: Material
    ) -> None:
        """Add a rectangle of ground."""
        if x1 - x0 > 1e-3 and y1 - y0 > 1e-3:
            self.ground.append(Patch(rectangle(x0, y0, x1, y1), height_m, material))

    def put(
        self,
        thing: Thing,
        x: float,
        y: float,
        z: float = 0.0,
        yaw: float = 0.0,
        margin_m: float = 0.1,
    ) -> bool:
        """Place a thing, unless something stands there."""
        outlines = thing.footprints()
        turned = placement(x, y, 0, yaw)
        points = np.concatenate(outlines) @ turned[:2, :2].T + (x, y)
        low, high = points.min(axis=0) - margin_m, points.max(axis=0) + margin_m
        place = Rect(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        if any(place.meets(other) for other in self.taken):
            return False
        self.taken.append(place)
        self.things.append(thing.at(x, y, z, yaw))
        return True


def lay_side(
    site: Site,
    side: int,
    near: float,
    far: float,
    start: float,
    end: float,
    height_m: float,
    material: Material,
) -> None:
    """A strip of ground along one side of the street, ``near`` to ``far`` from its middle."""
    x0, x1 = sorted((side * near, side * far))
    site.lay(x0, start, x1, end, height_m, material)
