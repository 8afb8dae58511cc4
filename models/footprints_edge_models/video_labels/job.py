"""The job of labelling a whole sequence: its frames, what one frame takes, and how it went.

Where frames are labelled is up to the runner (see :mod:`footprints_edge.parallel`). A frame whose
file is there is not labelled again, so any job can be stopped, killed and started again.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import cv2

from footprints_edge.parallel.job import ItemOutcome, ReportOutcome
from footprints_edge_models.sequences.sequence import Sequence
from footprints_edge_models.video_labels.files import (
    LabelFilesError,
    claim,
    frame_path,
    read_frame,
    remove_fragments,
    write_frame,
)
from footprints_edge_models.video_labels.footprint_masks import NOT_GROUND_PROBABILITY
from footprints_edge_models.video_labels.labeller import FrameLabels, Labeller, LabelSettings

FRAMES_PER_TASK = 8
"""On a cluster: long enough for a worker to reuse the neighbours that it has read, short enough to
spread the work."""


class LabelsFrames(Protocol):
    """What a worker labels with: :class:`labeller.Labeller`, or a stand-in."""

    def label(self, index: int) -> FrameLabels:
        """The labels of the sequence's frame at ``index``."""


@dataclass(frozen=True)
class GroundCounts:
    """Pixels of a frame's ground label, and those of them where the ground is hidden."""

    ground_px: int
    hidden_px: int

    @classmethod
    def of(cls, labels: FrameLabels) -> "GroundCounts":
        """Counts the pixels of a frame."""
        ground = labels.ground_depth_m > 0
        hidden = ground & (labels.ground_probability < NOT_GROUND_PROBABILITY)
        return cls(int(ground.sum()), int(hidden.sum()))


@dataclass(frozen=True)
class LabelJob:
    """The frames of a sequence, by index; the result of a frame is its counts of ground.

    Attributes:
        sequence: whose frames are labelled.
        settings: decide the labels.
        folder: where the labels go.
        labeller: makes what labels the frames, once per process.
    """

    sequence: Sequence
    settings: LabelSettings
    folder: Path
    labeller: Callable[[Sequence, LabelSettings], LabelsFrames] = Labeller

    def finished(self, index: int) -> GroundCounts | None:
        """The counts of a frame whose file is there and reads."""
        name = self.sequence.frames[index].name
        if not frame_path(self.folder, name).exists():
            return None
        try:
            return GroundCounts.of(read_frame(self.folder, name))
        except LabelFilesError:  # damaged: it is made again
            return None

    def start(self) -> Callable[[int], GroundCounts]:
        """The function that labels a frame and writes its file."""
        cv2.setNumThreads(1)  # there is a process for every core
        labeller = self.labeller(self.sequence, self.settings)

        def label(index: int) -> GroundCounts:
            labels = labeller.label(index)
            write_frame(self.folder, labels)
            return GroundCounts.of(labels)

        return label


@dataclass(frozen=True)
class FrameOutcome:
    """How one frame went.

    Attributes:
        name: of the frame.
        state: labelled just now, labelled before, or failed.
        reason: why it failed.
        counts: pixels of its ground label; None where it failed.
    """

    name: str
    state: Literal["done", "kept", "failed"]
    reason: str = ""
    counts: GroundCounts | None = None


LabelRunner = Callable[[LabelJob, Iterable[int], ReportOutcome[int, GroundCounts]], None]
"""Works on the job's frames, somewhere, and reports their outcomes."""


def make_labels(job: LabelJob, run: LabelRunner, report: Callable[[FrameOutcome], None]) -> None:
    """Labels every frame that has no labels yet.

    Args:
        job: what to label.
        run: where to: a function of :mod:`footprints_edge.parallel`, its workers chosen.
        report: called for every frame, those that were done before included, as they finish.

    Raises:
        FootprintsError: the sequence cannot have ground from where the settings want it, or the
            folder holds labels of another job.
    """
    job.labeller(job.sequence, job.settings)  # what is wrong with all frames stops the job here
    claim(job.folder, job.sequence, job.settings)
    frames = job.sequence.frames

    def report_frame(outcome: ItemOutcome[int, GroundCounts]) -> None:
        name = frames[outcome.item].name
        report(FrameOutcome(name, outcome.state, outcome.reason, outcome.result))

    try:
        run(job, range(len(frames)), report_frame)
    finally:
        remove_fragments(job.folder)


def hidden_share(outcomes: Iterable[FrameOutcome]) -> float | None:
    """The share of labelled ground that is hidden, over all frames; None where there is none."""
    counts = [outcome.counts for outcome in outcomes if outcome.counts is not None]
    ground_px = sum(count.ground_px for count in counts)
    return sum(count.hidden_px for count in counts) / ground_px if ground_px else None
