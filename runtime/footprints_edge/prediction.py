"""The result of a prediction: the maps, and methods that plan on them, draw and save them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from footprints_edge.foundation.computed_once import computed_once
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.ground_maps import GroundMaps

if TYPE_CHECKING:
    from footprints_edge.foundation.types import Floats
    from footprints_edge.geometry.ground_plane import GroundPlane
    from footprints_edge.navigation.occupancy_grid import OccupancyGrid
    from footprints_edge.navigation.path_planning import GroundPath
    from footprints_edge.navigation.range_scan import RangeScan


@dataclass(frozen=True, eq=False, repr=False)
class Prediction(GroundMaps):
    """Walkable ground in a picture, seen and hidden, and how far away it is.

    The maps, masks and camera come from `GroundMaps`; the methods here plan on them, draw them
    and write them to files. All maps have one size (h, w): the network's input size.
    """

    def flattened(self) -> "Prediction":
        """The same prediction with the ground's depth snapped to `ground_plane`.

        This happens only to pixels that lie close to the plane: ramps, steps and stairs keep their
        depth. With a known height, pitch and roll it happens to all ground. Without a plane, or
        without the maps to fit one, it returns the prediction itself.
        """
        from footprints_edge.navigation.ground_flattening import flatten

        return flatten(self)

    def top_down(
        self, cell_m: float = 0.05, range_m: float = 10.0, *, robot_height_m: float | None = None
    ) -> "OccupancyGrid":
        """The surroundings in bird's-eye view, as an occupancy grid.

        Occupied is what is seen between the height of a step (0.15 m) and that of the robot; see
        `navigation/obstacles.py`. Hidden ground is a value of its own. Assumes that all ground lies
        in one plane, `ground_plane`.

        Args:
            cell_m: Side of a cell, metres.
            range_m: Reach of the grid ahead, and to each side, metres.
            robot_height_m: Height of the robot, metres: it passes beneath higher things. None means
                the height given to `predict`, 1.2 m unless stated.

        Raises:
            GroundPlaneError: If there is no ground plane.
            ValueError: If a size is not positive, the range is more than 1500 cells, or the robot
                is not higher than a step.
        """
        from footprints_edge.navigation.occupancy_grid import make_occupancy_grid

        return make_occupancy_grid(self, cell_m, range_m, robot_height_m)

    def walkable_behind_things(
        self, cell_m: float = 0.05, range_m: float = 10.0
    ) -> "OccupancyGrid":
        """All walkable ground in bird's-eye view, beneath and behind things too: the paper's S*.

        Not free space: a table stands on walkable ground. Occupied is what is not ground, where it
        borders on ground or is at most 1 m behind the visible surface. Assumes one plane.

        Args:
            cell_m: Side of a cell, metres.
            range_m: Reach of the grid ahead, and to each side, metres.

        Raises:
            GroundPlaneError: If there is no ground plane.
            ValueError: If a size is not positive, or the range is more than 1500 cells.
        """
        from footprints_edge.navigation.occupancy_grid import make_walkable_grid

        return make_walkable_grid(self, cell_m, range_m)

    def scan(
        self,
        bearings_deg: Sequence[float] | float | None = None,
        *,
        robot_height_m: float | None = None,
    ) -> "RangeScan":
        """The distance to the nearest obstacle by bearing, as a laser scanner reports it.

        Args:
            bearings_deg: Degrees from straight ahead, left positive. None means every degree from
                -90 to 90.
            robot_height_m: As for `top_down`; obstacles follow the same rule.

        Raises:
            GroundPlaneError: If there is no ground plane.
            ValueError: If the robot is not higher than a step.
        """
        import numpy as np

        from footprints_edge.navigation.range_scan import scan

        bearings = np.arange(-90.0, 91.0) if bearings_deg is None else np.asarray(bearings_deg)
        return scan(self, bearings, robot_height_m)

    def plan(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        unit: Literal["px", "m"] = "px",
        margin_m: float = 0.0,
        ground: Literal["all", "visible"] = "all",
        robot_height_m: float | None = None,
    ) -> "GroundPath":
        """The cheapest path over the ground, with the paper's cost of 1 - s*, per metre.

        s* is the unthresholded `ground_probability`. The path lies on the ground plane, in the
        cells of `top_down`: it never leaves `ground`, and passes no obstacle. Needs the extra
        `plan` (scipy).

        Args:
            start: x and y in pixels of the picture, or forward and left in metres.
            goal: Likewise.
            unit: `px`, or `m`: metres on the ground plane, from the point below the camera.
            margin_m: Distance to keep from everything that is not ground, in metres on the ground
                plane, such as half of the robot's width.
            ground: `all`, or `visible` to stay on visible ground.
            robot_height_m: As for `top_down`; obstacles follow the same rule.

        Raises:
            OutsideError: If the start or the goal is outside the picture.
            OffGroundError: If one is not on ground (on a table top, say), where an obstacle stands,
                or closer to one than the margin.
            NoPathError: If no path connects them.
            PlanningError: Base class of these; also if an argument is invalid, or scipy is
                missing.
            GroundPlaneError: If there is too little ground to fit a plane.
        """
        from footprints_edge.navigation.path_planning import find_path

        return find_path(
            self,
            start,
            goal,
            unit=unit,
            margin_m=margin_m,
            ground=ground,
            robot_height_m=robot_height_m,
        )

    def save(
        self,
        folder: str | Path,
        formats: Sequence[str] = ("overlay",),
        *,
        name: str | None = None,
        overwrite: bool = False,
    ) -> list[Path]:
        """Writes the result as files named after the picture, such as `street.jpg.npz`.

        Args:
            folder: Destination; created if missing.
            formats: Any of `overlay`, `npz`, `png16`, `json`, `ply`, `topdown`, `topdown_npz`,
                `topdown_ply`, `topdown_picture`.
            name: Start of the file names; None means the picture's name, or `image`.
            overwrite: Whether to replace existing files.

        Returns:
            The files written, in the order of `formats`.

        Raises:
            OutputError: If a format is unknown, a file exists (nothing is written then), or the
                folder cannot be written to.
        """
        from footprints_edge.outputs.writers import save

        return save(self, Path(folder), formats, name=name, overwrite=overwrite)


class FlattenedWhenRead(Prediction):
    """The flattened prediction, made when the ground's depth or plane is first read.

    Who asks for masks or the visible depth only does not wait for it. What copies the fields, as
    `dataclasses.replace` does, reads them, and gets an ordinary one.
    """

    @classmethod
    def of(cls, plain: Prediction) -> "FlattenedWhenRead":
        """What `plain.flattened()` is, later."""
        made = object.__new__(cls)
        vars(made).update(vars(plain), _plain=plain)
        for name in ("maps", "laid_onto"):
            del vars(made)[name]
        return made

    @computed_once
    def _flattened(self) -> Prediction:
        plain: Prediction = vars(self)["_plain"]
        return plain.flattened()

    @computed_once
    def maps(self) -> DecodedMaps:
        """The four maps."""
        return self._flattened.maps

    @computed_once
    def laid_onto(self) -> "GroundPlane | None":
        """The plane that the ground's depth was snapped to."""
        return self._flattened.laid_onto

    def flattened(self) -> Prediction:
        """The prediction itself."""
        return self if "_plain" in vars(self) else super().flattened()

    def has(self, name: str) -> bool:
        """Whether the model file has this map."""
        plain: Prediction | None = vars(self).get("_plain")
        return super().has(name) if plain is None else plain.has(name)

    def _map(self, name: str) -> "Floats":
        plain: Prediction | None = vars(self).get("_plain")
        if plain is None or name == "unmasked_ground_depth_m":
            return super()._map(name)
        return plain._map(name)
