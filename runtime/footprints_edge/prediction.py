"""The result: where one can walk in a picture, and how far away that is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from PIL import Image

from footprints_edge.errors import MissingMapError
from footprints_edge.foundation.types import Floats, Mask, Rgb, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.maps.decode import ABSENT

if TYPE_CHECKING:
    from footprints_edge.geometry.ground_plane import GroundPlane
    from footprints_edge.navigation.occupancy_grid import OccupancyGrid
    from footprints_edge.navigation.path_planning import GroundPath


MAPS = (
    "visible_ground_probability",
    "ground_probability",
    "visible_depth_m",
    "unmasked_ground_depth_m",
)
"""The fields of a prediction that a network fills, in the order of its output."""


@dataclass(frozen=True)
class ModelInfo:
    """Which model a prediction is from.

    Attributes:
        name: The model's name.
        precision: `fp32`, `fp16` (weights only) or `int8`.
        sha256: SHA-256 of the model file.
        runtime: Program and version that ran it, and on what if not on the CPU.
    """

    name: str
    precision: str
    sha256: str
    runtime: str


@dataclass(frozen=True, eq=False)
class Prediction:
    """Walkable ground, seen and hidden, and depths. All maps have one size (h, w).

    The maps are what the network said, but for the ground's depth, which `Model.predict` lays onto
    the ground's plane; masks follow from them and the threshold. What a model
    file does not have (`fp-export convert --outputs`) raises `MissingMapError` where it is asked
    for; `has` tells beforehand.

    Attributes:
        visible_ground_probability: float32 (h, w), that what is seen here is walkable.
        ground_probability: float32 (h, w), that the ray meets walkable ground, seen or hidden.
        visible_depth_m: float32 (h, w), metres along the optical axis to what is seen.
        unmasked_ground_depth_m: float32 (h, w), metres along the optical axis to where ground
            would be; `ground_depth_m` is the same where there is ground.
        picture: The upright picture, for overlays and coloured points.
        intrinsics: The camera in the maps' own pixels, and where it came from.
        threshold: Probability above which a pixel counts as ground.
        model: Which model it is from.
        timings_ms: Milliseconds by stage: decode, preprocess, inference, postprocess.
        laid_onto: The plane that ground depth was laid onto; None where it is as the network said.
            It is `ground_plane` then: who replaces depth or camera sets it to None.
    """

    visible_ground_probability: Floats
    ground_probability: Floats
    visible_depth_m: Floats
    unmasked_ground_depth_m: Floats
    picture: DecodedImage
    intrinsics: Intrinsics
    threshold: float
    model: ModelInfo
    timings_ms: Mapping[str, float]
    laid_onto: "GroundPlane | None" = None

    def __post_init__(self) -> None:
        """Takes away the maps that are absent, so that they raise where they are asked for."""
        for name in MAPS:
            if getattr(self, name) is ABSENT:
                object.__delattr__(self, name)

    if not TYPE_CHECKING:  # a type checker is to go on finding misspelt names

        def __getattr__(self, name: str) -> object:
            """Explains why a map is not there."""
            if name not in MAPS:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            kind, others = ("depths", "masks") if name.endswith("_m") else ("masks", "depths")
            raise MissingMapError(
                f"{name} is not there: model {self.model.name!r} has no {kind}, it was converted "
                f"with --outputs {others}; use one with all maps"
            )

    def has(self, name: str) -> bool:
        """Whether one of the four maps, named as the fields are, is there."""
        return name in vars(self)

    @cached_property
    def visible_ground(self) -> Mask:
        """Bool (h, w): the surface seen at this pixel is walkable (the paper's S)."""
        return self.visible_ground_probability > self.threshold

    @cached_property
    def ground(self) -> Mask:
        """Bool (h, w): the ray meets a walkable surface, seen or hidden (the paper's S*)."""
        return self.ground_probability > self.threshold

    @cached_property
    def hidden_ground(self) -> Mask:
        """Bool (h, w): there is ground, but something stands in front of it."""
        return self.ground & ~self.visible_ground

    @cached_property
    def ground_depth_m(self) -> Floats:
        """float32 (h, w), metres to the walkable surface; NaN where `ground` is False."""
        return np.where(self.ground, self.unmasked_ground_depth_m, np.float32(np.nan))

    @cached_property
    def _ground_plane(self) -> "GroundPlane":
        from footprints_edge.geometry.ground_plane import fit_ground_plane

        if self.laid_onto is not None:
            return self.laid_onto
        return fit_ground_plane(self.unmasked_ground_depth_m, self.ground, self.intrinsics)

    @property
    def map_size(self) -> Size:
        """(h, w) of the maps."""
        height, width = next(vars(self)[name].shape for name in MAPS if self.has(name))
        return height, width

    @property
    def image_size(self) -> Size:
        """(H, W) of the upright picture."""
        return self.picture.size

    @property
    def rgb(self) -> Rgb:
        """uint8 (H, W, 3), the upright picture; decoded at its own size when first asked for."""
        return self.picture.rgb

    @property
    def name(self) -> str | None:
        """File name of the picture, None where it has none."""
        return self.picture.name

    @property
    def path(self) -> Path | None:
        """The picture's file, None where it was not read from one."""
        return self.picture.path

    def at_image_size(self) -> "Prediction":
        """The same prediction with maps of the picture's own size."""
        return self.at_size(self.image_size)

    def at_size(self, size: Size) -> "Prediction":
        """The same prediction with maps of another size.

        Probabilities are interpolated before the threshold, depths as inverse depths: along a
        plane the inverse depth is affine in the pixel, so interpolation keeps planes flat.

        Args:
            size: (h, w) of the new maps.
        """
        if size == self.map_size:
            return self
        visible_ground, ground, visible_depth_m, ground_depth_m = (
            (resize_depth if name.endswith("_m") else resized)(getattr(self, name), size)
            if self.has(name)
            else ABSENT
            for name in MAPS
        )
        return replace(
            self,
            visible_ground_probability=visible_ground,
            ground_probability=ground,
            visible_depth_m=visible_depth_m,
            unmasked_ground_depth_m=ground_depth_m,
            intrinsics=self.intrinsics.scaled(self.map_size, size),
        )

    def ground_plane(self) -> "GroundPlane":
        """The plane that the ground lies in, with the camera's height and pitch above it.

        Raises:
            GroundPlaneError: If there is too little ground to carry a plane.
        """
        return self._ground_plane

    def flattened(self) -> "Prediction":
        """The same prediction with the ground's depth laid onto `ground_plane`.

        Only where most of the ground lies near to that plane anyway, and there only pixels that do:
        ramps, steps and stairs stay as they are. Without a plane, or without the maps that it is
        fitted to, it is the prediction itself.
        """
        from footprints_edge.navigation.ground_flattening import flatten

        return flatten(self)

    def top_down(self, cell_m: float = 0.05, range_m: float = 10.0) -> "OccupancyGrid":
        """The ground seen from above, as an occupancy grid.

        Takes the ground for the one plane of `ground_plane`.

        Args:
            cell_m: Side of a cell, metres.
            range_m: How far the grid reaches ahead, and to each side, metres.

        Raises:
            GroundPlaneError: If there is too little ground to carry a plane.
            ValueError: If a size is not positive, or the range is more than 5000 cells.
        """
        from footprints_edge.navigation.occupancy_grid import make_occupancy_grid

        return make_occupancy_grid(self, cell_m, range_m)

    def plan(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        unit: Literal["px", "m"] = "px",
        margin_m: float = 0.0,
        ground: Literal["all", "visible"] = "all",
    ) -> "GroundPath":
        """The cheapest path over the ground, at the paper's cost: 1 - s* for every pixel.

        s* is the unthresholded `ground_probability`; a path never leaves `ground`. Needs the
        extra `plan` (scikit-image).

        Args:
            start: x and y in pixels of the picture, or forward and left in metres.
            goal: Likewise.
            unit: `px`, or `m`: metres on the ground plane, from the point below the camera.
            margin_m: Distance to keep from everything that is not ground, metres on the ground
                plane: half of the robot's width.
            ground: `all`, or `visible`: keep to what is seen.

        Raises:
            OutsideError: If the start or the goal is outside the picture.
            OffGroundError: If one is not on ground, or within the margin.
            NoPathError: If no way joins them.
            PlanningError: Base of these; also if an argument is not one of those above, or
                scikit-image is missing.
            GroundPlaneError: If there is too little ground to carry a plane.
        """
        from footprints_edge.navigation.path_planning import find_path

        return find_path(self, start, goal, unit=unit, margin_m=margin_m, ground=ground)

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
            folder: Where to; made if it is not there.
            formats: Any of `overlay`, `npz`, `png16`, `json`, `ply`, `topdown`,
                `topdown_picture`.
            name: Start of the file names; None means the picture's name, or `image`.
            overwrite: Whether to replace files that are there already.

        Returns:
            The files written, in the order of `formats`.

        Raises:
            OutputError: If a format is unknown, a file is in the way (nothing is written then),
                or the folder cannot be written to.
        """
        from footprints_edge.outputs.writers import save

        return save(self, Path(folder), formats, name=name, overwrite=overwrite)


def resized(values: Floats, size: Size) -> Floats:
    """A map, float32 (h, w), at another size: bilinear, antialiased where it shrinks."""
    height, width = size
    image = Image.fromarray(values).resize((width, height), Image.Resampling.BILINEAR)
    return np.array(image)


def resize_depth(depth_m: Floats, size: Size) -> Floats:
    """A depth map, float32 (h, w), at another size, interpolated as inverse depth."""
    return np.reciprocal(resized(np.reciprocal(depth_m), size))
