"""RGB-D clips with poses: a folder with ``sequence.json``, ``images/`` and ``depth/``."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from footprints_edge.inputs.images import decode
from footprints_edge_models.mapping.floor_map import (
    FREE,
    OCCUPIED,
    build_floor_map,
    fit_floor,
    ground_by_depth,
)
from footprints_edge_models.sample import NO, UNSEEN, YES, Sample, shrunk
from footprints_edge_models.sequences.folders import read_sequence_folder

MOST_BEHIND_M = 3.0
"""Floor farther than this behind what is seen (the next room, say) cannot be inferred: UNSEEN."""


def read_rgbd_clip(folder: Path) -> Iterator[Sample]:
    """A folder with ``sequence.json``, ``images/`` and ``depth/`` (16-bit millimetres).

    Visible ground lies on the floor plane, by depth. Ground, seen or hidden, and its depth come
    from the floor map of the whole clip.
    """
    sequence = read_sequence_folder(folder)
    frames = [entry.measured() for entry in sequence.frames]
    plane = fit_floor(frames[::4], np.array(sequence.up))
    floor_map = build_floor_map(frames, plane)
    for entry, frame in zip(sequence.frames, frames, strict=True):
        cells, floor_depth_m = floor_map.project(frame)
        visible = ground_by_depth(frame, plane)
        gap_m = floor_depth_m - np.where(frame.depth_m > 0, frame.depth_m, floor_depth_m)
        reachable = (floor_depth_m > 0) & (floor_depth_m < 12) & (gap_m < MOST_BEHIND_M)
        ground = np.full(visible.shape, UNSEEN, np.uint8)
        ground[(cells == OCCUPIED) | (floor_depth_m <= 0)] = NO
        ground[(cells == FREE) & reachable] = YES
        ground[visible == YES] = YES
        yield shrunk(
            Sample(
                f"{folder.name}/{entry.name}",
                decode(entry.image).rgb,
                entry.intrinsics,
                visible,
                ground,
                frame.depth_m.astype(np.float16),
                np.where(ground == YES, floor_depth_m, 0).astype(np.float16),
            )
        )
