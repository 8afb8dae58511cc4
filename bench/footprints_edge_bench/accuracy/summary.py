"""Scores of many images as one: the paper's means over images, and pooled over all their pixels."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from footprints_edge_bench.accuracy.metrics import DepthScores, MaskCounts
from footprints_edge_bench.accuracy.results import ImageScores

MASK_MEASURES = ("iou", "f1", "precision", "recall")
DEPTH_MEASURES = ("a1", "rmse", "abs_rel", "sq_rel")
MEASURES = {
    "freespace": MASK_MEASURES,
    "footprint": MASK_MEASURES,
    "visible_ground": MASK_MEASURES,
    "ground_depth": DEPTH_MEASURES,
    "visible_depth": DEPTH_MEASURES,
}
"""What is measured of each part of :class:`~footprints_edge_bench.scoring.Scores`."""


@dataclass(frozen=True)
class ScoreSummary:
    """One part of one method's scores over many images.

    Attributes:
        images: how many have a score.
        means: by measure, over these images; NaN if there are none.
        pooled: by measure, of all images' pixels together; empty for depths.
    """

    images: int
    means: dict[str, float]
    pooled: dict[str, float]

    def as_json(self) -> dict[str, Any]:
        """Plain values; None for NaN."""
        return {
            "images": self.images,
            "mean": {key: plain(value) for key, value in self.means.items()},
            "pooled": {key: plain(value) for key, value in self.pooled.items()},
        }


def plain(value: float) -> float | None:
    """A number as JSON has it, which knows no NaN."""
    return None if math.isnan(value) else value


def summarise(images: Sequence[ImageScores]) -> dict[str, dict[str, ScoreSummary]]:
    """Summaries by row and part; parts that a row has on no image are left out."""
    rows = dict.fromkeys(row for scores in images for row in scores)
    return {row: _of_row([scores[row] for scores in images if row in scores]) for row in rows}


def _of_row(scores: Iterable[Any]) -> dict[str, ScoreSummary]:
    scores = list(scores)
    summaries = {}
    for part, measures in MEASURES.items():
        found = [getattr(each, part) for each in scores if getattr(each, part) is not None]
        if found:
            summaries[part] = _summary(found, measures)
    return summaries


def _summary(
    found: list[MaskCounts] | list[DepthScores], measures: tuple[str, ...]
) -> ScoreSummary:
    scored = [each for each in found if not math.isnan(getattr(each, measures[0]))]
    means = {measure: _mean([getattr(each, measure) for each in scored]) for measure in measures}
    pooled = {}
    counts = [each for each in found if isinstance(each, MaskCounts)]
    if counts:
        total = sum(counts, MaskCounts(0, 0, 0))
        pooled = {measure: float(getattr(total, measure)) for measure in measures}
    return ScoreSummary(len(scored), means, pooled)


def _mean(values: list[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan
