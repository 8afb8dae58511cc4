"""Image sizes and learning rates over a run: warm-up, constant, then a decay to zero (WSD).

While the rate is constant the end need not be known: a decay can begin at any checkpoint, and gives
finished weights (Hu et al., MiniCPM, 2024; Haegele et al., NeurIPS 2024). A decay of the whole run
is the usual cosine.
"""

import math
from dataclasses import dataclass

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.size_text import parse_size


class TrainingError(FootprintsError):
    """A run cannot be started or resumed as asked."""


@dataclass(frozen=True)
class ScheduleStage:
    """Some steps at one base size (H, W)."""

    size: tuple[int, int]
    steps: int

    @classmethod
    def parse(cls, text: str) -> "ScheduleStage":
        """From ``HxW:STEPS``.

        Raises:
            TrainingError: not of that form, or sides that are no multiples of 32.
        """
        size_text, _, steps = text.partition(":")
        try:
            stage = cls(parse_size(size_text), int(steps))
        except ValueError as error:
            raise TrainingError(
                f"schedule {text!r}: write it as HxW:STEPS, such as 192x320:1800"
            ) from error
        height, width = stage.size
        if height % 32 or width % 32 or stage.steps < 1:
            raise TrainingError(f"schedule {text!r}: sides are multiples of 32, steps at least 1")
        return stage


def size_at(schedule: tuple[ScheduleStage, ...], step: int) -> tuple[int, int]:
    """The base size of a step; the last stage's beyond the end."""
    for stage in schedule:
        step -= stage.steps
        if step < 0:
            return stage.size
    return schedule[-1].size


def decayed_by_steps(step: int, total: int, *, warmup: int, decay: float) -> float:
    """How much of the decay lies behind, 0 before it begins and 1 at the end.

    Args:
        step: steps taken.
        total: steps of the run.
        warmup: steps of linear warm-up, before which no decay begins.
        decay: length of the decay as a share of the run.
    """
    begin = max(warmup, total - round(decay * total))
    return 1.0 if step >= total else max(0.0, (step - begin) / max(1, total - begin))


def decayed_by_time(share: float, *, decay: float) -> float:
    """The same, for a run that is given time: ``share`` of it has passed."""
    return min(1.0, max(0.0, (share - (1 - decay)) / decay))


def rate_factor(step: int, decayed: float, *, warmup: int) -> float:
    """Learning rate as a share of the peak: linear warm-up, constant, cosine to zero."""
    warm = min(1.0, (step + 1) / warmup) if warmup else 1.0
    return warm * 0.5 * (1 + math.cos(math.pi * decayed))
