"""Sources of visible ground: label files, depth, a teacher network, or one of our models.

Each is a function from a frame to the probability that a pixel shows walkable ground, float32
(h, w) at a size of its own.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge.inputs.images import decode
from footprints_edge_models.mapping.floor_map import fit_floor, ground_by_depth
from footprints_edge_models.sample import NO, UNKNOWN, YES
from footprints_edge_models.segmenter import read_segmenter
from footprints_edge_models.sequences.colmap_text import ColmapDepth
from footprints_edge_models.sequences.folders import WALKABLE
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    Sequence,
    SequenceError,
    SequenceFrame,
)
from footprints_edge_models.sequences.stray_scanner import LidarDepth

GroundSource: TypeAlias = Literal["given", "depth", "teacher", "model"]
"""The frame's own label file; the floor plane in the clip's depth; a TFLite segmenter of ADE20K;
channel 0 of a model of ours."""

UNDECIDED = 0.6
"""Probability of pixels that are neither ground to warp (above 0.75) nor obstacles (below 0.5)."""

MEASURED = (DepthPicture, LidarDepth, ColmapDepth)
"""Depth that is good enough to find the floor in; that of stereo pairs is not."""

GroundReader: TypeAlias = Callable[[SequenceFrame], NDArray[np.float32]]


def best_ground(sequence: Sequence) -> GroundSource:
    """The best source that a sequence has: its own labels, the floor in measured depth, a model."""
    if any(frame.ground is not None for frame in sequence.frames):
        return "given"
    measured = all(isinstance(frame.depth, MEASURED) for frame in sequence.frames)
    return "depth" if measured and sequence.up is not None else "model"


def ground_reader(sequence: Sequence, ground: GroundSource, source: str | None) -> GroundReader:
    """The function that reads the visible ground of a sequence's frames.

    Args:
        sequence: the sequence.
        ground: the source.
        source: the teacher's file, or the model's file or name (None for the default model).
    """
    if ground == "depth":
        return ground_on_floor(sequence)
    if ground == "teacher":
        if source is None:
            raise SequenceError("ground from a teacher needs its .tflite file")
        return teacher_ground(Path(source))
    if ground == "model":
        return model_ground(source)
    if all(frame.ground is None for frame in sequence.frames):
        raise SequenceError(
            f"{sequence.name} comes without ground segmentations; take the ground from 'depth', "
            "'teacher' or 'model'"
        )
    return given_ground


def given_ground(frame: SequenceFrame) -> NDArray[np.float32]:
    """The probability that comes with the frame.

    Raises:
        SequenceError: the frame comes without one.
    """
    if frame.ground is None:
        raise SequenceError(
            f"{frame.name} comes without a ground segmentation; take it from "
            "'depth', 'teacher' or 'model'"
        )
    return frame.ground.read()


def ground_on_floor(sequence: Sequence, every: int = 4) -> GroundReader:
    """Ground is the clip's floor plane, for level floors and measured depth.

    Args:
        sequence: the sequence.
        every: the plane is fitted to every Nth frame.

    Raises:
        SequenceError: the sequence does not say which way is up.
    """
    if sequence.up is None:
        raise SequenceError(
            f"{sequence.name}: no floor can be fitted, the sequence does not say which way is up; "
            "take the ground from 'given', 'teacher' or 'model'"
        )
    plane = fit_floor(
        (frame.measured() for frame in sequence.frames[::every]), np.array(sequence.up)
    )

    def read(frame: SequenceFrame) -> NDArray[np.float32]:
        labels = ground_by_depth(frame.measured(), plane)
        probability = np.zeros(256, np.float32)
        probability[[NO, YES, UNKNOWN]] = 0, 1, UNDECIDED
        return probability[labels]

    return read


def teacher_ground(path: Path) -> GroundReader:
    """Ground by a semantic segmenter in TFLite format: class ids of ADE20K, square input.

    Args:
        path: the .tflite file: uint8 (1, S, S, 3) RGB in, class ids (1, S, S) out.
    """
    if not path.is_file():
        raise SequenceError(f"{path}: no such file; the teacher is a segmenter in TFLite format")
    segment = read_segmenter(path)

    def read(frame: SequenceFrame) -> NDArray[np.float32]:
        return np.isin(segment(decode(frame.image).rgb), WALKABLE).astype(np.float32)

    return read


def model_ground(name: str | None) -> GroundReader:
    """Ground by one of our models (channel 0).

    Args:
        name: a file or a registered name; None for the default model.
    """
    from footprints_edge.model import load

    model = load(name, threads=1)

    def read(frame: SequenceFrame) -> NDArray[np.float32]:
        rgb = decode(frame.image).rgb
        prediction = model.predict(rgb, intrinsics=frame.intrinsics, flatten=False)
        return prediction.visible_ground_probability

    return read
