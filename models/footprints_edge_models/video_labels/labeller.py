"""The training labels of one frame of a moving camera (paper, section "Learning to predict").

The ground that its neighbours saw is warped into the frame and aggregated. The frame's own depth
gives the footprints of objects and, compared with optical flow, the moving objects.
"""

from collections import OrderedDict
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.sample import nearest, within
from footprints_edge_models.sequences.sequence import InTime, Sequence, SequenceError
from footprints_edge_models.video_labels.footprint_masks import (
    GROUND_PROBABILITY,
    footprint_pixels,
)
from footprints_edge_models.video_labels.moving_objects import (
    checked_flow_px,
    induced_flow_px,
    moving_pixels,
)
from footprints_edge_models.video_labels.visible_ground import GroundSource, ground_reader
from footprints_edge_models.video_labels.warping import aggregate, warp_depth

FARTHEST_M = 30.0
"""Ground farther from a neighbour than this is not warped: its depth is too coarse."""

_KEPT_FRAMES = 320
"""Frames cached for those that follow: 1.3 MB each at 256x448."""


@dataclass(frozen=True)
class LabelSettings:
    """Everything that decides the labels of a sequence.

    Attributes:
        size: (H, W) of the labels; None keeps the aspect, with a longest side of 512 px.
        ground: source of visible ground (see :mod:`visible_ground`).
        source: the teacher's file, or the model's file or name; None for the default model.
        as_published: warp and splat exactly as the paper's code does, half a pixel off.
    """

    size: tuple[int, int] | None = None
    ground: GroundSource = "given"
    source: str | None = None
    as_published: bool = False


@dataclass(frozen=True)
class FrameLabels:
    """The labels of one frame, all at one size (H, W).

    The walkable surface is ``ground_depth_m > 0`` or visible ground, without ``footprint_mask``.

    Attributes:
        name: of the frame.
        image: uint8 (H, W, 3), RGB.
        intrinsics: in pixels of (H, W).
        ground_probability: float32 (H, W), probability of visible ground.
        visible_depth_m: float32 (H, W), metres, 0 where unknown.
        ground_depth_m: float32 (H, W), metres, eq. 1 and 2; 0 where too few frames saw ground.
        footprint_mask: bool (H, W), footprints of objects.
        moving: bool (H, W), moving objects (the paper's 1 - mu).
    """

    name: str
    image: NDArray[np.uint8]
    intrinsics: Intrinsics
    ground_probability: NDArray[np.float32]
    visible_depth_m: NDArray[np.float32]
    ground_depth_m: NDArray[np.float32]
    footprint_mask: NDArray[np.bool_]
    moving: NDArray[np.bool_]


@dataclass(frozen=True)
class _PreparedFrame:
    """A frame as its neighbours need it, at the size of the labels."""

    image: NDArray[np.uint8]
    camera: Intrinsics
    depth_m: NDArray[np.float32]
    ground_probability: NDArray[np.float32]

    def ground_m(self) -> NDArray[np.float32]:
        """Depth (H, W) of the ground that may be warped, 0 elsewhere."""
        kept = (self.ground_probability > GROUND_PROBABILITY) & (self.depth_m < FARTHEST_M)
        return np.where(kept, self.depth_m, 0)


class Labeller:
    """Makes the labels of a sequence's frames; caches the frames that the next ones need, too."""

    def __init__(self, sequence: Sequence, settings: LabelSettings) -> None:
        """Prepares the source of visible ground.

        Raises:
            FootprintsError: The sequence cannot have ground from there, or a file is missing.
        """
        self._sequence = sequence
        self._settings = settings
        self._ground = ground_reader(sequence, settings.ground, settings.source)
        self._seen: OrderedDict[int, _PreparedFrame] = OrderedDict()

    def label(self, index: int) -> FrameLabels:
        """The labels of one frame.

        Neighbours that cannot be read are left out; the frame itself must be readable.

        Raises:
            FootprintsError: The frame's picture, depth, ground or flow is missing or broken, or
                none of its neighbours can be read.
        """
        frames = self._sequence.frames
        frame, seen = frames[index], self._prepare(index)
        size = (seen.depth_m.shape[0], seen.depth_m.shape[1])
        from_world = np.linalg.inv(frame.camera_to_world)
        warped = []
        failures = []
        for other in self._sequence.neighbours.of(frames, index):
            try:
                neighbour = self._prepare(other)
            except (FootprintsError, OSError, ValueError) as error:
                failures.append(error)
                continue
            warped.append(
                warp_depth(
                    neighbour.ground_m(),
                    neighbour.camera,
                    seen.camera,
                    from_world @ frames[other].camera_to_world,
                    size,
                    as_published=self._settings.as_published,
                )
            )
        if not warped:
            reason = f": {failures[0]}" if failures else ""
            raise SequenceError(f"{frame.name}: no neighbour to take ground from{reason}")
        return FrameLabels(
            name=frame.name,
            image=seen.image,
            intrinsics=seen.camera,
            ground_probability=seen.ground_probability,
            visible_depth_m=seen.depth_m,
            ground_depth_m=aggregate(np.stack(warped), self._sequence.least_hits),
            footprint_mask=footprint_pixels(
                seen.depth_m,
                seen.ground_probability,
                seen.camera,
                as_published=self._settings.as_published,
            ),
            moving=self._moving(index),
        )

    def _moving(self, index: int) -> NDArray[np.bool_]:
        frames = self._sequence.frames
        frame, seen = frames[index], self._prepare(index)
        other = self._flow_to(index)
        if other is None:
            return np.zeros(seen.depth_m.shape, bool)
        try:
            after = self._prepare(other)
        except (FootprintsError, OSError, ValueError):  # that frame will fail by itself
            return np.zeros(seen.depth_m.shape, bool)
        to_other = np.linalg.inv(frames[other].camera_to_world) @ frame.camera_to_world
        induced_px = induced_flow_px(seen.depth_m, seen.camera, after.camera, to_other)
        if frame.flow is not None:
            optical_px = _resized_flow(frame.flow.source.read(), seen.depth_m.shape)
            return moving_pixels(induced_px, optical_px)
        returning_px = induced_flow_px(
            after.depth_m, after.camera, seen.camera, np.linalg.inv(to_other)
        )
        optical_px = checked_flow_px(seen.image, after.image, induced_px, returning_px)
        return moving_pixels(induced_px, optical_px)

    def _flow_to(self, index: int) -> int | None:
        """The frame that the flow leads to: the stated one, else the camera's next or previous."""
        frames = self._sequence.frames
        frame = frames[index]
        if frame.flow is not None:
            wanted = [i for i, other in enumerate(frames) if other.name == frame.flow.to]
            if not wanted:
                raise SequenceError(
                    f"{frame.name}: its flow leads to {frame.flow.to}, which is not in the sequence"
                )
            return wanted[0]
        if not isinstance(self._sequence.neighbours, InTime):  # no video: nothing is followed
            return None
        # A camera's pictures stand in one folder; cameras of a rig take turns in the list.
        same = [i for i, other in enumerate(frames) if other.image.parent == frame.image.parent]
        place = same.index(index)
        if len(same) == 1:
            return None
        return same[place + 1] if place + 1 < len(same) else same[place - 1]

    def _prepare(self, index: int) -> _PreparedFrame:
        if index in self._seen:
            self._seen.move_to_end(index)
            return self._seen[index]
        frame = self._sequence.frames[index]
        image = decode(frame.image).rgb
        own = (image.shape[0], image.shape[1])
        size = self._settings.size or within(own)
        probability = self._ground(frame)
        seen = _PreparedFrame(
            image=cv2.resize(image, size[::-1], interpolation=cv2.INTER_AREA),
            camera=frame.intrinsics.scaled(own, size),
            depth_m=nearest(frame.depth.read(), size),
            ground_probability=nearest(probability, size),
        )
        self._seen[index] = seen
        if len(self._seen) > _KEPT_FRAMES:
            self._seen.popitem(last=False)
        return seen


def _resized_flow(flow_px: NDArray[np.float32], size: tuple[int, ...]) -> NDArray[np.float32]:
    """Flow (h, w, 2) in its own pixels at another size (H, W), in the pixels of that."""
    height, width = flow_px.shape[:2]
    resized: NDArray[np.float32] = cv2.resize(flow_px, size[::-1], interpolation=cv2.INTER_LINEAR)
    return resized * np.array([size[1] / width, size[0] / height], np.float32)
