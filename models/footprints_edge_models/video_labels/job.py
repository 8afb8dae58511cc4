"""Making the labels of a whole sequence: what the job is, one frame of it, and how it went.

The engines (:mod:`processes` on one machine, :mod:`on_ray` on many) only decide where frames
are labelled. A frame whose file is there is not labelled again, so any job can be stopped, killed
and started anew.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Protocol

import cv2
import numpy as np

from footprints_edge.errors import FootprintsError
from footprints_edge_models.sequences.sequence import Sequence
from footprints_edge_models.video_labels.files import (
    LabelFilesError,
    claim,
    frame_path,
    read_frame,
    write_frame,
)
from footprints_edge_models.video_labels.labeller import FrameLabels, Labeller, LabelSettings
from footprints_edge_models.video_labels.training_targets import NOT_GROUND_PROBABILITY


class LabelsFrames(Protocol):
    """What a worker labels with: :class:`labeller.Labeller`, or a stand-in."""

    def label(self, index: int) -> FrameLabels:
        """The labels of the sequence's frame at ``index``."""


@dataclass(frozen=True)
class LabelJob:
    """All that a worker process needs; it can be pickled.

    Attributes:
        sequence: whose frames are labelled.
        settings: decide the labels.
        folder: where they go.
        labeller: makes what labels the frames, once a process.
    """

    sequence: Sequence
    settings: LabelSettings
    folder: Path
    labeller: Callable[[Sequence, LabelSettings], LabelsFrames] = Labeller


@dataclass(frozen=True)
class FrameOutcome:
    """How one frame went.

    Attributes:
        name: the frame's.
        state: labelled just now, labelled before, or neither.
        reason: why it failed.
        ground_px: pixels of its ground label.
        hidden_px: those of them where the ground is hidden.
    """

    name: str
    state: Literal["done", "kept", "failed"]
    reason: str = ""
    ground_px: int = 0
    hidden_px: int = 0


Report = Callable[[FrameOutcome], None]
"""Told about every frame as soon as it is known how it went, in the order of finishing."""


class LabelWorker:
    """What stays in a worker process from frame to frame."""

    def __init__(self, job: LabelJob) -> None:
        """Nothing is loaded yet, so nothing can fail here."""
        cv2.setNumThreads(1)  # there is a process for every core
        self._job = job
        self._labeller: LabelsFrames | None = None

    def label(self, index: int) -> FrameOutcome:
        """Labels a frame and writes its file, unless the file is there; raises nothing."""
        job, name = self._job, self._job.sequence.frames[index].name
        try:
            if (kept := finished(job, index)) is not None:
                return kept
            if self._labeller is None:
                self._labeller = job.labeller(job.sequence, job.settings)
            labels = self._labeller.label(index)
            write_frame(job.folder, labels)
        except (FootprintsError, OSError) as error:
            return FrameOutcome(name, "failed", str(error))
        except Exception as error:  # whatever it is, the other frames still get their labels
            return FrameOutcome(name, "failed", f"{type(error).__name__}: {error}")
        return _counted(labels, "done")


def finished(job: LabelJob, index: int) -> FrameOutcome | None:
    """The outcome of a frame whose file is there and reads; None for one that is still to do."""
    name = job.sequence.frames[index].name
    if not frame_path(job.folder, name).exists():
        return None
    try:
        return _counted(read_frame(job.folder, name), "kept")
    except LabelFilesError:  # damaged: it is made again
        return None


def prepare(job: LabelJob, report: Report) -> list[int]:
    """Finds out whether the job can be done at all, claims its folder, and says what is to do.

    Returns:
        The frames that have no labels yet, in order; the others are reported.

    Raises:
        FootprintsError: the sequence cannot have ground from where the settings want it, or the
            folder holds labels of another job.
    """
    job.labeller(job.sequence, job.settings)  # what is wrong with all frames stops the job here
    claim(job.folder, job.sequence, job.settings)
    to_do = []
    for index in range(len(job.sequence.frames)):
        kept = finished(job, index)
        if kept is None:
            to_do.append(index)
        else:
            report(kept)
    return to_do


def in_this_run(outcome: FrameOutcome) -> FrameOutcome:
    """What an engine reports of a frame that was to do.

    A worker that died may have finished the frame first; then its second try found the file.
    """
    return replace(outcome, state="done") if outcome.state == "kept" else outcome


def hidden_share(outcomes: Iterable[FrameOutcome]) -> float | None:
    """How much of the labelled ground is hidden, over all frames; None where there is none."""
    counts = [(outcome.ground_px, outcome.hidden_px) for outcome in outcomes]
    ground_px = sum(ground for ground, _ in counts)
    return sum(hidden for _, hidden in counts) / ground_px if ground_px else None


def in_runs(indices: list[int], parts: int) -> Iterator[list[int]]:
    """The same in so many contiguous parts: neighbours of one frame are those of the next."""
    for part in np.array_split(np.array(indices, int), min(parts, len(indices)) or 1):
        if len(part):
            yield part.tolist()


def _counted(labels: FrameLabels, state: Literal["done", "kept"]) -> FrameOutcome:
    ground = labels.ground_depth_m > 0
    hidden = ground & (labels.ground_probability < NOT_GROUND_PROBABILITY)
    return FrameOutcome(
        labels.name, state, ground_px=int(ground.sum()), hidden_px=int(hidden.sum())
    )
