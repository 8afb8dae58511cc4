"""RGB-D clips: the ground truth of a frame combines what all frames saw of the floor.

The depth of every frame is merged into one top-down map of the floor. Projected into a view, the
map says where ground is, visible or hidden ("a top-down floor map reprojected into the camera
view", paper, section "Our Footprints world model"). By the paper's definition, ground is a walkable
surface anywhere on the ray. So the floor of another room, behind a wall, is ground too if the clip
went there. Places that no frame saw are not scored.
"""

from collections.abc import Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footprints_edge.foundation.types import Mask
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.ground_truth.base import GroundTruth, Item, LabelledMask
from footprints_edge_bench.ground_truth.false_depth import seen_through

if TYPE_CHECKING:
    from footprints_edge_models.mapping.floor_map import FloorMap
    from footprints_edge_models.sequences.sequence import Sequence, SequenceFrame

_PLANE_STRIDE = 4
"""The floor plane is fitted to every Nth frame."""

_APART = range(4, 31, 3)
"""Distances, in frames, of those that may refute a frame's depth: nearer ones share its errors."""


def is_clip(folder: Path) -> bool:
    """Whether a folder holds a clip with poses."""
    return (folder / "sequence.json").is_file()


def read_clip(folder: Path) -> Iterator[Item]:
    """The frames of a clip; CONTRIBUTING.md describes the layout.

    The floor map is built when the first frame is loaded.

    Raises:
        SequenceError: the folder is not laid out as expected.
    """
    clip = open_clip(folder)
    files = (folder / "sequence.json", *sorted((folder / "depth").rglob("*.png")))
    for frame in clip.sequence.frames:
        yield Item(frame.name, partial(clip.ground_truth, frame), files)


def open_clip(folder: Path) -> "Clip":
    """A clip; only its description is read yet.

    Raises:
        SequenceError: the folder is not laid out as expected.
    """
    from footprints_edge_models.sequences.folders import read_sequence_folder

    return Clip(read_sequence_folder(folder))


class Clip:
    """A clip and the map of its floor."""

    def __init__(self, sequence: "Sequence") -> None:
        """Takes a sequence; nothing is read until the floor map is needed."""
        self.sequence = sequence

    @cached_property
    def floor_map(self) -> "FloorMap":
        """Map of the floor from all frames."""
        from footprints_edge_models.mapping.floor_map import build_floor_map, fit_floor

        frames = [frame.measured() for frame in self.sequence.frames]
        up = np.array(self.sequence.up or (0, 1, 0), dtype=np.float64)
        return build_floor_map(frames, fit_floor(frames[::_PLANE_STRIDE], up))

    def ground_truth(self, frame: "SequenceFrame") -> GroundTruth:
        """The ground truth of a frame."""
        from footprints_edge_models.mapping.floor_map import FREE, OCCUPIED, ground_by_depth
        from footprints_edge_models.sample import UNKNOWN, YES

        view = frame.measured()
        cells, floor_depth_m = self.floor_map.project(view)
        seen = ground_by_depth(view, self.floor_map.plane)
        visible = seen == YES
        ground = (cells == FREE) | visible
        above_horizon = floor_depth_m <= 0
        return GroundTruth(
            frame.image,
            (cells.shape[0], cells.shape[1]),
            frame.intrinsics,
            LabelledMask(visible, seen != UNKNOWN),
            LabelledMask(ground, ground | (cells == OCCUPIED) | above_horizon),
            view.depth_m,
            np.where(ground, floor_depth_m, 0).astype(np.float32),
            convex_hull(visible),
            false_depth=partial(self._false_depth, frame),
        )

    def _false_depth(self, frame: "SequenceFrame") -> Mask:
        """Where frames some way before and after look through the frame's depth."""
        frames = self.sequence.frames
        at = next(place for place, each in enumerate(frames) if each is frame)
        places = (at + apart for distance in _APART for apart in (-distance, distance))
        others = (frames[place].measured() for place in places if 0 <= place < len(frames))
        return seen_through(frame.measured(), others)
