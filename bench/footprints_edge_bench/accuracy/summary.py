"""Summaries of many images: the paper's means over images, and scores pooled over all pixels."""

import math
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

from footprints_edge_bench.accuracy.metrics import (
    DepthScores,
    MaskCounts,
    RankingCounts,
    number_or_none,
)
from footprints_edge_bench.accuracy.results import ImageScores

MASK_MEASURES = ("iou", "f1", "precision", "recall")
DEPTH_MEASURES = ("a1", "rmse", "abs_rel", "sq_rel")
MEASURES = {
    "freespace": MASK_MEASURES,
    "footprint": MASK_MEASURES,
    "visible_ground": MASK_MEASURES,
    "ground_depth": DEPTH_MEASURES,
    "visible_depth": DEPTH_MEASURES,
    "hidden_ground": ("recall",),
    "outside": ("recall",),
    "ranking": ("auc",),
    "ground_border": ("recall",),
    "visible_border": ("recall",),
}
"""Measures of each part of :class:`~footprints_edge_bench.accuracy.scoring.MethodScores`."""


@dataclass(frozen=True)
class ScoreSummary:
    """Scores of one method over many images, for one part.

    Attributes:
        images: number of images with a score.
        means: mean over these images, by measure; NaN if there are none.
        pooled: score over the pixels of all images, by measure; empty for depths.
    """

    images: int
    means: dict[str, float]
    pooled: dict[str, float]

    def as_json(self) -> dict[str, Any]:
        """Plain values; None for NaN."""
        return {
            "images": self.images,
            "mean": {key: number_or_none(value) for key, value in self.means.items()},
            "pooled": {key: number_or_none(value) for key, value in self.pooled.items()},
        }


def summarise(images: Sequence[ImageScores]) -> dict[str, dict[str, ScoreSummary]]:
    """Summaries by row and part, without the parts that a row has on no image."""
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
    found: list[MaskCounts] | list[DepthScores] | list[RankingCounts], measures: tuple[str, ...]
) -> ScoreSummary:
    scored = [each for each in found if not math.isnan(getattr(each, measures[0]))]
    means = {measure: _mean([getattr(each, measure) for each in scored]) for measure in measures}
    pooled = {}
    counts = [each for each in found if not isinstance(each, DepthScores)]
    if counts:
        total = reduce(operator.add, counts)
        pooled = {measure: float(getattr(total, measure)) for measure in measures}
    return ScoreSummary(len(scored), means, pooled)


def _mean(values: list[float]) -> float:
    return math.fsum(values) / len(values) if values else math.nan
