"""A moving camera: frames with poses, the files of their depth and ground, and their neighbours.

Frames are descriptions. Nothing is read until ``read`` is called, so a sequence is small, can be
pickled, and can be sent to other processes and machines that see the same files.
"""

from collections.abc import Sequence as Many
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.mapping.floor_map import DepthFrame
from footprints_edge_models.mapping.stereo import stereo_depth_m

LEAST_HITS = 2
"""Ground of a pixel counts where more than this many frames agree on it (the paper's k)."""


_LONGEST_MESSAGE = 800


class SequenceError(FootprintsError):
    """A sequence is missing, or not laid out as expected."""

    def __init__(self, message: str) -> None:
        # it cites what stands in a file: a line without an end, signs that terminals obey
        message = "".join(
            each if each.isprintable() or each in "\n\t" else ascii(each)[1:-1] for each in message
        )
        if len(message) > _LONGEST_MESSAGE:
            message = f"{message[: _LONGEST_MESSAGE // 2]} … {message[-_LONGEST_MESSAGE // 4 :]}"
        super().__init__(message)


def read_raster(path: Path, what: str) -> NDArray[Any]:
    """The numbers of a picture with one channel, (H, W), as they are stored.

    Raises:
        SequenceError: it is missing or damaged, or has several channels.
    """
    try:
        with Image.open(path) as image:
            values = np.asarray(image)
    except Exception as error:  # Pillow's decoders raise almost anything on damaged files
        raise SequenceError(f"{path}: no readable {what} ({error})") from error
    if values.ndim != 2:
        raise SequenceError(f"{path}: a {what} has one channel, not {values.shape}")
    return values


class LazyArray(Protocol):
    """An array of a frame, read on demand."""

    def read(self) -> NDArray[np.float32]:
        """The values, float32; meaning and shape depend on the field of the frame."""


@dataclass(frozen=True)
class DepthPicture:
    """Depth as a 16-bit PNG, 0 where there is none."""

    path: Path
    metres_per_unit: float = 0.001

    def read(self) -> NDArray[np.float32]:
        """Metres along the optical axis, float32 (H, W)."""
        units = read_raster(self.path, "depth picture")
        return (units * self.metres_per_unit).astype(np.float32)


@dataclass(frozen=True)
class StereoPair:
    """Depth by matching a frame's picture with that of a second camera to its right.

    Attributes:
        left: the frame's picture.
        right: the other picture, rectified with it.
        focal_times_baseline: focal length in pixels times baseline in metres.
    """

    left: Path
    right: Path
    focal_times_baseline: float

    def read(self) -> NDArray[np.float32]:
        """Metres along the optical axis, float32 (H, W), 0 where nothing matched."""
        left, right = decode(self.left).rgb, decode(self.right).rgb
        return stereo_depth_m(left, right, self.focal_times_baseline)


@dataclass(frozen=True)
class LabelPicture:
    """Ground as a PNG of class ids, some of which are walkable."""

    path: Path
    walkable: tuple[int, ...]

    def read(self) -> NDArray[np.float32]:
        """Probability of ground, 0 or 1, float32 (H, W)."""
        return np.isin(read_raster(self.path, "label picture"), self.walkable).astype(np.float32)


@dataclass(frozen=True)
class Flow:
    """Optical flow from a frame to another of its sequence.

    Attributes:
        source: reads float32 (h, w, 2): how far each pixel moves in x and y, in its own pixels.
        to: name of the frame that it leads to.
    """

    source: LazyArray
    to: str


@dataclass(frozen=True)
class SequenceFrame:
    """One frame of a moving camera.

    Attributes:
        name: unique in the sequence; may hold slashes.
        time: the frame's number; cameras of one rig share it.
        image: the picture's file.
        intrinsics: in pixels of the picture.
        camera_to_world: (4, 4); camera axes are x right, y down, z forward.
        depth: reads metres along the optical axis, float32 (h, w), 0 where unknown.
        ground: reads the probability of visible ground, float32 (h, w), in [0, 1]; or None.
        flow: optical flow to a neighbouring frame; None computes it.
    """

    name: str
    time: int
    image: Path
    intrinsics: Intrinsics
    camera_to_world: NDArray[np.float64] = field(repr=False)
    depth: LazyArray
    ground: LazyArray | None = None
    flow: Flow | None = None

    def measured(self) -> DepthFrame:
        """The frame's depth with its pose, the camera in pixels of the depth; reads the depth."""
        depth_m = self.depth.read()
        size, camera = (depth_m.shape[0], depth_m.shape[1]), self.intrinsics
        if size != self.image_size():
            camera = camera.scaled(self.image_size(), size)
        return DepthFrame(depth_m, camera, self.camera_to_world)

    def image_size(self) -> tuple[int, int]:
        """(H, W) of the picture; reads its header only."""
        try:
            with Image.open(self.image) as image:
                return image.height, image.width
        except Exception as error:  # as in `read_raster`
            raise SequenceError(f"{self.image}: no readable picture ({error})") from error


@dataclass(frozen=True)
class InTime:
    """Neighbours are the frames shortly before and after, and the frame itself.

    Only frames whose number is a multiple of ``step`` count: so frames share their neighbours, and
    each is read once. The paper's setting for KITTI: 25 frames back, 50 forward, every second one,
    both cameras.
    """

    before: int = 25
    after: int = 50
    step: int = 2

    def of(self, frames: Many[SequenceFrame], index: int) -> list[int]:
        """Indices of the neighbours of a frame."""
        now = frames[index].time
        first, last = now - self.before, now + self.after
        return [
            i
            for i, frame in enumerate(frames)
            if frame.time == now or (first <= frame.time <= last and frame.time % self.step == 0)
        ]


@dataclass(frozen=True)
class InSpace:
    """Neighbours are all frames whose camera stands within a box around this one.

    The paper's setting for Matterport: 10 m along the world's x and y, 1 m along its z.
    """

    reach_m: tuple[float, float, float] = (10.0, 10.0, 1.0)

    def of(self, frames: Many[SequenceFrame], index: int) -> list[int]:
        """Indices of the neighbours of a frame."""
        centres = np.stack([frame.camera_to_world[:3, 3] for frame in frames])
        near = (np.abs(centres - centres[index]) < self.reach_m).all(axis=1)
        return [int(i) for i in np.flatnonzero(near)]


@dataclass(frozen=True)
class Sequence:
    """The frames of a moving camera, and their neighbours, which look at the same ground.

    Attributes:
        name: for messages and file names.
        frames: in order of time.
        neighbours: whose ground is warped into a frame.
        least_hits: the paper's k for this kind of data.
        up: direction against gravity, in the world, any length; None where unknown.
    """

    name: str
    frames: tuple[SequenceFrame, ...]
    neighbours: InTime | InSpace = InTime()
    least_hits: int = LEAST_HITS
    up: tuple[float, float, float] | None = None
