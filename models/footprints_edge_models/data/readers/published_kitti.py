"""KITTI's training data published with the paper, as samples; see :mod:`sequences.kitti`."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from footprints_edge.inputs.images import decode
from footprints_edge_models.data.labels_to_sample import label_sample
from footprints_edge_models.sample import Sample
from footprints_edge_models.sequences.kitti import (
    LEFT,
    RIGHT,
    Disparity,
    disparity_name,
    rig_of,
)
from footprints_edge_models.sequences.npy_files import FirstChannel, NpyFile
from footprints_edge_models.sequences.sequence import SequenceError

SIDES = {"l": LEFT, "r": RIGHT}
"""How the published splits call the cameras."""
DISPARITY_BIAS_PX = 1.25
"""Published training subtracts it from the disparities, in pixels of ``TRAINING_WIDTH_PX``; the
published labelling does not."""


def read_kitti_training(raw: Path, published: Path, split: Iterable[str]) -> Iterator[Sample]:
    """The published labels as training samples.

    Args:
        raw: folder of KITTI raw, for the pictures.
        published: folder or zip of the published training data.
        split: lines ``drive frame side`` with side ``l`` or ``r``, as the published splits have
            them.

    Raises:
        SequenceError: a line, a picture or a label is not as published.
    """
    for line in filter(None, map(str.strip, split)):
        drive, time, camera = _split_line(line)
        folder = raw / drive / camera / "data"
        paths = (folder / f"{time:010d}{suffix}" for suffix in (".jpg", ".png"))
        image_path = next((path for path in paths if path.is_file()), None)
        if image_path is None:
            raise SequenceError(f"{folder}: no picture {time:010d}.jpg or .png")
        rig = rig_of(raw, drive, image_path)

        def label(kind: str, place: str = f"{drive}/{camera}/data/{time:010d}.npy") -> NpyFile:
            return NpyFile(published, f"{kind}/{place}")

        disparity = NpyFile(published, disparity_name(drive, camera, time))
        depth = Disparity(disparity, rig.focal_per_width, rig.baseline_m, DISPARITY_BIAS_PX)
        mask, moving = label("depth_masks"), label("moving_objects")
        yield label_sample(
            f"{drive}/{camera}/{time:010d}",
            decode(image_path).rgb,
            rig.intrinsics,
            ground_probability=FirstChannel(label("ground_seg")).read(),
            ground_depth_m=np.squeeze(label("hidden_depths").read()),
            visible_depth_m=depth.read(),
            footprint_mask=np.squeeze(mask.read()) > 0 if mask.exists() else None,
            moving=np.squeeze(moving.read()) > 0 if moving.exists() else None,
        )


def _split_line(line: str) -> tuple[str, int, str]:
    try:
        drive, frame, side = line.split()
        return drive, int(frame), SIDES[side]
    except (ValueError, KeyError) as error:
        raise SequenceError(
            f"the line {line!r} is not 'drive frame side' with a side of l or r, such as "
            "'2011_09_26/2011_09_26_drive_0001_sync 5 l'"
        ) from error
