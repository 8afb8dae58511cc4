"""A stand-in for the labeller that worker processes can import: it says in a file what it does,
and fails or dies where it is told to."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.video_labels.labeller import FrameLabels

SIZE = (12, 16)


def labels_of(name, index):
    """Ground in the lower half, hidden in its right half; what the depths are depends on index."""
    ground = np.zeros(SIZE, bool)
    ground[6:] = True
    visible = ground.copy()
    visible[:, 8:] = False
    return FrameLabels(
        name,
        np.full((*SIZE, 3), 10 * (index % 20), np.uint8),
        Intrinsics(20.0, 21.0, 7.5, 5.5),
        np.where(visible, 0.9, 0.1).astype(np.float32),
        np.full(SIZE, 3.0 + index, np.float32),
        np.where(ground, 1.5 + index, 0).astype(np.float32),
        np.zeros(SIZE, bool),
        np.zeros(SIZE, bool),
    )


@dataclass(frozen=True)
class Scripted:
    """Makes labellers that write "frame pid" to the log whenever they label."""

    log: Path
    fails_at: tuple[str, ...] = ()
    dies_at: tuple[str, ...] = ()
    dies_once_at: tuple[str, ...] = ()
    refuses: str = ""
    pause_s: float = 0.0

    def __call__(self, sequence, _settings):
        if self.refuses:
            raise FootprintsError(self.refuses)
        return ScriptedLabeller(self, sequence)

    def computed(self):
        """(frame, pid) of every time that a frame was labelled."""
        lines = self.log.read_text().split() if self.log.exists() else []
        return list(zip(lines[::2], map(int, lines[1::2]), strict=False))


class ScriptedLabeller:
    def __init__(self, script, sequence):
        self.script = script
        self.frames = sequence.frames

    def label(self, index):
        name, script = self.frames[index].name, self.script
        first = name not in [frame for frame, _ in script.computed()]
        with script.log.open("a") as log:
            log.write(f"{name} {os.getpid()}\n")
        time.sleep(script.pause_s)
        if name in script.dies_at or (name in script.dies_once_at and first):
            os.kill(os.getpid(), signal.SIGKILL)
        if name in script.fails_at:
            raise FootprintsError(f"{name}.png: no such file")
        return labels_of(name, index)
