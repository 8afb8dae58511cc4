"""The data of a prediction: four maps, with their masks, camera and picture."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from footprints_edge.errors import GroundPlaneError, MissingMapError
from footprints_edge.foundation.computed_once import computed_once
from footprints_edge.foundation.types import Floats, Mask, Rgb, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.ground_plane import GroundPlane, find_ground_plane
from footprints_edge.geometry.obstacle_heights import ROBOT_HEIGHT_M
from footprints_edge.inputs.images import MAX_JPEG_PIXELS, DecodedImage
from footprints_edge.maps.confidence import (
    Confidence,
    curves,
    ground_inputs,
    metres_inputs,
    shows_ground,
)
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.resize import resize_depth, resize_map

MAPS = (
    "visible_ground_probability",
    "ground_probability",
    "visible_depth_m",
    "unmasked_ground_depth_m",
)
"""The maps that a network predicts, in the order of its output."""


@dataclass(frozen=True)
class ModelInfo:
    """The model that made a prediction.

    Attributes:
        name: The model's name.
        precision: `fp32`, `fp16` (weights only) or `int8`.
        sha256: SHA-256 of the model file.
        runtime: Engine and version that ran it, and its provider if that is not the CPU.
    """

    name: str
    precision: str
    sha256: str
    runtime: str


MapsT = TypeVar("MapsT", bound="GroundMaps")
"""A stage takes and returns the same class."""


@dataclass(frozen=True, eq=False, repr=False)
class GroundMaps:
    """Walkable ground, seen and hidden, and depths. All maps have one size (h, w).

    Masks follow from the probabilities and the threshold. A map that the model file lacks
    (`fp-export convert --outputs`) raises `MissingMapError` when it is read; see `has`.

    Attributes:
        maps: The four maps.
        picture: The upright picture, for overlays and coloured points.
        intrinsics: The camera in pixels of the maps, and its source.
        threshold: Probability above which a pixel counts as ground.
        model: The model that made the maps.
        timings_ms: Milliseconds by stage: decode, preprocess, inference, postprocess. What is
            computed when it is first read, such as masks and flattened depth, is in none of them.
        laid_onto: The plane that the ground's depth was snapped to, which `ground_plane()` then
            returns; None for the network's own depth.
        pose: What is known of the camera's height, pitch and roll.
        robot_height_m: Height of the robot, metres: what stands between a step and this is an
            obstacle.
        least_error_m: Least error of a fitted plane, metres: that of the picture's own, where maps
            of several pictures that were laid onto their planes are blended.
    """

    maps: DecodedMaps
    picture: DecodedImage
    intrinsics: Intrinsics
    threshold: float
    model: ModelInfo
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    laid_onto: GroundPlane | None = None
    pose: CameraPose = field(default_factory=CameraPose)
    robot_height_m: float = ROBOT_HEIGHT_M
    least_error_m: float = 0.0

    def __repr__(self) -> str:
        height, width = self.map_size
        has_masks = self.has("ground_probability")
        ground = f"ground {self.ground.mean():.0%}" if has_masks else "no masks"
        return (
            f"<Prediction of {self.name or 'an image'}: {ground}, maps {height} x "
            f"{width}, image {self.image_size[0]} x {self.image_size[1]}, "
            f"camera {self.intrinsics.source}, model {self.model.name}>"
        )

    @property
    def visible_ground_probability(self) -> Floats:
        """float32 (h, w): probability that the surface seen here is walkable (the paper's S)."""
        return self._map("visible_ground_probability")

    @property
    def ground_probability(self) -> Floats:
        """float32 (h, w): probability that the ray meets walkable ground, seen or hidden (S*)."""
        return self._map("ground_probability")

    @property
    def visible_depth_m(self) -> Floats:
        """float32 (h, w): metres along the optical axis to the visible surface (the paper's D)."""
        return self._map("visible_depth_m")

    @property
    def unmasked_ground_depth_m(self) -> Floats:
        """float32 (h, w): metres along the optical axis to where ground would be (D*).

        Equals `ground_depth_m` on ground.
        """
        return self._map("unmasked_ground_depth_m")

    def _map(self, name: str) -> Floats:
        values: Floats | None = getattr(self.maps, name)
        if values is None:
            kind, others = ("depths", "masks") if name.endswith("_m") else ("masks", "depths")
            raise MissingMapError(
                f"{name} is missing: model {self.model.name!r} has no {kind}, as it was converted "
                f"with --outputs {others}; use a model with all maps"
            )
        return values

    def has(self, name: str) -> bool:
        """Whether the model file has this map: one of the names in `MAPS`."""
        return name in MAPS and getattr(self.maps, name) is not None

    def with_maps(self: MapsT, *, laid_onto: GroundPlane | None = None, **maps: Floats) -> MapsT:
        """The same prediction with some maps replaced.

        Args:
            laid_onto: The plane that the new ground depth lies on, if any.
            **maps: New maps, float32 (h, w), by the names in `MAPS`.
        """
        if "unmasked_ground_depth_m" not in maps:
            laid_onto = self.laid_onto
        return replace(self, maps=replace(self.maps, **maps), laid_onto=laid_onto)

    @computed_once
    def visible_ground(self) -> Mask:
        """Bool (h, w): the surface seen at this pixel is walkable (the paper's S)."""
        return self.visible_ground_probability > self.threshold

    @computed_once
    def ground(self) -> Mask:
        """Bool (h, w): the ray meets a walkable surface, seen or hidden (the paper's S*)."""
        return self.ground_probability > self.threshold

    @computed_once
    def hidden_ground(self) -> Mask:
        """Bool (h, w): there is ground, but something stands in front of it."""
        return self.ground & ~self.visible_ground

    @computed_once
    def ground_depth_m(self) -> Floats:
        """float32 (h, w), metres to the walkable surface; NaN where `ground` is False."""
        depth_m = np.full(self.map_size, np.nan, np.float32)  # half the time of `np.where`
        np.copyto(depth_m, self.unmasked_ground_depth_m, where=self.ground)
        return depth_m

    @computed_once
    def _plane_or_reason(self) -> GroundPlane | GroundPlaneError:
        """The plane, or why there is none."""
        if self.laid_onto is not None:
            return self.laid_onto
        if self.picture.panorama and self.intrinsics.source == "assumed":
            return GroundPlaneError(
                "the picture is a panorama, which no pinhole camera takes; cut a view out of it, "
                "or give the camera",
                "panorama",
            )
        if not (self.shows_ground or self.pose.everything):
            return GroundPlaneError(
                f"the picture shows no ground, with a confidence of {self._ground_confidence:.0%} "
                "that it does; use a picture that shows some, or give the camera's height, pitch "
                "and roll",
                "no_ground",
            )
        try:
            plane = find_ground_plane(
                self.unmasked_ground_depth_m, self.ground, self.intrinsics, self.pose
            )
            return replace(plane, error_m=max(plane.error_m, self.least_error_m))
        except GroundPlaneError as error:
            return error

    @computed_once
    def _ground_confidence(self) -> float:
        return curves().ground.at(ground_inputs(self.ground_probability))

    @computed_once
    def shows_ground(self) -> bool:
        """Whether the picture shows ground: without, there is no plane, and nothing is drawn.

        The masks stay those of the network, thresholded.
        """
        return shows_ground(self.ground_probability)

    @computed_once
    def confidence(self) -> Confidence:
        """How far to believe this: that there is ground, and its metres.

        Raises:
            MissingMapError: If the model file lacks masks or depths.
        """
        plane = self._plane_or_reason
        metres = math.nan
        if self.pose.everything:
            metres = 1.0
        elif isinstance(plane, GroundPlane):
            curve = curves().metres
            inputs = metres_inputs(
                plane, self.visible_depth_m, self.visible_ground, self.intrinsics, curve.used
            )
            metres = curve.at(inputs)
        return Confidence(self._ground_confidence, metres)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is odd with the picture's file, and that it shows no ground."""
        if not self.has("ground_probability") or self.shows_ground:
            return self.picture.notes
        name = self.name or "the picture"
        found = f"{name}: no ground found, with a confidence of {self._ground_confidence:.0%}"
        return (*self.picture.notes, found)

    def ground_plane(self) -> GroundPlane:
        """The plane of the ground, with the camera's height and pitch above it.

        The known part of the camera's pose holds; the rest is fitted. With all of it known, the
        plane is exact.

        Raises:
            GroundPlaneError: If the picture shows no ground, or too little to fit a plane, if the
                ground is not flat, or if the plane cannot be the ground.
        """
        plane = self._plane_or_reason
        if isinstance(plane, GroundPlaneError):
            raise GroundPlaneError(str(plane), plane.reason)
        return plane

    @property
    def map_size(self) -> Size:
        """(h, w) of the maps."""
        height, width = next(self._map(name).shape for name in MAPS if self.has(name))
        return height, width

    @property
    def image_size(self) -> Size:
        """(H, W) of the upright picture."""
        return self.picture.size

    @property
    def rgb(self) -> Rgb:
        """uint8 (H, W, 3), the upright picture at full size, decoded on first access."""
        return self.picture.rgb

    @property
    def name(self) -> str | None:
        """File name of the picture, None if it has none."""
        return self.picture.name

    @property
    def path(self) -> Path | None:
        """File of the picture, None if it was not read from a file."""
        return self.picture.path

    def at_image_size(self: MapsT) -> MapsT:
        """The same prediction with maps at the picture's full size."""
        return self.at_size(self.image_size)

    def at_size(self: MapsT, size: Size) -> MapsT:
        """The same prediction with maps at another size.

        Probabilities are interpolated before the threshold, depths as inverse depth.

        Args:
            size: (h, w) of the new maps.

        Raises:
            ValueError: If the size is not positive, or larger than that of any picture.
        """
        if size == self.map_size:
            return self
        height, width = size
        if height * width > MAX_JPEG_PIXELS:
            raise ValueError(
                f"maps of {width} x {height} pixels; no picture has more than "
                f"{MAX_JPEG_PIXELS / 1e6:.0f} million: give a smaller size"
            )
        resized = {
            name: (resize_depth if name.endswith("_m") else resize_map)(self._map(name), size)
            for name in MAPS
            if self.has(name)
        }
        return replace(
            self,
            maps=replace(self.maps, **resized),
            intrinsics=self.intrinsics.scaled(self.map_size, size),
        )
