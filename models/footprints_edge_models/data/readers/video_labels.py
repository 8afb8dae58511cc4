"""Folders of labels that ``fp-train labels`` made."""

from collections.abc import Iterator
from pathlib import Path

from footprints_edge_models.data.labels_to_sample import label_sample
from footprints_edge_models.sample import Sample
from footprints_edge_models.video_labels.files import frame_names, read_about, read_frame


def read_video_labels(folder: Path) -> Iterator[Sample]:
    """A folder that ``fp-train labels`` made, in the order of the frames' names.

    Raises:
        LabelFilesError: a frame's file is damaged.
    """
    name = read_about(folder)["sequence"]
    for frame in frame_names(folder):
        labels = read_frame(folder, frame)
        yield label_sample(
            f"{name}/{frame}",
            labels.image,
            labels.intrinsics,
            ground_probability=labels.ground_probability,
            ground_depth_m=labels.ground_depth_m,
            visible_depth_m=labels.visible_depth_m,
            footprint_mask=labels.footprint_mask,
            moving=labels.moving,
        )
