"""Matterport3D's training data published with the paper, as samples."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from footprints_edge.inputs.images import decode
from footprints_edge_models.data.labels_to_sample import label_sample
from footprints_edge_models.sample import Sample
from footprints_edge_models.sequences.matterport import (
    METRES_PER_UNIT,
    depth_path,
    intrinsics_of,
)
from footprints_edge_models.sequences.npy_files import FirstChannel, NpyFile
from footprints_edge_models.sequences.sequence import DepthPicture, SequenceError

NO_HIDDEN_DEPTH_M = 0.1
"""What the published hidden depths hold where there is none."""
FARTHEST_HIDDEN_M = 10.0
"""Published hidden depths from here on do not count."""


def read_matterport_training(raw: Path, published: Path, split: Iterable[str]) -> Iterator[Sample]:
    """The published labels as training samples.

    Args:
        raw: folder of the scans, for pictures, depth and intrinsics.
        published: folder or zip of the published training data.
        split: lines ``scan pos height direction``, as the published splits have them.

    Raises:
        SequenceError: a line, a picture or a label is not as published.
    """
    for line in filter(None, map(str.strip, split)):
        scan, pos, height, direction = _split_line(line)
        folder = raw / scan / scan
        name = f"{scan}/data/{pos}_{height}_{direction}.npy"
        hidden_m = np.squeeze(NpyFile(published, f"hidden_depth/{name}").read())
        valid = (hidden_m > NO_HIDDEN_DEPTH_M) & (hidden_m < FARTHEST_HIDDEN_M)
        mask = NpyFile(published, f"depth_masks/{name}")
        image = folder / "matterport_color_images" / f"{pos}_i{height}_{direction}.jpg"
        depth = DepthPicture(depth_path(folder, pos, height, direction), METRES_PER_UNIT)
        yield label_sample(
            f"{scan}/{pos}_{height}_{direction}",
            decode(image).rgb,
            intrinsics_of(folder, pos, height),
            ground_probability=FirstChannel(NpyFile(published, f"ground_seg/{name}")).read(),
            ground_depth_m=np.where(valid, hidden_m, 0),
            visible_depth_m=depth.read(),
            footprint_mask=np.squeeze(mask.read()) > 0 if mask.exists() else None,
        )


def _split_line(line: str) -> tuple[str, str, int, int]:
    try:
        scan, pos, height, direction = line.split()
        return scan, pos, int(height), int(direction)
    except ValueError as error:
        raise SequenceError(
            f"the line {line!r} is not 'scan pos height direction', such as "
            "'2azQ1b91cZZ fe0f8990834148809dc84feffa5797eb 1 1'"
        ) from error
